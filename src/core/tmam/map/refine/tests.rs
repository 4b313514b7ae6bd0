use super::*;
use crate::core::config::{Config, Rule};
use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::feature::{Point, Segment};
use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};
use nalgebra::Matrix2;
use std::f64::consts::FRAC_PI_2;

/// Along x from 0 to 2, 1 m up, and a corner at its right end.
const CORNER: Vec2 = Vec2::new(2.0, 1.0);

fn feature(id: u32, shape: Shape, readings: u32) -> MapFeature {
    MapFeature {
        id,
        shape,
        readings,
        runs: 2,
        status: Status::Confirmed,
    }
}

/// The wall, `off` metres too far up and turned by `tilt`, reaching to `end`.
fn wall(off: f64, tilt: f64, end: f64) -> MapFeature {
    let middle = Vec2::new(end / 2.0, 1.0 + off);
    let theta = FRAC_PI_2 + tilt;
    feature(
        0,
        Shape::Line(Segment {
            rho: unit(theta).dot(&middle),
            theta,
            covariance: Matrix2::identity() * 1e-7,
            mid: middle,
            half_length: end / 2.0,
        }),
        30,
    )
}

fn point(id: u32, position: Vec2, readings: u32) -> MapFeature {
    let covariance = Matrix2::identity() * 1e-6;
    feature(
        id,
        Shape::Point(Point {
            position,
            covariance,
        }),
        readings,
    )
}

/// A sonar that looks up while it moves along x, on the wall and beyond its corner, and others
/// that look at the corner.
fn arcs(seed: u64) -> Vec<Arc> {
    let mut rng = Gauss::new(seed);
    let mut arcs = Vec::new();
    for k in 0..110 {
        let sensor = Vec2::new(0.02 * f64::from(k), 0.0);
        let range = if sensor.x <= CORNER.x {
            1.0
        } else {
            (CORNER - sensor).norm()
        };
        arcs.push(arc(k, sensor, FRAC_PI_2, range + SIGMA * rng.sample()));
    }
    for k in 0..40 {
        let sensor = Vec2::new(3.0, 0.02 * f64::from(k));
        let towards = CORNER - sensor;
        let yaw = crate::core::geometry::direction(towards);
        arcs.push(arc(
            200 + k,
            sensor,
            yaw,
            towards.norm() + SIGMA * rng.sample(),
        ));
    }
    arcs
}

fn gathered(features: &[MapFeature], arcs: &[Arc]) -> Vec<MapFeature> {
    refine(
        features,
        arcs,
        &Config::with_rule(Rule::NoiseAware).map,
        true,
    )
}

fn line(features: &[MapFeature]) -> Segment {
    match features.iter().find(|f| f.id == 0).map(|f| f.shape) {
        Some(Shape::Line(segment)) => segment,
        other => panic!("no line: {other:?}"),
    }
}

#[test]
fn a_wall_that_its_corner_pulled_at_comes_back_and_its_covariance_is_honest() {
    let (mut nees, seeds) = (0.0, 40);
    for seed in 0..seeds {
        // It reaches 20 cm across its corner, and is off by far more than its covariance says.
        let map = [wall(0.004, 0.003, 2.2), point(1, CORNER, 40)];
        let line = line(&gathered(&map, &arcs(seed)));
        let off = nalgebra::Vector2::new(line.rho - 1.0, line.theta - FRAC_PI_2);
        let inverse = line.covariance.try_inverse().unwrap();
        nees += off.dot(&(inverse * off)) / 2.0;
        assert!(line.covariance.m11.sqrt() < 3.0 * SIGMA / 10.0, "{line:?}");
    }
    let mean = nees / f64::from(u32::try_from(seeds).unwrap());
    assert!((0.6..1.5).contains(&mean), "{mean}");
}

#[test]
fn each_reading_counts_once_and_those_near_the_corner_not_at_all() {
    let map = [wall(0.0, 0.0, 2.0), point(1, CORNER, 40)];
    let found = gathered(&map, &arcs(1));
    let readings: Vec<u32> = found.iter().map(|f| f.readings).collect();
    assert!(
        (90..=101).contains(&readings[0]) && (40..=49).contains(&readings[1]),
        "{readings:?}"
    );
}

#[test]
fn a_corner_that_is_there_twice_is_confirmed_once() {
    let twin = point(2, CORNER + Vec2::new(0.001, 0.001), 20);
    let map = [wall(0.0, 0.0, 2.0), point(1, CORNER, 40), twin];
    let found = gathered(&map, &arcs(2));
    let twin = found.iter().find(|f| f.id == 2).unwrap();
    assert_eq!(twin.status, Status::Tentative);
    let corner = found.iter().find(|f| f.id == 1).unwrap();
    assert_eq!(corner.status, Status::Confirmed);
    assert!(corner.readings > 30, "{corner:?}");
}

#[test]
fn doubles_take_no_rounds_from_the_fits() {
    let twins = (2..20).map(|id| point(id, CORNER + Vec2::new(0.0002 * f64::from(id), 0.0), 20));
    let once = [wall(0.004, 0.003, 2.2), point(1, CORNER, 40)];
    let map: Vec<MapFeature> = once.into_iter().chain(twins).collect();
    let found = gathered(&map, &arcs(2));
    let tentative = found.iter().filter(|f| f.status == Status::Tentative);
    assert_eq!(tentative.count(), 18);
    assert_eq!(line(&found), line(&gathered(&once, &arcs(2))));
}

#[test]
fn what_the_readings_do_not_agree_on_stays_as_it_was() {
    // Half of the readings 4 standard deviations off to either side, as when odometry drifts.
    let map = [wall(0.0, 0.0, 2.0)];
    let mut drifted = arcs(3);
    drifted.truncate(90);
    for (k, arc) in drifted.iter_mut().enumerate() {
        arc.range = 1.0
            + if k % 2 == 0 {
                2.8 * SIGMA
            } else {
                -2.8 * SIGMA
            };
    }
    assert_eq!(gathered(&map, &drifted), []);
}

#[test]
fn without_readings_of_its_own_nothing_changes() {
    assert_eq!(
        gathered(&[wall(0.001, 0.0, 2.0), point(1, CORNER, 40)], &[]),
        []
    );
}
