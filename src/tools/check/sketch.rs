//! A map in letters, for pages that show no pictures.

use std::f64::consts::FRAC_PI_2;

use crate::core::geometry::{Vec2, unit};
use crate::tools::golden::{Comparison, Feature, Geometry, Set};

const COLUMNS: usize = 76;
const MOST_ROWS: usize = 40;
/// Letters are about twice as high as they are wide.
const ASPECT: f64 = 2.0;

/// The golden map, and over it what moved: `.` as it was, `-` what moved or is missing, `#` what
/// moved or is new. Points are `o` where they are as they were.
pub fn sketch(golden: &[Feature], comparison: &Comparison) -> String {
    let changed = || (comparison.features(Set::Map)).filter(|one| one.is_elsewhere());
    let layers: Vec<(Vec<Vec2>, char)> = golden
        .iter()
        .map(|feature| (places(feature), if is_point(feature) { 'o' } else { '.' }))
        .chain(changed().filter_map(|one| Some((places(one.golden.as_ref()?), '-'))))
        .chain(changed().filter_map(|one| Some((places(one.actual.as_ref()?), '#'))))
        .collect();
    let all = || layers.iter().flat_map(|(places, _)| places);
    let Some(first) = all().next() else {
        return String::new();
    };
    let low = all().fold(*first, |low, at| low.inf(at));
    let high = all().fold(*first, |high, at| high.sup(at));
    let span = high - low;
    let cell = (span.x / (COLUMNS - 1) as f64)
        .max(span.y / ASPECT / (MOST_ROWS - 1) as f64)
        .max(1e-3);
    let rows = ((span.y / cell / ASPECT).round() as usize).min(MOST_ROWS - 1) + 1;
    let columns = ((span.x / cell).round() as usize).min(COLUMNS - 1) + 1;
    let mut grid = vec![vec![' '; columns]; rows];
    for (places, letter) in &layers {
        for at in places {
            let column = ((at.x - low.x) / cell).round() as usize;
            let row = ((high.y - at.y) / cell / ASPECT).round() as usize;
            if let Some(spot) = grid.get_mut(row).and_then(|row| row.get_mut(column)) {
                *spot = *letter;
            }
        }
    }
    let lines: Vec<String> = grid
        .into_iter()
        .map(|row| row.into_iter().collect::<String>().trim_end().to_owned())
        .collect();
    format!("{}\n(a letter is {cell:.2} m wide)\n", lines.join("\n"))
}

fn is_point(feature: &Feature) -> bool {
    matches!(feature.geometry, Some(Geometry::Point { .. }))
}

/// Places along a feature, near enough to each other to draw it.
fn places(feature: &Feature) -> Vec<Vec2> {
    const STEPS: u32 = 160;
    match &feature.geometry {
        Some(Geometry::Line {
            theta,
            mid,
            half_length,
            ..
        }) => {
            let along = unit(theta + FRAC_PI_2) * *half_length;
            (0..=STEPS)
                .map(|i| f64::from(i) / f64::from(STEPS) * 2.0 - 1.0)
                .map(|part| Vec2::from(*mid) + along * part)
                .collect()
        }
        Some(Geometry::Point { x, y }) => vec![Vec2::new(*x, *y)],
        None => Vec::new(),
    }
}
