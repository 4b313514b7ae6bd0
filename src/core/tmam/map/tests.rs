use super::fusion::signed_like;
use super::*;
use crate::core::config::Rule;
use crate::core::geometry::{Vec2, angle_between, unit};
use crate::core::tmam::feature::{Point, Segment};
use crate::core::tmam::fit::testing::arc;
use nalgebra::Matrix2;
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;

fn segment(rho: f64, theta: f64, way: f64, half_length: f64, sigma: [f64; 2]) -> Segment {
    let along = unit(theta + FRAC_PI_2);
    let c = 0.3 * sigma[0] * sigma[1];
    Segment {
        rho,
        theta,
        covariance: Matrix2::new(sigma[0] * sigma[0], c, c, sigma[1] * sigma[1]),
        mid: unit(theta) * rho + along * way,
        half_length,
    }
    .canonical()
}

fn only(map: &Map) -> MapFeature {
    assert_eq!(map.features().len(), 1, "{:?}", map.features());
    map.features()[0]
}

fn line(feature: &MapFeature) -> Segment {
    match feature.shape {
        Shape::Line(segment) => segment,
        _ => panic!("no line"),
    }
}

/// A run of so many readings.
fn readings(n: u32) -> Vec<Arc> {
    (0..n).map(|k| arc(k, Vec2::zeros(), 0.0, 1.0)).collect()
}

fn map_of(segments: &[(Segment, u32)]) -> Map {
    let mut map = Map::new(&Config::with_rule(Rule::Paper));
    for (segment, n) in segments {
        map.add(Shape::Line(*segment), &readings(*n));
    }
    map
}

proptest! {
    /// Walls through the origin, where rho changes sign with the noise, included.
    #[test]
    fn two_merges_in_either_order_give_the_same_line(
        rho in -0.02..3.0, theta in -3.2..3.2,
        e in prop::array::uniform4(-0.01..0.01),
        n in prop::array::uniform3(3u32..20),
    ) {
        let sigma = [0.05, 0.05];
        let a = segment(rho, theta, 0.0, 0.5, sigma);
        let b = segment(rho + e[0], theta + e[1], 0.2, 0.4, sigma);
        let c = segment(rho + e[2], theta + e[3], -0.3, 0.6, sigma);
        let one = only(&map_of(&[(a, n[0]), (b, n[1]), (c, n[2])]));
        let two = only(&map_of(&[(a, n[0]), (c, n[2]), (b, n[1])]));
        prop_assert_eq!(one.readings, two.readings);
        let (one, two) = (line(&one), signed_like(&line(&two), &line(&one)));
        prop_assert!((one.rho - two.rho).abs() < 1e-9);
        prop_assert!(angle_between(one.theta, two.theta) < 1e-9);
        prop_assert!((one.covariance - two.covariance).norm() < 1e-12);
        // The ends are projected twice, so they agree to the second order of the angles.
        prop_assert!((one.mid - two.mid).norm() < 1e-3 && (one.half_length - two.half_length).abs() < 1e-3);
    }

    #[test]
    fn the_sign_of_rho_and_theta_does_not_matter(rho in 0.0..3.0, theta in -3.2..3.2, e in prop::array::uniform2(-0.01..0.01), n in 3u32..20) {
        let a = segment(rho, theta, 0.0, 0.5, [0.05, 0.05]);
        let b = segment(rho + e[0], theta + e[1], 0.2, 0.4, [0.05, 0.05]);
        let plain = line(&only(&map_of(&[(a, 5), (b, n)])));
        let flipped = line(&only(&map_of(&[(a, 5), (b.flipped(), n)])));
        prop_assert!((plain.rho - flipped.rho).abs() < 1e-12);
        prop_assert!(angle_between(plain.theta, flipped.theta) < 1e-12);
        prop_assert!((plain.mid - flipped.mid).norm() < 1e-9);
        prop_assert!((plain.covariance - flipped.covariance).norm() < 1e-12);
        prop_assert!(plain.rho >= 0.0);
    }

    #[test]
    fn two_merges_in_either_order_give_the_same_point(e in prop::array::uniform4(-0.05..0.05), n in prop::array::uniform3(3u32..20)) {
        let point = |x: f64, y: f64| Shape::Point(Point { position: Vec2::new(1.0 + x, y), covariance: Matrix2::identity() * 1e-4 });
        let (a, b, c) = (point(0.0, 0.0), point(e[0], e[1]), point(e[2], e[3]));
        let fused = |order: [(Shape, u32); 3]| {
            let mut map = Map::new(&Config::with_rule(Rule::Paper));
            for (shape, n) in order { map.add(shape, &readings(n)); }
            match only(&map).shape { Shape::Point(p) => p, _ => panic!("no point") }
        };
        let one = fused([(a, n[0]), (b, n[1]), (c, n[2])]);
        let two = fused([(a, n[0]), (c, n[2]), (b, n[1])]);
        prop_assert!((one.position - two.position).norm() < 1e-12);
        prop_assert!((one.covariance - two.covariance).norm() < 1e-12);
    }
}

#[test]
fn equation_25_compares_squares() {
    // 5 cm apart with 4 cm of deviation each: 0.05 > 0.0032, as the paper prints it, would not
    // match, nor would -0.05 < 0.0032 ever fail.
    let sigma = [0.04, 0.05];
    let a = segment(2.0, 0.3, 0.0, 0.5, sigma);
    assert_eq!(
        map_of(&[(a, 4), (segment(2.05, 0.3, 0.0, 0.5, sigma), 4)])
            .features()
            .len(),
        1
    );
    assert_eq!(
        map_of(&[(a, 4), (segment(2.06, 0.3, 0.0, 0.5, sigma), 4)])
            .features()
            .len(),
        2
    );
    assert_eq!(
        map_of(&[(a, 4), (segment(1.94, 0.3, 0.0, 0.5, sigma), 4)])
            .features()
            .len(),
        2
    );
}

#[test]
fn lines_that_do_not_overlap_stay_apart() {
    let sigma = [0.05, 0.05];
    let a = segment(2.0, 0.3, 0.0, 0.5, sigma);
    let b = segment(2.0, 0.3, 1.1, 0.5, sigma);
    assert_eq!(map_of(&[(a, 4), (b, 4)]).features().len(), 2);
}

#[test]
fn the_fused_segment_spans_both() {
    let sigma = [0.05, 0.05];
    let a = segment(2.0, 0.3, 0.0, 0.5, sigma);
    let b = segment(2.0, 0.3, 0.8, 0.5, sigma);
    let fused = line(&only(&map_of(&[(a, 4), (b, 4)])));
    assert!(
        (fused.half_length - 0.9).abs() < 1e-12,
        "{}",
        fused.half_length
    );
}

#[test]
fn the_nearest_match_wins_and_ids_stay() {
    let mut map = Map::new(&Config::with_rule(Rule::Paper));
    let point = |x: f64| {
        Shape::Point(Point {
            position: Vec2::new(x, 0.0),
            covariance: Matrix2::identity(),
        })
    };
    assert_eq!(
        map.add(point(0.0), &readings(3)).action,
        Action::Registered(0)
    );
    assert_eq!(
        map.add(point(0.3), &readings(3)).action,
        Action::Registered(1)
    );
    assert_eq!(map.add(point(0.18), &readings(3)).action, Action::Merged(1));
    assert_eq!(map.add(point(0.05), &readings(3)).action, Action::Merged(0));
    assert_eq!(
        map.add(point(0.6), &readings(3)).action,
        Action::Registered(2)
    );
}
