//! A picture of a sweep: lines, dots, texts and an image in a plane whose y points down, under a title.

use rerun::{Color, Image, LineStrips2D, Points2D};

use crate::observe::drawing::{DrawnCell, DrawnColumn, DrawnGrid};
use crate::observe::recording::canvas::Canvas;
use crate::observe::recording::entity::ui;
use crate::observe::recording::style;
use crate::observe::viewer::Error;

/// Width of what is drawn, in its own units.
pub const WIDTH: f32 = 300.0;
/// Its height.
pub const HEIGHT: f32 = 240.0;
/// Room to the left, for values.
pub const LEFT: f32 = 62.0;
/// Room below, for values and the key's name.
pub const BELOW: f32 = 46.0;
/// Room above, for a key's name.
pub const ABOVE: f32 = 34.0;
/// Room to the right, for half a value.
pub const RIGHT: f32 = 24.0;

// The viewer writes texts in a size of its own, whatever the zoom. These are in the drawing's units for
// four pictures in a window of 1600 x 1000; in a smaller one texts take more.
/// Width of a character.
const CHARACTER: f32 = 5.6;
/// What the box around a text adds to it.
const BOX: f32 = 10.0;
/// Height of a text with its box.
const LINE: f32 = 18.0;
/// The viewer hangs a text below its point: how far the text's middle is from it.
const RISE: f32 = 11.0;

const TEXT: Color = Color(rerun::Rgba32::from_rgb(0xe0, 0xe2, 0xe6));

/// The colour of the best cells.
pub const BEST: Color = style::BOUND;
/// The colour of what is configured.
pub const CONFIGURED: Color = style::rgb(0xff, 0xff, 0xff);

/// A picture being drawn.
#[derive(Default)]
pub struct Drawing {
    image: Option<(Vec<u8>, [u32; 2])>,
    strips: Vec<(Vec<[f32; 2]>, Color)>,
    dots: Vec<([f32; 2], Color)>,
    texts: Vec<([f32; 2], String)>,
    whispers: Vec<([f32; 2], String)>,
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

    /// A text around a place.
    pub fn text(&mut self, [x, y]: [f32; 2], text: String) {
        self.texts.push(([x, y - RISE], text));
    }

    /// A text that ends left of a place.
    pub fn text_before(&mut self, [x, y]: [f32; 2], text: String) {
        self.text([x - width(&text) / 2.0, y], text);
    }

    /// A text that begins at a place.
    pub fn text_from(&mut self, [x, y]: [f32; 2], text: String) {
        self.text([x + width(&text) / 2.0, y], text);
    }

    /// A text that is there for who points at its place.
    pub fn whisper(&mut self, at: [f32; 2], text: String) {
        self.whispers.push((at, text));
    }

    /// Writes it to an entity.
    pub fn put(&self, entity: &str, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        if let Some((pixels, resolution)) = &self.image {
            let image = Image::from_rgb24(pixels.clone(), *resolution).with_draw_order(-1.0);
            canvas.put(format!("{entity}/cells"), &image)?;
        }
        if !self.strips.is_empty() {
            let lines = LineStrips2D::new(self.strips.iter().map(|(points, _)| points.clone()))
                .with_colors(self.strips.iter().map(|(_, color)| *color))
                .with_radii([ui(1.5)])
                .with_draw_order(1.0);
            canvas.put(format!("{entity}/lines"), &lines)?;
        }
        if !self.dots.is_empty() {
            let dots = Points2D::new(self.dots.iter().map(|(at, _)| *at))
                .with_colors(self.dots.iter().map(|(_, color)| *color))
                .with_radii([ui(3.5)])
                .with_draw_order(2.0);
            canvas.put(format!("{entity}/dots"), &dots)?;
        }
        for (name, texts, shown, size) in [
            ("texts", &self.texts, true, 0.1),
            ("values", &self.whispers, false, 1.5),
        ] {
            if !texts.is_empty() {
                let points = Points2D::new(texts.iter().map(|(at, _)| *at))
                    .with_labels(texts.iter().map(|(_, text)| text.as_str()))
                    .with_show_labels(shown)
                    .with_colors([TEXT])
                    .with_radii([ui(size)])
                    .with_draw_order(3.0);
                canvas.put(format!("{entity}/{name}"), &points)?;
            }
        }
        Ok(())
    }
}

