//! A heat map over two keys.

use super::drawing::{
    BEST, CONFIGURED, Drawing, HEIGHT, Picture, WIDTH, best, have_room, places, range, ticks,
};
use crate::observe::drawing::{DrawnAxis, DrawnGrid};

/// More cells than this have no numbers at all.
const MOST_NUMBERS: usize = 2_000;
/// What could not be replayed.
const FAILED: [u8; 3] = [0x50, 0x50, 0x50];

/// The heat map of a column over the keys `along` and `up`.
pub fn draw(grid: &DrawnGrid, axes: [usize; 2], column: usize) -> Option<Picture> {
    let (known, [along, up]) = (grid.columns.get(column)?, axes);
    let (along, up) = (grid.axes.get(along)?, grid.axes.get(up)?);
    let (wide, high) = (along.values.len(), up.values.len());
    let shown = first_behind(grid, axes, [wide, high]);
    // `None` where nothing was replayed, or where there is no such number.
    let number = |numbers: &[Option<f64>]| numbers.get(column).copied().flatten();
    let [low, most] = range(shown.iter().filter_map(|numbers| number((*numbers)?)));
    let goodness = |number: f64| match (number - low) / (most - low) {
        // All alike, or as good as any.
        share if !share.is_finite() => 1.0,
        share if known.low_is_better => 1.0 - share,
        share => share,
    };

    let mut drawing = Drawing::default();
    let colors = shown.iter().map(|numbers| {
        numbers.and_then(number).map_or(FAILED, |number| {
            let color = colorous::CIVIDIS.eval_continuous(goodness(number));
            [color.r, color.g, color.b]
        })
    });
    let colors: Vec<[u8; 3]> = colors.collect();
    drawing.image(pixels(&colors, [wide, high]), [WIDTH as u32, HEIGHT as u32]);

    let block = [WIDTH / wide as f32, HEIGHT / high as f32];
    let middle = |x: usize, y: usize| {
        let y = high as f32 - 1.0 - y as f32;
        [(x as f32 + 0.5) * block[0], (y + 0.5) * block[1]]
    };
    if wide * high <= MOST_NUMBERS {
        let text = |numbers: &Option<&[Option<f64>]>| match numbers {
            Some(numbers) => known.text(number(numbers)),
            None => "failed".to_owned(),
        };
        let texts: Vec<String> = shown.iter().map(text).collect();
        let fit = have_room(&texts, block);
        for (place, text) in texts.into_iter().enumerate() {
            let at = middle(place % wide, place / wide);
            if fit {
                drawing.text(at, text);
            } else {
                drawing.whisper(at, text);
            }
        }
    }
    let across = along.values.iter().enumerate();
    for (x, value) in ticks(across.map(|(x, v)| (middle(x, 0)[0], *v)), true) {
        drawing.text([x, HEIGHT + 12.0], value.to_string());
    }
    let upwards = up.values.iter().enumerate();
    for (y, value) in ticks(upwards.map(|(y, v)| (middle(0, y)[1], *v)), false) {
        drawing.text_before([-2.0, y], value.to_string());
    }
    drawing.text([WIDTH / 2.0, HEIGHT + 32.0], along.name.clone());
    drawing.text_from([0.0, -16.0], up.name.clone());

    let mut frame = |[x, y]: [f32; 2], inset: f32, color| {
        let (dx, dy) = (block[0] / 2.0 - inset, block[1] / 2.0 - inset);
        let corners = [[-dx, -dy], [dx, -dy], [dx, dy], [-dx, dy], [-dx, -dy]];
        drawing.line(corners.map(|[a, b]| [x + a, y + b]).to_vec(), color);
    };
    for [x, y] in best(grid, axes) {
        frame(middle(x, y), 0.0, BEST);
    }
    if let (Some(x), Some(y)) = (configured(along), configured(up)) {
        frame(middle(x, y), 2.0, CONFIGURED);
    }
    Some(Picture::new(known, [low, most], drawing))
}

/// The place of the configured value, where it is one of those that were swept.
fn configured(axis: &DrawnAxis) -> Option<usize> {
    let value = axis.configured?;
    let slack = 1e-6 * value.abs().max(1e-3);
    axis.values.iter().position(|v| (v - value).abs() <= slack)
}

/// The numbers of the best of the cells behind every place by the sweep's ranking, row by row from the
/// first value of the second key on: the same cells in every picture.
fn first_behind(
    grid: &DrawnGrid,
    axes: [usize; 2],
    [wide, high]: [usize; 2],
) -> Vec<Option<&[Option<f64>]>> {
    let mut first: Vec<Option<&[Option<f64>]>> = vec![None; wide * high];
    for cell in &grid.cells {
        let [x, y] = places(cell, axes);
        if let (Some(numbers), Some(place)) = (&cell.numbers, first.get_mut(y * wide + x)) {
            place.get_or_insert(numbers);
        }
    }
    first
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
    use crate::observe::drawing::DrawnCell;

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
        let mut grid = super::super::tests::grid(&[("a", &[1.0, 2.0]), ("b", &[1.0, 2.0])]);
        let cell = |places: [usize; 3], number| DrawnCell {
            places: places.to_vec(),
            numbers: Some(vec![number]),
        };
        let first = cell([0, 1, 1], Some(1.0));
        let worse = cell([0, 1, 0], Some(2.0));
        grid.cells = vec![first, worse, cell([1, 1, 0], Some(3.0))];
        let shown = first_behind(&grid, [0, 1], [2, 2]);
        let numbers = shown
            .iter()
            .map(|cell| cell.map(|numbers| numbers[0].unwrap()));
        let numbers: Vec<Option<f64>> = numbers.collect();
        assert_eq!(numbers, [None, None, Some(1.0), Some(3.0)]);
    }
}
