//! A picture of a sweep under its title, and what is marked in it.

use rerun::Color;

use super::drawing::Drawing;
use crate::observe::drawing::{Cell, Column, Grid};
use crate::observe::recording::style;

/// The colour of the best cells.
pub const BEST: Color = style::BOUND;
/// The colour of what is configured.
pub const CONFIGURED: Color = style::rgb(0xff, 0xff, 0xff);

/// One picture under its title.
pub struct Picture {
    pub title: String,
    /// Whether it shows the same number everywhere.
    pub is_flat: bool,
    pub drawing: Drawing,
}

impl Picture {
    /// A drawing of a column whose numbers lie in a range.
    pub fn new(column: &Column, [low, high]: [f64; 2], drawing: Drawing) -> Self {
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
pub fn best<const N: usize>(grid: &Grid, axes: [usize; N]) -> Vec<[usize; N]> {
    let best = grid.cells.iter().take(grid.best);
    let mut places: Vec<[usize; N]> = best.map(|cell| places(cell, axes)).collect();
    places.sort_unstable();
    places.dedup();
    places
}

/// The places of a cell on some axes.
pub fn places<const N: usize>(cell: &Cell, axes: [usize; N]) -> [usize; N] {
    axes.map(|axis| cell.places.get(axis).copied().unwrap_or_default())
}
