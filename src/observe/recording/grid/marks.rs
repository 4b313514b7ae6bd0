//! Where the best cells and what is configured are in a picture.

use std::collections::BTreeSet;

use rerun::{Color, Rgba32};

use super::super::style;
use crate::tools::sweep::Sweep;

/// The best cell.
pub const BEST: Color = style::BOUND;
/// What is configured.
pub const CONFIGURED: Color = Color(Rgba32::from_rgb(0xff, 0xff, 0xff));

/// The places, on some axes, of the cells that are best; none where all are alike.
pub fn best<const N: usize>(sweep: &Sweep, axes: [usize; N]) -> BTreeSet<[usize; N]> {
    if sweep.is_flat() {
        return BTreeSet::new();
    }
    let leaders = sweep.leaders().map(|cell| {
        let places = sweep.grid.places(cell.index);
        axes.map(|axis| places.get(axis).copied().unwrap_or_default())
    });
    leaders.collect()
}

/// Where a value lies among those of an axis, counted from the first on; `None` where it is none of
/// them.
pub fn place(values: &[f64], value: f64) -> Option<f32> {
    let slack = 1e-6 * value.abs().max(1e-3);
    let at = values.iter().position(|v| (v - value).abs() <= slack)?;
    Some(at as f32)
}
