//! A curve over one key.

use super::super::style::{CONTACT, UNIDENTIFIED};
use super::Picture;
use super::drawing::{Drawing, HEIGHT, WIDTH, ticks};
use super::marks::{self, BEST, CONFIGURED};
use crate::tools::sweep::Sweep;
use crate::tools::sweep::columns::Column;

/// Values that are written at the left.
const LEVELS: usize = 5;

/// The curve of a column over a key.
pub fn draw(sweep: &Sweep, axis: usize, column: &'static Column) -> Option<Picture> {
    let known = sweep.grid.axes().get(axis)?;
    let mut points: Vec<(f64, Option<f64>)> = sweep
        .cells
        .iter()
        .filter_map(|cell| {
            let value = *sweep.grid.values(cell.index).get(axis)?;
            let score = cell.score.as_ref().ok();
            Some((value, score.and_then(|score| (column.of)(score))))
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let numbers = || points.iter().filter_map(|(_, number)| *number);
    let low = numbers().fold(f64::INFINITY, f64::min);
    let high = numbers().fold(f64::NEG_INFINITY, f64::max);
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
    let best: Vec<f64> = marks::best(sweep, [axis])
        .into_iter()
        .filter_map(|[place]| known.values.get(place).copied())
        .collect();
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
    let configured = sweep.configured.values.get(axis).copied().flatten();
    if let Some(value) = configured.filter(|value| (first..=last).contains(value)) {
        upright(&mut drawing, value, -18.0, CONFIGURED);
        drawing.text([along(value), -26.0], format!("configured {value}"));
    }
    // What could not be replayed leaves a gap.
    for part in points.split(|(_, number)| number.is_none()) {
        let part: Vec<[f32; 2]> = part
            .iter()
            .filter_map(|(value, number)| Some([along(*value), up((*number)?)]))
            .collect();
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
    drawing.text([WIDTH / 2.0, HEIGHT + 32.0], super::layout::name(known));
    let levels = if high > low { LEVELS } else { 1 };
    let decimals = decimals(column, (high - low) / (LEVELS - 1) as f64);
    for level in 0..levels {
        let share = level as f64 / (LEVELS - 1) as f64;
        let number = low + share * (high - low);
        let text = format!("{:.decimals$}", number * column.scale);
        drawing.text_before([-4.0, up(number)], text);
    }
    Some(Picture {
        title: super::layout::title(column, low, high),
        is_flat: high <= low,
        drawing,
    })
}

/// How many decimals tell levels apart that are so far from each other, a column's own at the least.
fn decimals(column: &Column, apart: f64) -> usize {
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
    use crate::tools::sweep::columns;

    #[test]
    fn levels_that_differ_are_written_differently() {
        let column = columns::columns(false).find(|column| column.name == "suspect_share");
        let column = column.unwrap();
        // A share of 0 to 0.2 %, told in percent with one decimal.
        assert_eq!(decimals(column, 0.0005), 2);
        assert_eq!(decimals(column, 0.05), 1);
        assert_eq!(decimals(column, 0.0), 1);
    }
}
