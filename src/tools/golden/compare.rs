//! Results against results.

use std::f64::consts::FRAC_PI_2;

use super::difference::{Change, Comparison, Difference, FeatureDifference, Set, Value};
use super::labels::compare_labels;
use super::pairing::{pairs, signed_like};
use super::range_noise::compare_noise;
use super::results::{Feature, Geometry, Results};
use super::sonars::compare_sonars;
use super::tolerance::Tolerance;
use crate::core::geometry::{Vec2, unit, wrap_angle};

/// What `actual` has otherwise than `golden`, beyond the tolerance.
///
/// Features are paired by nearness, lines with lines and points with points, never by id or place;
/// labels by sonar and stamp, where both sides have labels.
pub fn compare(golden: &Results, actual: &Results, tolerance: &Tolerance) -> Comparison {
    let mut found = Comparison::default();
    let noise = compare_noise(golden.noise, actual.noise, tolerance);
    found.differences.extend(noise.map(Difference::Noise));
    if let (Some(golden), Some(actual)) = (&golden.labels, &actual.labels) {
        let sonars = compare_sonars(golden, actual, tolerance);
        found
            .differences
            .extend(sonars.into_iter().map(Difference::Sonar));
    }
    for (set, golden, actual) in [
        (Set::Map, &golden.map, &actual.map),
        (Set::Extracted, &golden.extracted, &actual.extracted),
    ] {
        let features = compare_features(set, golden, actual, tolerance);
        found.differences.extend(
            features
                .into_iter()
                .map(|one| Difference::Feature(Box::new(one))),
        );
    }
    if let (Some(golden), Some(actual)) = (&golden.labels, &actual.labels) {
        let (clear, borderline) = compare_labels(golden, actual, tolerance);
        found
            .differences
            .extend(clear.into_iter().map(Difference::Labels));
        found.borderline = borderline;
        found.labels_compared = true;
    }
    found
}

fn compare_features(
    set: Set,
    golden: &[Feature],
    actual: &[Feature],
    tolerance: &Tolerance,
) -> Vec<FeatureDifference> {
    let pairs = pairs(golden, actual, tolerance);
    let partner = |place: usize| {
        let at = pairs.binary_search_by_key(&place, |pair| pair.0).ok()?;
        pairs.get(at).and_then(|(_, a)| actual.get(*a))
    };
    let mut found: Vec<FeatureDifference> = golden
        .iter()
        .enumerate()
        .filter_map(|(place, feature)| {
            let partner = partner(place);
            let changes = partner.map(|partner| changes(feature, partner, tolerance));
            if changes.as_ref().is_some_and(Vec::is_empty) {
                return None;
            }
            Some(FeatureDifference {
                set,
                golden: Some(feature.clone()),
                actual: partner.cloned(),
                changes: changes.unwrap_or_default(),
            })
        })
        .collect();
    let mut paired: Vec<usize> = pairs.iter().map(|pair| pair.1).collect();
    paired.sort_unstable();
    let new = actual
        .iter()
        .enumerate()
        .filter(|(place, _)| paired.binary_search(place).is_err());
    found.extend(new.map(|(_, feature)| FeatureDifference {
        set,
        golden: None,
        actual: Some(feature.clone()),
        changes: Vec::new(),
    }));
    found
}

/// What moved beyond its tolerance between a feature and its partner.
fn changes(golden: &Feature, actual: &Feature, tolerance: &Tolerance) -> Vec<Change> {
    let mut changes = Vec::new();
    match (&golden.geometry, &actual.geometry) {
        (
            Some(Geometry::Line {
                rho,
                theta,
                mid,
                half_length,
            }),
            Some(
                other @ Geometry::Line {
                    mid: m,
                    half_length: h,
                    ..
                },
            ),
        ) => {
            let (offset, angle) = signed_like(other, *theta).unwrap_or((*rho, *theta));
            changes.extend(length("rho", *rho, offset, tolerance.rho));
            changes.extend(self::angle("theta", *theta, angle, tolerance.theta));
            let along = |mid: &[f64; 2]| unit(theta + FRAC_PI_2).dot(&Vec2::from(*mid));
            changes.extend(length("middle", along(mid), along(m), tolerance.extent));
            changes.extend(length("half length", *half_length, *h, tolerance.extent));
        }
        (Some(Geometry::Point { x, y }), Some(Geometry::Point { x: u, y: v })) => {
            changes.extend(length("x", *x, *u, tolerance.position));
            changes.extend(length("y", *y, *v, tolerance.position));
        }
        _ => {}
    }
    let names = match golden.geometry {
        Some(Geometry::Line { .. }) => ["sigma rho", "sigma theta"],
        _ => ["sigma x", "sigma y"],
    };
    // Of a feature that moved, nobody wants to read that its covariance moved, too.
    if let (true, Some(golden), Some(actual)) = (changes.is_empty(), golden.sigma, actual.sigma) {
        for ((what, g), a) in names.into_iter().zip(golden).zip(actual) {
            changes.extend(deviation(what, g, a, tolerance.sigma));
        }
    }
    if golden.readings.abs_diff(actual.readings) > tolerance.readings {
        let value = Value::Count {
            golden: golden.readings,
            actual: actual.readings,
            tolerance: tolerance.readings,
        };
        changes.push(Change {
            what: "readings",
            value,
        });
    }
    if golden.fate != actual.fate {
        let word = |fate: &Option<String>| fate.clone().unwrap_or_else(|| "unknown".to_owned());
        let value = Value::Word {
            golden: word(&golden.fate),
            actual: word(&actual.fate),
        };
        changes.push(Change {
            what: "outcome",
            value,
        });
    }
    changes
}

