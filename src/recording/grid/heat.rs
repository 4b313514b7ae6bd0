//! A heat map over two keys.

use rerun::Color;

use super::Picture;
use super::drawing::{Drawing, HEIGHT, WIDTH, ticks};
use crate::sweep::Sweep;
use crate::sweep::columns::{Better, Column};
use crate::sweep::score::Score;

/// More cells than this have no numbers in them.
const MOST_NUMBERS: usize = 110;
/// What could not be replayed.
const FAILED: [u8; 3] = [0x50, 0x50, 0x50];
/// Around the best cell.
const BEST: Color = Color(rerun::Rgba32::from_rgb(0xff, 0xff, 0xff));

/// The heat map of a column over the keys `along` and `up`.
pub fn draw(sweep: &Sweep, [along, up]: [usize; 2], column: &'static Column) -> Option<Picture> {
    let axes = sweep.grid.axes();
    let (along_axis, up_axis) = (axes.get(along)?, axes.get(up)?);
    let (wide, high) = (along_axis.values.len(), up_axis.values.len());
    let mut best: Vec<Option<&Score>> = vec![None; wide * high];
    for cell in &sweep.cells {
        let places = sweep.grid.places(cell.index);
        let (x, y) = (*places.get(along)?, *places.get(up)?);
        let (Ok(score), Some(place)) = (&cell.score, best.get_mut(y * wide + x)) else {
            continue;
        };
        let is_better = place.is_none_or(|held| column.compare(score, held).is_lt());
        if is_better {
            *place = Some(score);
        }
    }
    let value = |x: usize, y: usize| best.get(y * wide + x).copied().flatten();
    let numbers = || best.iter().flatten().filter_map(|score| (column.of)(score));
    let low = numbers().fold(f64::INFINITY, f64::min);
    let high_value = numbers().fold(f64::NEG_INFINITY, f64::max);
    let goodness = |score: &Score| {
        let share = ((column.of)(score)? - low) / (high_value - low);
        Some(match column.better {
            // All alike, or as good as any.
            _ if !share.is_finite() => 1.0,
            Better::Low => 1.0 - share,
            Better::High => share,
        })
    };
    let color = |score: Option<&Score>| {
        score.and_then(goodness).map_or(FAILED, |goodness| {
            let color = colorous::CIVIDIS.eval_continuous(goodness);
            [color.r, color.g, color.b]
        })
    };

    let mut drawing = Drawing::default();
    let block = |whole: f32, parts: usize| ((whole / parts as f32) as usize).max(1);
    let (block_x, block_y) = (block(WIDTH, wide), block(HEIGHT, high));
    let mut pixels = Vec::with_capacity(3 * wide * block_x * high * block_y);
    for y in (0..high).rev() {
        let row: Vec<u8> = (0..wide)
            .flat_map(|x| color(value(x, y)).repeat(block_x))
            .collect();
        pixels.extend(row.repeat(block_y));
    }
    let size = [wide * block_x, high * block_y];
    drawing.image(
        pixels,
        size.map(|pixels| u32::try_from(pixels).unwrap_or(u32::MAX)),
    );

    let middle = |x: usize, y: usize| {
        let [x, y] = [
            (x as f32 + 0.5) * block_x as f32,
            ((high - 1).saturating_sub(y) as f32 + 0.5) * block_y as f32,
        ];
        [x, y]
    };
    if wide * high <= MOST_NUMBERS {
        for y in 0..high {
            for x in 0..wide {
                let text = value(x, y).map_or_else(|| "failed".to_owned(), |s| column.text(s));
                drawing.text(middle(x, y), text);
            }
        }
    }
    let size = size.map(|pixels| pixels as f32);
    for x in ticks(wide) {
        let at = [middle(x, 0)[0], size[1] + 8.0];
        drawing.text(at, along_axis.values.get(x)?.to_string());
    }
    for y in ticks(high) {
        let at = [-16.0, middle(0, y)[1]];
        drawing.text(at, up_axis.values.get(y)?.to_string());
    }
    drawing.text(
        [size[0] / 2.0, size[1] + 28.0],
        super::layout::name(along_axis),
    );
    drawing.text([50.0, -18.0], super::layout::name(up_axis));
    let (cell, _) = sweep.best()?;
    let places = sweep.grid.places(cell.index);
    let [x, y] = middle(*places.get(along)?, *places.get(up)?);
    let (dx, dy) = (block_x as f32 / 2.0, block_y as f32 / 2.0);
    let corners = [[-dx, -dy], [dx, -dy], [dx, dy], [-dx, dy], [-dx, -dy]];
    drawing.line(corners.map(|[a, b]| [x + a, y + b]).to_vec(), BEST);
    Some(Picture {
        title: super::layout::title(column, low, high_value),
        drawing,
    })
}
