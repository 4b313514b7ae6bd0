//! Which feature was which: pairs by nearness, never by place in a list.
//!
//! What is identical is paired first. Among the rest, pairs within the gates are chosen so that
//! there are as many as can be and their distances add up to the least.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

use super::results::{Feature, Geometry};
use super::tolerance::Tolerance;
use crate::core::assignment::assign;
use crate::core::geometry::{Vec2, angle_between, unit, wrap_angle};

/// Frames that may lie between the runs of an extracted feature and of its partner.
const FRAMES_APART: u32 = 10;

/// Pairs of places in the two lists.
pub fn pairs(golden: &[Feature], actual: &[Feature], tolerance: &Tolerance) -> Vec<(usize, usize)> {
    let mut found = identical(golden, actual);
    let taken = |side: fn(&(usize, usize)) -> usize| -> Vec<usize> {
        let mut taken: Vec<usize> = found.iter().map(side).collect();
        taken.sort_unstable();
        taken
    };
    let (in_golden, in_actual) = (taken(|pair| pair.0), taken(|pair| pair.1));
    let free = |len: usize, taken: &[usize]| -> Vec<usize> {
        (0..len)
            .filter(|place| taken.binary_search(place).is_err())
            .collect()
    };
    let rows = free(golden.len(), &in_golden);
    let columns = free(actual.len(), &in_actual);
    let mut costs = Vec::new();
    for row in &rows {
        for column in &columns {
            if let (Some(g), Some(a)) = (golden.get(*row), actual.get(*column))
                && let Some(cost) = distance(g, a, tolerance)
            {
                costs.push((*row, *column, cost));
            }
        }
    }
    found.extend(assign(golden.len(), actual.len(), &costs));
    found.sort_unstable();
    found
}

/// Features that did not change at all.
fn identical(golden: &[Feature], actual: &[Feature]) -> Vec<(usize, usize)> {
    let mut waiting = BTreeMap::<String, Vec<usize>>::new();
    let key = |f: &Feature| {
        f.geometry.map(|geometry| {
            format!(
                "{geometry:?} {:?} {:?} {:?} {}",
                f.sensor, f.frames, f.fate, f.readings
            )
        })
    };
    for (place, feature) in actual.iter().enumerate().rev() {
        if let Some(key) = key(feature) {
            waiting.entry(key).or_default().push(place);
        }
    }
    let partner = |feature: &Feature| waiting.get_mut(&key(feature)?)?.pop();
    golden
        .iter()
        .map(partner)
        .enumerate()
        .filter_map(|(place, partner)| Some((place, partner?)))
        .collect()
}

/// How far apart two features are, in gates; `None` where they cannot be one.
fn distance(golden: &Feature, actual: &Feature, tolerance: &Tolerance) -> Option<f64> {
    if golden.kind != actual.kind || golden.sensor != actual.sensor {
        return None;
    }
    let extracted = golden.sensor.is_some();
    let apart = match (golden.frames, actual.frames) {
        (Some(g), Some(a)) if extracted => frames_apart(g, a)?,
        _ => 0.0,
    };
    let gate = |way: f64, gate: f64| {
        let part = if gate > 0.0 {
            way.abs() / gate
        } else {
            way.abs() * f64::INFINITY
        };
        (part <= 1.0).then_some(part * part)
    };
    let near = match (&golden.geometry, &actual.geometry) {
        (
            Some(Geometry::Line {
                rho,
                theta,
                mid,
                half_length,
            }),
            Some(other @ Geometry::Line { .. }),
        ) => {
            let (offset, angle) = signed_like(other, *theta)?;
            let Geometry::Line {
                mid: m,
                half_length: h,
                ..
            } = other
            else {
                return None;
            };
            let along = unit(theta + FRAC_PI_2).dot(&(Vec2::from(*m) - Vec2::from(*mid)));
            gate(offset - rho, tolerance.pair_distance)?
                + gate(wrap_angle(angle - theta), tolerance.pair_angle)?
                + gate(along, half_length + h + tolerance.pair_distance)?
        }
        (Some(Geometry::Point { x, y }), Some(Geometry::Point { x: u, y: v })) => {
            gate(libm::hypot(u - x, v - y), tolerance.pair_distance)?
        }
        (None, None) => 0.0,
        _ => return None,
    };
    Some(near + apart)
}