/// Rounding on either side is no difference.
fn beyond(delta: f64, tolerance: f64) -> bool {
    const ROUNDING: f64 = 1.5e-6;
    delta.abs() > tolerance + ROUNDING
}

pub(super) fn length(
    what: &'static str,
    golden: f64,
    actual: f64,
    tolerance: f64,
) -> Option<Change> {
    let delta = actual - golden;
    beyond(delta, tolerance).then_some(Change {
        what,
        value: Value::Length {
            golden,
            actual,
            delta,
            tolerance,
        },
    })
}

/// `actual` is taken as the angle next to `golden` that it is on the circle.
pub(super) fn angle(
    what: &'static str,
    golden: f64,
    actual: f64,
    tolerance: f64,
) -> Option<Change> {
    let delta = wrap_angle(actual - golden);
    beyond(delta, tolerance).then_some(Change {
        what,
        value: Value::Angle {
            golden,
            actual,
            delta,
            tolerance,
        },
    })
}

pub(super) fn deviation(
    what: &'static str,
    golden: f64,
    actual: f64,
    tolerance: f64,
) -> Option<Change> {
    let delta = (actual - golden) / golden.abs().max(1e-6);
    beyond((actual - golden).abs(), tolerance * golden.abs()).then_some(Change {
        what,
        value: Value::Deviation {
            golden,
            actual,
            delta,
            tolerance,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::super::text::describe;
    use super::*;
    use proptest::prelude::*;

    fn results(features: Vec<Feature>) -> Results {
        Results::of_map(features)
    }

    fn texts(golden: Vec<Feature>, actual: Vec<Feature>) -> Vec<String> {
        compare(&results(golden), &results(actual), &Tolerance::default())
            .differences
            .iter()
            .map(|difference| describe(difference, None))
            .collect()
    }

    #[test]
    fn a_line_that_moved_is_named_with_what_moved_and_by_how_much() {
        let mut golden = Feature::line(1.2043, 0.3, [1.15, 0.36], 1.0);
        golden.frames = Some([118, 164]);
        let mut moved = Feature::line(1.2391, 0.3, [1.18, 0.37], 1.0);
        moved.frames = Some([118, 164]);
        assert_eq!(
            texts(vec![golden], vec![moved]),
            ["line 0: rho 1.2043 -> 1.2391 m (+0.0348, tolerance 0.010), frames 118-164"]
        );
    }

    #[test]
    fn missing_and_new_features_are_named() {
        let found = texts(
            vec![Feature::point(1.0, 2.0)],
            vec![Feature::wall([0.0, 1.0], [3.0, 1.0])],
        );
        assert_eq!(
            found,
            [
                "point 0 is missing: x 1.0000, y 2.0000 m",
                "line 0 is new: rho 1.0000 m, theta 90.00 deg, (3.000, 1.000) to (0.000, 1.000)"
            ]
        );
    }

    proptest! {
        #[test]
        fn order_ids_and_signs_do_not_matter(seed in prop::collection::vec((-5.0..5.0, -5.0..5.0, -3.0..3.0, 0.1..2.0), 1..12), turn in 0..12_usize) {
            let lines = |flip: bool| -> Vec<Feature> {
                seed.iter().map(|(x, y, theta, half)| {
                    let rho = unit(*theta).dot(&Vec2::new(*x, *y));
                    let (rho, theta) = if flip { (-rho, theta + std::f64::consts::PI) } else { (rho, *theta) };
                    Feature::line(rho, theta, [*x, *y], *half)
                }).collect()
            };
            let mut other = lines(true);
            let turn = turn % other.len();
            other.rotate_left(turn);
            let found = compare(&results(lines(false)), &results(other), &Tolerance { theta: 0.0, rho: 0.0, extent: 0.0, ..Tolerance::default() });
            prop_assert_eq!(found.differences, vec![]);
        }
    }
}
