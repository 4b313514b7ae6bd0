//! Lines, dots, texts and an image in a plane whose y points down.

use std::io::Write;

use rerun::{Color, Image, LineStrips2D, Points2D};

use super::super::Error;
use super::super::encode::RrdWriter;
use super::super::style::ui;
use super::super::table::put_static;

/// Width of what is drawn, in its own units.
pub const WIDTH: f32 = 300.0;
/// Its height.
pub const HEIGHT: f32 = 180.0;
/// Room to the left, for values.
pub const LEFT: f32 = 40.0;
/// Room below, for values and the key's name.
pub const BELOW: f32 = 46.0;
/// Room above and to the right.
pub const ABOVE: f32 = 30.0;

/// More values than this along an axis are not all written.
const MOST_TICKS: usize = 11;

/// A picture being drawn.
#[derive(Default)]
pub struct Drawing {
    image: Option<(Vec<u8>, [u32; 2])>,
    strips: Vec<(Vec<[f32; 2]>, Color)>,
    dots: Vec<([f32; 2], Color)>,
    texts: Vec<([f32; 2], String)>,
}

impl Drawing {
    /// An image, from the upper left corner on, three bytes a pixel.
    pub fn image(&mut self, pixels: Vec<u8>, resolution: [u32; 2]) {
        self.image = Some((pixels, resolution));
    }

    /// A line through some points.
    pub fn line(&mut self, points: Vec<[f32; 2]>, color: Color) {
        self.strips.push((points, color));
    }

    /// A dot.
    pub fn dot(&mut self, at: [f32; 2], color: Color) {
        self.dots.push((at, color));
    }

    /// A text.
    pub fn text(&mut self, at: [f32; 2], text: String) {
        self.texts.push((at, text));
    }

    /// Writes it to an entity.
    pub fn put<W: Write>(&self, entity: &str, out: &mut RrdWriter<W>) -> Result<(), Error> {
        if let Some((pixels, resolution)) = &self.image {
            let image = Image::from_rgb24(pixels.clone(), *resolution).with_draw_order(-1.0);
            put_static(format!("{entity}/cells"), &image, out)?;
        }
        if !self.strips.is_empty() {
            let lines = LineStrips2D::new(self.strips.iter().map(|(points, _)| points.clone()))
                .with_colors(self.strips.iter().map(|(_, color)| *color))
                .with_radii([ui(1.5)])
                .with_draw_order(1.0);
            put_static(format!("{entity}/lines"), &lines, out)?;
        }
        if !self.dots.is_empty() {
            let dots = Points2D::new(self.dots.iter().map(|(at, _)| *at))
                .with_colors(self.dots.iter().map(|(_, color)| *color))
                .with_radii([ui(3.5)])
                .with_draw_order(2.0);
            put_static(format!("{entity}/dots"), &dots, out)?;
        }
        if !self.texts.is_empty() {
            let texts = Points2D::new(self.texts.iter().map(|(at, _)| *at))
                .with_labels(self.texts.iter().map(|(_, text)| text.as_str()))
                .with_show_labels(true)
                .with_colors([Color::from_rgb(0xe0, 0xe2, 0xe6)])
                .with_radii([ui(0.5)])
                .with_draw_order(3.0);
            put_static(format!("{entity}/texts"), &texts, out)?;
        }
        Ok(())
    }
}

/// Which of `count` values along an axis are written: the ends, and evenly between them.
pub fn ticks(count: usize) -> impl Iterator<Item = usize> {
    let stride = count.div_ceil(MOST_TICKS).max(1);
    (0..count).step_by(stride)
}