/// A line's (rho, theta) under the sign that is nearer to a given normal.
pub fn signed_like(line: &Geometry, normal: f64) -> Option<(f64, f64)> {
    match line {
        Geometry::Line { rho, theta, .. } if angle_between(*theta, normal) > FRAC_PI_2 => {
            Some((-rho, wrap_angle(theta + PI)))
        }
        Geometry::Line { rho, theta, .. } => Some((*rho, *theta)),
        Geometry::Point { .. } => None,
    }
}

/// How far two runs lie apart, as a part of what may be: their gap must be small, and of two runs
/// that could be meant the one that begins and ends alike is.
fn frames_apart(golden: [u32; 2], actual: [u32; 2]) -> Option<f64> {
    let ([a, b], [c, d]) = (golden, actual);
    let gap = c.saturating_sub(b).max(a.saturating_sub(d));
    (gap <= FRAMES_APART).then(|| {
        let shift = a.abs_diff(c).min(1000) + b.abs_diff(d).min(1000);
        f64::from(shift) / 100.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(xs: &[f64]) -> Vec<Feature> {
        xs.iter().map(|x| Feature::point(*x, 0.0)).collect()
    }

    #[test]
    fn the_sum_of_the_ways_is_the_least_and_the_order_does_not_matter() {
        // Nearest first would pair 0.2 with 0.15 and leave 0 without a partner in reach.
        let pairs_of = |g: &[f64], a: &[f64]| pairs(&points(g), &points(a), &Tolerance::default());
        assert_eq!(pairs_of(&[0.0, 0.2], &[0.15, 0.45]), [(0, 0), (1, 1)]);
        assert_eq!(pairs_of(&[0.2, 0.0], &[0.45, 0.15]), [(0, 0), (1, 1)]);
        assert_eq!(pairs_of(&[0.2, 0.0, 5.0], &[0.15]).len(), 1);
        assert_eq!(pairs_of(&[0.0], &[0.31]), []);
    }

    #[test]
    fn what_did_not_move_keeps_its_partner() {
        let (golden, actual) = (points(&[0.0, 0.1]), points(&[0.1, 0.2]));
        let found = pairs(&golden, &actual, &Tolerance::default());
        assert_eq!(found, [(0, 1), (1, 0)]);
    }

    #[test]
    fn one_line_under_both_signs_is_one_line() {
        let a = [Feature::line(0.01, 3.1, [0.0, 0.0], 1.0)];
        let b = [Feature::line(
            -0.02,
            3.12 - std::f64::consts::PI,
            [0.0, 0.0],
            1.0,
        )];
        let c = [Feature::line(
            0.01,
            3.1 - std::f64::consts::PI,
            [0.0, 0.0],
            1.0,
        )];
        for other in [b, c] {
            assert_eq!(pairs(&a, &other, &Tolerance::default()).len(), 1);
        }
    }

    #[test]
    fn segments_of_one_wall_that_lie_apart_are_two() {
        let a = [Feature::wall([0.0, 1.0], [1.0, 1.0])];
        let b = [Feature::wall([2.0, 1.0], [3.0, 1.0])];
        let c = [Feature::wall([0.5, 1.0], [1.5, 1.0])];
        assert!(pairs(&a, &b, &Tolerance::default()).is_empty());
        assert_eq!(pairs(&a, &c, &Tolerance::default()), [(0, 0)]);
    }

    #[test]
    fn hundreds_of_features_in_one_place_are_still_paired() {
        let many: Vec<f64> = (0..600).map(|i| f64::from(i) * 1e-5).collect();
        let moved: Vec<f64> = many.iter().map(|x| x + 0.02).collect();
        assert_eq!(
            pairs(&points(&many), &points(&moved), &Tolerance::default()).len(),
            600
        );
    }
}