/// One picture under its title.
pub struct Picture {
    pub title: String,
    /// Whether it shows the same number everywhere.
    pub is_flat: bool,
    pub drawing: Drawing,
}

impl Picture {
    /// A drawing of a column whose numbers lie in a range.
    pub fn new(column: &DrawnColumn, [low, high]: [f64; 2], drawing: Drawing) -> Self {
        let (name, decimals) = (&column.heading, column.decimals);
        let better = if column.low_is_better { "low" } else { "high" };
        let texts = [low, high].map(|x| format!("{:.decimals$}", x * column.scale));
        let [first, last] = &texts;
        Self {
            title: if first == last {
                format!("{name}: {first} everywhere")
            } else {
                format!("{name}: {first} to {last}, {better} is better")
            },
            is_flat: high <= low,
            drawing,
        }
    }
}

/// The least and the greatest of some numbers.
pub fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    })
}

/// The places, on some axes, of the cells that are best; none where all are alike.
pub fn best<const N: usize>(grid: &DrawnGrid, axes: [usize; N]) -> Vec<[usize; N]> {
    let best = grid.cells.iter().take(grid.best);
    let mut places: Vec<[usize; N]> = best.map(|cell| places(cell, axes)).collect();
    places.sort_unstable();
    places.dedup();
    places
}

/// The places of a cell on some axes.
pub fn places<const N: usize>(cell: &DrawnCell, axes: [usize; N]) -> [usize; N] {
    axes.map(|axis| cell.places.get(axis).copied().unwrap_or_default())
}

/// How wide a text is written.
fn width(text: &str) -> f32 {
    text.chars().count() as f32 * CHARACTER + BOX
}

/// Whether texts have room in fields of this size.
pub fn have_room(texts: &[String], [across, down]: [f32; 2]) -> bool {
    let widest = texts.iter().map(|text| width(text)).fold(0.0, f32::max);
    widest <= across && LINE <= down
}

/// Which of the values along an axis are written, from the first on, so that none covers another:
/// places and values, whose texts stand beside or above each other.
pub fn ticks(
    values: impl Iterator<Item = (f32, f64)>,
    beside: bool,
) -> impl Iterator<Item = (f32, f64)> {
    let values: Vec<(f32, f64)> = values.collect();
    let widths = values.iter().map(|(_, value)| width(&value.to_string()));
    let needed = if beside {
        widths.fold(0.0, f32::max)
    } else {
        LINE
    };
    let mut last: Option<f32> = None;
    values.into_iter().filter(move |(place, _)| {
        let free = last.is_none_or(|last| (place - last).abs() >= needed);
        if free {
            last = Some(*place);
        }
        free
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_values_never_cover_each_other() {
        for (count, step) in [(5, 1.0), (11, 0.05), (12, 0.05), (40, 0.125), (3000, 0.125)] {
            for (beside, whole) in [(true, WIDTH), (false, HEIGHT)] {
                let room = whole / count as f32;
                let values = (0..count).map(|k| (k as f32 * room, f64::from(k) * step));
                let ticks: Vec<(f32, f64)> = ticks(values, beside).collect();
                for [(a, _), (b, value)] in ticks.array_windows() {
                    let needed = if beside {
                        width(&value.to_string())
                    } else {
                        LINE
                    };
                    assert!(b - a >= needed, "{count} values: {} < {needed}", b - a);
                }
                assert!(ticks.len() > 2, "{count} values");
            }
        }
    }

    #[test]
    fn numbers_are_written_only_where_all_have_room() {
        let texts = ["4.685".to_owned(), "10.123".to_owned()];
        assert!(have_room(&texts, [WIDTH / 6.0, HEIGHT / 10.0]));
        assert!(!have_room(&texts, [WIDTH / 11.0, HEIGHT / 10.0]));
        assert!(!have_room(&texts, [WIDTH / 6.0, HEIGHT / 14.0]));
    }
}
