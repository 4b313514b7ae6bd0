//! How much of the walls a map's lines cover, and how far they go on beyond.

use crate::core::geometry::unit;
use crate::core::tmam::feature::{MapFeature, Segment, Shape};
use crate::core::world::Reflector;
use crate::tools::evaluate::matching::TrueLine;
use crate::tools::evaluate::truth::Truth;

/// Lengths of lines and walls beside each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths {
    /// Share of the visible walls' length beside lines; `None` without such walls.
    pub covered: Option<f64>,
    /// Length of lines on walls that lies beside none, metres.
    pub overrun: f64,
}

impl Lengths {
    /// Of a map's lines.
    pub fn new(features: &[&MapFeature], truth: &Truth) -> Self {
        let walls = truth.world().walls();
        // By wall the ways along it, by line the ways along that.
        let mut on_walls = vec![Vec::new(); walls.len()];
        let mut overrun = 0.0;
        for feature in features {
            let Shape::Line(segment) = &feature.shape else {
                continue;
            };
            let mut beside = Vec::new();
            for (reflector, ..) in truth.candidates(&feature.shape) {
                let index = reflector.index();
                if let (Some(wall), Some(ways)) = (walls.get(index), on_walls.get_mut(index)) {
                    let line = TrueLine::of(wall);
                    let (low, high) = line.beside(segment);
                    ways.push((low, high));
                    beside.push(along(segment, &line, low, high));
                }
            }
            if !beside.is_empty() {
                overrun += (2.0 * segment.half_length - union(&mut beside)).max(0.0);
            }
        }
        let (mut covered, mut whole) = (0.0, 0.0);
        for (index, (wall, ways)) in walls.iter().zip(&mut on_walls).enumerate() {
            if truth.is_visible(Reflector::Line(index)) {
                covered += union(ways);
                whole += (wall.end - wall.start).norm();
            }
        }
        Self {
            covered: (whole > 0.0).then(|| covered / whole),
            overrun,
        }
    }
}

/// A part of a wall as ways along a segment from its middle.
fn along(segment: &Segment, wall: &TrueLine, low: f64, high: f64) -> (f64, f64) {
    let axis = unit(segment.theta + std::f64::consts::FRAC_PI_2);
    let way = |place: f64| (wall.at(place) - segment.mid).dot(&axis);
    let (a, b) = (way(low), way(high));
    let within = |way: f64| way.min(segment.half_length).max(-segment.half_length);
    (within(a.min(b)), within(a.max(b)))
}

/// The length of the union of intervals.
fn union(parts: &mut [(f64, f64)]) -> f64 {
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut reached = f64::NEG_INFINITY;
    parts
        .iter()
        .map(|(low, high)| {
            let new = (high - low.max(reached)).max(0.0);
            reached = reached.max(*high);
            new
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_intervals_count_once() {
        assert_eq!(union(&mut []), 0.0);
        assert_eq!(
            union(&mut [(4.0, 5.0), (0.5, 1.0), (0.0, 2.0), (1.5, 3.0)]),
            4.0
        );
        assert_eq!(union(&mut [(1.0, 0.5)]), 0.0);
    }
}
