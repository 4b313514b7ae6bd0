//! A heat map over two keys.

use super::Picture;
use super::drawing::{Drawing, HEIGHT, WIDTH, have_room, ticks};
use super::marks::{BEST, CONFIGURED};
use crate::tools::sweep::Sweep;
use crate::tools::sweep::columns::{Better, Column};
use crate::tools::sweep::score::Score;

/// More cells than this have no numbers at all.
const MOST_NUMBERS: usize = 2_000;
/// What could not be replayed.
const FAILED: [u8; 3] = [0x50, 0x50, 0x50];

/// The heat map of a column over the keys `along` and `up`.
pub fn draw(sweep: &Sweep, [along, up]: [usize; 2], column: &'static Column) -> Option<Picture> {
    let axes = sweep.grid.axes();
    let (along_axis, up_axis) = (axes.get(along)?, axes.get(up)?);
    let (wide, high) = (along_axis.values.len(), up_axis.values.len());
    let best = best_behind(sweep, [along, up])?;
    let value = |x: usize, y: usize| best.get(y * wide + x).copied().flatten();
    let numbers = || best.iter().flatten().filter_map(|score| (column.of)(score));
    let low = numbers().fold(f64::INFINITY, f64::min);
    let most = numbers().fold(f64::NEG_INFINITY, f64::max);
    let goodness = |score: &Score| {
        let share = ((column.of)(score)? - low) / (most - low);
        Some(match column.better {
            // All alike, or as good as any.
            _ if !share.is_finite() => 1.0,
            Better::Low => 1.0 - share,
            Better::High => share,
        })
    };

    let mut drawing = Drawing::default();
    let colors: Vec<[u8; 3]> = best
        .iter()
        .map(|score| {
            score.and_then(goodness).map_or(FAILED, |goodness| {
                let color = colorous::CIVIDIS.eval_continuous(goodness);
                [color.r, color.g, color.b]
            })
        })
        .collect();
    drawing.image(pixels(&colors, [wide, high]), [WIDTH as u32, HEIGHT as u32]);

    let block = [WIDTH / wide as f32, HEIGHT / high as f32];
    let middle = |x: f32, y: f32| {
        let y = high as f32 - 1.0 - y;
        [(x + 0.5) * block[0], (y + 0.5) * block[1]]
    };
    if wide * high <= MOST_NUMBERS {
        let text = |x, y| value(x, y).map_or_else(|| "failed".to_owned(), |s| column.text(s));
        let places = || (0..high).flat_map(|y| (0..wide).map(move |x| (x, y)));
        let texts: Vec<String> = places().map(|(x, y)| text(x, y)).collect();
        let fit = have_room(&texts, block);
        for ((x, y), text) in places().zip(texts) {
            let at = middle(x as f32, y as f32);
            if fit {
                drawing.text(at, text);
            } else {
                drawing.whisper(at, text);
            }
        }
    }
    let across = along_axis.values.iter().enumerate();
    for (x, value) in ticks(across.map(|(x, v)| (middle(x as f32, 0.0)[0], *v)), true) {
        drawing.text([x, HEIGHT + 12.0], value.to_string());
    }
    let upwards = up_axis.values.iter().enumerate();
    for (y, value) in ticks(upwards.map(|(y, v)| (middle(0.0, y as f32)[1], *v)), false) {
        drawing.text_before([-2.0, y], value.to_string());
    }
    drawing.text(
        [WIDTH / 2.0, HEIGHT + 32.0],
        super::layout::name(along_axis),
    );
    drawing.text_from([0.0, -16.0], super::layout::name(up_axis));

    let mut frame = |[x, y]: [f32; 2], inset: f32, color| {
        let (dx, dy) = (block[0] / 2.0 - inset, block[1] / 2.0 - inset);
        let corners = [[-dx, -dy], [dx, -dy], [dx, dy], [-dx, dy], [-dx, -dy]];
        drawing.line(corners.map(|[a, b]| [x + a, y + b]).to_vec(), color);
    };
    for [x, y] in super::marks::best(sweep, [along, up]) {
        frame(middle(x as f32, y as f32), 0.0, BEST);
    }
    let configured = |axis: usize| {
        let value = (*sweep.configured.values.get(axis)?)?;
        super::marks::place(&axes.get(axis)?.values, value)
    };
    if let (Some(x), Some(y)) = (configured(along), configured(up)) {
        frame(middle(x, y), 2.0, CONFIGURED);
    }
    Some(Picture {
        title: super::layout::title(column, low, most),
        is_flat: most <= low,
        drawing,
    })
}

/// The best score of the cells behind every place by the sweep's ranking, row by row from the first
/// value of `up` on: the same cells in every picture.
fn best_behind(sweep: &Sweep, [along, up]: [usize; 2]) -> Option<Vec<Option<&Score>>> {
    let count = |axis: usize| Some(sweep.grid.axes().get(axis)?.values.len());
    let (wide, high) = (count(along)?, count(up)?);
    let mut best: Vec<Option<&Score>> = vec![None; wide * high];
    for cell in &sweep.cells {
        let places = sweep.grid.places(cell.index);
        let (x, y) = (*places.get(along)?, *places.get(up)?);
        let (Ok(score), Some(place)) = (&cell.score, best.get_mut(y * wide + x)) else {
            continue;
        };
        place.get_or_insert(score);
    }
    Some(best)
}

/// An image of fields, whose rows come from the bottom up.
fn pixels(colors: &[[u8; 3]], [wide, high]: [usize; 2]) -> Vec<u8> {
    let (width, height) = (WIDTH as usize, HEIGHT as usize);
    let pixel = |i: usize, j: usize| {
        let (x, y) = (i * wide / width, high - 1 - j * high / height);
        colors.get(y * wide + x).copied().unwrap_or(FAILED)
    };
    (0..height)
        .flat_map(|j| (0..width).flat_map(move |i| pixel(i, j)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_is_of_one_size_whatever_the_grid() {
        let colors = [[1; 3], [2; 3], [3; 3], [4; 3]];
        let image = pixels(&colors, [2, 2]);
        assert_eq!(image.len(), 3 * WIDTH as usize * HEIGHT as usize);
        // The first row of values is at the bottom.
        assert_eq!((image.first(), image.last()), (Some(&3), Some(&2)));
        let long: Vec<[u8; 3]> = vec![[7; 3]; 5000];
        assert_eq!(pixels(&long, [5000, 1]).len(), image.len());
    }

    #[test]
    fn every_place_shows_the_first_of_the_cells_behind_it() {
        let sweep = super::super::tests::sweep(&[
            ("frames.step", "0.1,0.5"),
            ("triple.beta", "2,3"),
            ("noise.sigma_pose", "0.002,0.02"),
        ]);
        let shown = best_behind(&sweep, [0, 1]).unwrap();
        for (place, score) in shown.iter().enumerate() {
            let (x, y) = (place % 2, place / 2);
            let behind = |index| sweep.grid.places(index).starts_with(&[x, y]);
            let mut ranked = sweep.cells.iter().filter(|cell| behind(cell.index));
            let first = ranked.next().unwrap().score.as_ref().unwrap();
            assert!(std::ptr::eq(score.unwrap(), first), "{x} {y}");
        }
    }
}
