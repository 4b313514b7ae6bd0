//! A curve over one key.

use super::drawing::{BEST, CONFIGURED, Drawing, HEIGHT, Picture, WIDTH, best, range, ticks};
use crate::observe::drawing::{DrawnColumn, DrawnGrid};
use crate::observe::recording::style::{CONTACT, UNIDENTIFIED};

/// Values that are written at the left.
const LEVELS: usize = 5;

/// The curve of a column over the only key.
pub fn draw(grid: &DrawnGrid, column: usize) -> Option<Picture> {
    let (axis, known) = (grid.axes.first()?, grid.columns.get(column)?);
    let points = grid.cells.iter().filter_map(|cell| {
        let value = *axis.values.get(*cell.places.first()?)?;
        let number = cell.numbers.as_ref().and_then(|all| *all.get(column)?);
        Some((value, number))
    });
    let mut points: Vec<(f64, Option<f64>)> = points.collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [low, high] = range(points.iter().filter_map(|(_, number)| *number));
    let (first, last) = (points.first()?.0, points.last()?.0);
    let along = |value: f64| WIDTH * ((value - first) / (last - first)) as f32;
    let up = |number: f64| {
        let share = ((number - low) / (high - low)) as f32;
        HEIGHT * (1.0 - if share.is_finite() { share } else { 0.5 })
    };

    let mut drawing = Drawing::default();
    let frame = [[0.0, 0.0], [0.0, HEIGHT], [WIDTH, HEIGHT]];
    drawing.line(frame.to_vec(), UNIDENTIFIED);
    let upright = |drawing: &mut Drawing, value, top, color| {
        drawing.line(vec![[along(value), top], [along(value), HEIGHT]], color);
    };
    let best = best(grid, [0]).into_iter();
    let best = best.filter_map(|[place]| axis.values.get(place).copied());
    let best: Vec<f64> = best.collect();
    for value in &best {
        upright(&mut drawing, *value, 0.0, BEST);
    }
    if let Some(value) = best.first() {
        let others = match best.len() {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        drawing.text([along(*value), -8.0], format!("best {value}{others}"));
    }
    let within = |value: &f64| (first..=last).contains(value);
    if let Some(value) = axis.configured.filter(within) {
        upright(&mut drawing, value, -18.0, CONFIGURED);
        drawing.text([along(value), -26.0], format!("configured {value}"));
    }
    // What could not be replayed leaves a gap.
    for part in points.split(|(_, number)| number.is_none()) {
        let part = part.iter();
        let part = part.filter_map(|(value, number)| Some([along(*value), up((*number)?)]));
        let part: Vec<[f32; 2]> = part.collect();
        for at in &part {
            drawing.dot(*at, CONTACT);
        }
        if part.len() > 1 {
            drawing.line(part, CONTACT);
        }
    }
    let ticks_of = points.iter().map(|(value, _)| (along(*value), *value));
    for (x, value) in ticks(ticks_of, true) {
        drawing.text([x, HEIGHT + 12.0], value.to_string());
    }
    drawing.text([WIDTH / 2.0, HEIGHT + 32.0], axis.name.clone());
    let levels = if high > low { LEVELS } else { 1 };
    let decimals = decimals(known, (high - low) / (LEVELS - 1) as f64);
    for level in 0..levels {
        let share = level as f64 / (LEVELS - 1) as f64;
        let number = low + share * (high - low);
        let text = format!("{:.decimals$}", number * known.scale);
        drawing.text_before([-4.0, up(number)], text);
    }
    Some(Picture::new(known, [low, high], drawing))
}

/// How many decimals tell levels apart that are so far from each other, a column's own at the least.
fn decimals(column: &DrawnColumn, apart: f64) -> usize {
    let apart = apart * column.scale;
    let enough = |decimals: &usize| apart * libm::pow(10.0, *decimals as f64) >= 1.0;
    let most = if apart > 0.0 {
        column.decimals + 3
    } else {
        column.decimals
    };
    (column.decimals..most).find(enough).unwrap_or(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_that_differ_are_written_differently() {
        // A share of 0 to 0.2 %, told in percent with one decimal.
        let column = DrawnColumn {
            heading: "suspect %".to_owned(),
            low_is_better: true,
            decimals: 1,
            scale: 100.0,
        };
        assert_eq!(decimals(&column, 0.0005), 2);
        assert_eq!(decimals(&column, 0.05), 1);
        assert_eq!(decimals(&column, 0.0), 1);
    }
}
