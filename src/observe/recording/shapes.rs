//! Strips and dots with names, as rows of a table.

use rerun::{Color, LineStrips2D, Points2D, SerializationResult, SerializedComponentColumn};

use super::table::Instance;

/// A line through some places.
pub struct Strip {
    /// The places, as they are recorded.
    pub points: Vec<[f32; 2]>,
    /// Its colour; in tables without colours, the entity's.
    pub color: Option<Color>,
    /// What the viewer shows when it is pointed at or selected.
    pub label: String,
}

/// A place.
pub struct Dot {
    /// As it is recorded.
    pub position: [f32; 2],
    /// See [`Strip::color`].
    pub color: Option<Color>,
    /// See [`Strip::label`].
    pub label: String,
}

impl Instance for Strip {
    fn columns(
        strips: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let colors: Option<Vec<Color>> = strips.iter().map(|strip| strip.color).collect();
        let (points, labels): (Vec<_>, Vec<_>) =
            strips.into_iter().map(|s| (s.points, s.label)).unzip();
        let mut all = LineStrips2D::update_fields()
            .with_strips(points)
            .with_labels(labels);
        if let Some(colors) = colors {
            all = all.with_colors(colors);
        }
        Ok(all.columns(lengths.iter().copied())?.collect())
    }
}

impl Instance for Dot {
    fn columns(
        dots: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let colors: Option<Vec<Color>> = dots.iter().map(|dot| dot.color).collect();
        let (positions, labels): (Vec<_>, Vec<_>) =
            dots.into_iter().map(|d| (d.position, d.label)).unzip();
        let mut all = Points2D::update_fields()
            .with_positions(positions)
            .with_labels(labels);
        if let Some(colors) = colors {
            all = all.with_colors(colors);
        }
        Ok(all.columns(lengths.iter().copied())?.collect())
    }
}
