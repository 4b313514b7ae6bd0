//! A feature held against a wall or point of the world.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix2, Vector2};

use crate::geometry::{Vec2, angle_between, direction, unit, wrap_angle};
use crate::tmam::feature::{Point, Segment, Shape};
use crate::world::{Reflector, Wall, World};

/// A segment whose middle lies farther than this from a wall's line is not that wall, metres.
pub const LINE_OFFSET: f64 = 0.10;
/// A segment turned more than this against a wall is not that wall, radians.
pub const LINE_ANGLE: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// A point farther than this from another is not that point, metres.
pub const POINT_DISTANCE: f64 = 0.20;

/// How far a feature is from the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Error {
    /// Of a line: feature minus truth.
    Line {
        /// Seen from the wall's middle, metres: positive where the line is farther from the origin.
        rho: f64,
        /// Radians.
        theta: f64,
        /// Seen from the world's origin, metres: it grows with the distance from there.
        rho_at_origin: f64,
    },
    /// Of a point: metres from it.
    Point {
        /// Metres.
        distance: f64,
    },
}

/// A feature held against the wall or point that it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// How far it is from it.
    pub error: Error,
    /// Normalised error squared, e^T P^-1 e, with two degrees of freedom; `None` where the
    /// covariance has no inverse.
    pub nees: Option<f64>,
    /// For an assignment: 0 for a perfect match, at most 3; `None` beyond the gates.
    pub cost: Option<f64>,
}

/// Holds a feature against a reflector; `None` where one is a line and the other a point.
pub fn compare(shape: &Shape, reflector: Reflector, world: &World) -> Option<Comparison> {
    match (shape, reflector) {
        (Shape::Line(segment), Reflector::Line(index)) => Some(compare_line(
            segment,
            &TrueLine::of(world.walls().get(index)?),
        )),
        (Shape::Point(point), Reflector::Point(index)) => {
            Some(compare_point(point, *world.points().get(index)?))
        }
        _ => None,
    }
}

/// The place of a wall's line that is nearest to `place`, or the point itself.
pub fn nearest_truth(place: Vec2, reflector: Reflector, world: &World) -> Option<Vec2> {
    match reflector {
        Reflector::Line(index) => {
            let line = TrueLine::of(world.walls().get(index)?);
            Some(line.start + line.along * (place - line.start).dot(&line.along))
        }
        Reflector::Point(index) => world.points().get(index).copied(),
    }
}

/// A wall as the estimator parametrises lines.
#[derive(Debug, Clone, Copy)]
pub struct TrueLine {
    rho: f64,
    theta: f64,
    start: Vec2,
    along: Vec2,
    /// Metres.
    pub length: f64,
}

impl TrueLine {
    /// The line of a wall.
    pub fn of(wall: &Wall) -> Self {
        let span = wall.end - wall.start;
        let length = span.norm();
        let along = span / length;
        let normal = Vec2::new(-along.y, along.x);
        // With rho >= 0, as the map has its lines: a positive error is away from the origin.
        let normal = if normal.dot(&wall.start) < 0.0 {
            -normal
        } else {
            normal
        };
        Self {
            rho: normal.dot(&wall.start),
            theta: direction(normal),
            start: wall.start,
            along,
            length,
        }
    }

    /// The place `way` metres along the wall from its start.
    pub fn at(&self, way: f64) -> Vec2 {
        self.start + self.along * way
    }

    /// The part of the wall that lies beside a segment, as ways from its start in metres; the
    /// first is the larger where there is none.
    pub fn beside(&self, segment: &Segment) -> (f64, f64) {
        let (low, high) = self.span(segment);
        (low.max(0.0), high.min(self.length))
    }

    fn span(&self, segment: &Segment) -> (f64, f64) {
        let [a, b] = segment
            .ends()
            .map(|end| (end - self.start).dot(&self.along));
        (a.min(b), a.max(b))
    }
}

fn compare_line(segment: &Segment, wall: &TrueLine) -> Comparison {
    // (rho, theta) and (-rho, theta + pi) are one line.
    let segment = if angle_between(segment.theta, wall.theta) > FRAC_PI_2 {
        segment.flipped()
    } else {
        *segment
    };
    // Seen from the wall's middle, a room far from the origin has the figures of one that is near.
    let (local, covariance) = segment.about(wall.at(wall.length / 2.0));
    let (rho, theta) = (local.x, wrap_angle(segment.theta - wall.theta));
    let (low, high) = wall.beside(&segment);
    // A short piece of wall does not say how a line goes on: what counts is where it passes it.
    let place = wall.at((low + high) / 2.0);
    let offset = unit(segment.theta).dot(&(segment.mid - place));
    let within = low <= high && offset.abs() <= LINE_OFFSET && theta.abs() <= LINE_ANGLE;
    let square = |x: f64| x * x;
    let beside = if segment.half_length > 0.0 {
        (high - low) / (2.0 * segment.half_length)
    } else {
        1.0
    };
    let cost = square(offset / LINE_OFFSET) + square(theta / LINE_ANGLE) + 1.0 - beside.min(1.0);
    Comparison {
        error: Error::Line {
            rho,
            theta,
            rho_at_origin: segment.rho - wall.rho,
        },
        nees: nees(Vector2::new(rho, theta), &covariance),
        cost: within.then_some(cost),
    }
}

fn compare_point(point: &Point, truth: Vec2) -> Comparison {
    let error = point.position - truth;
    let distance = error.norm();
    let cost = distance / POINT_DISTANCE;
    Comparison {
        error: Error::Point { distance },
        nees: nees(error, &point.covariance),
        cost: (cost <= 1.0).then_some(cost * cost),
    }
}

/// e^T P^-1 e.
fn nees(error: Vector2<f64>, covariance: &Matrix2<f64>) -> Option<f64> {
    let nees = error.dot(&(covariance.try_inverse()? * error));
    (nees.is_finite() && nees >= 0.0).then_some(nees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tmam::fit::testing::Gauss;
    use proptest::prelude::*;

    /// A wall from `way` on along the line (rho, theta), 3 m long.
    fn wall(rho: f64, theta: f64, way: f64) -> World {
        let along = unit(theta + FRAC_PI_2);
        let start = unit(theta) * rho + along * way;
        World::new(vec![Wall::new(start, start + along * 3.0)], Vec::new()).unwrap()
    }

    /// A segment on the line (rho, theta) from `way` on.
    fn segment(rho: f64, theta: f64, way: f64, length: f64) -> Segment {
        let along = unit(theta + FRAC_PI_2);
        Segment {
            rho,
            theta,
            covariance: Matrix2::new(1e-4, 2e-5, 2e-5, 1e-5),
            mid: unit(theta) * rho + along * (way + length / 2.0),
            half_length: length / 2.0,
        }
    }

    fn held(segment: Segment, world: &World) -> Comparison {
        compare(&Shape::Line(segment), Reflector::Line(0), world).unwrap()
    }

    proptest! {
        #[test]
        fn the_sign_of_rho_and_the_order_of_the_ends_do_not_matter(
            rho in -4.0..4.0f64, theta in -3.2..3.2f64, way in -9.0..9.0f64,
            e in -0.02..0.02f64, t in -0.02..0.02f64,
        ) {
            let world = wall(rho, theta, way);
            let [end, start] = [world.walls()[0].start, world.walls()[0].end];
            let turned = World::new(vec![Wall::new(start, end)], Vec::new()).unwrap();
            let found = segment(rho + e, theta + t, way, 1.0);
            let plain = held(found, &world);
            let Error::Line { rho_at_origin: a, theta: b, .. } = plain.error else { panic!() };
            prop_assert!((a.abs() - e.abs()).abs() < 1e-9 && (b - t).abs() < 1e-9);
            prop_assert!(rho.abs() < 1e-9 || (a * rho.signum() - e).abs() < 1e-9, "{a} {e}");
            for (other, world) in [(found.flipped(), &world), (found, &turned), (found.canonical(), &turned)] {
                let other = held(other, world);
                prop_assert!((other.nees.unwrap() - plain.nees.unwrap()).abs() < 1e-6);
                prop_assert_eq!(other.cost.is_some(), plain.cost.is_some());
            }
        }
    }

    proptest! {
        #[test]
        fn a_room_far_away_has_the_figures_of_one_that_is_near(
            theta in -3.2..3.2f64, way in -9.0..9.0f64, e in -0.02..0.02f64, t in -0.02..0.02f64,
            far_x in -2e6..2e6f64, far_y in -1e7..1e7f64,
        ) {
            let near = World::new(vec![Wall::new(Vec2::zeros(), unit(theta) * 3.0)], vec![]).unwrap();
            let shift = Vec2::new(far_x, far_y);
            let far = World::new(vec![Wall::new(shift, shift + unit(theta) * 3.0)], vec![]).unwrap();
            // The line seen from a place of the wall, and the same in both worlds.
            let local = Vector2::new(e, theta + FRAC_PI_2 + t);
            let covariance = Matrix2::new(1e-4, 2e-5, 2e-5, 1e-5);
            let at = |origin: Vec2, world: &World| {
                let mid = origin + unit(theta) * way.clamp(0.0, 3.0);
                let segment = Segment { mid, half_length: 0.5, ..segment(0.0, 0.0, 0.0, 1.0) };
                held(segment.with_line_about(mid, local, covariance), world)
            };
            let (a, b) = (at(Vec2::zeros(), &near), at(shift, &far));
            let (Error::Line { rho: p, theta: r, .. }, Error::Line { rho: q, theta: s, .. }) =
                (a.error, b.error) else { panic!() };
            prop_assert!((p.abs() - q.abs()).abs() < 1e-6 && (r - s).abs() < 1e-8, "{p} {q} {r} {s}");
            let (a, b) = (a.nees.unwrap(), b.nees.unwrap());
            prop_assert!((a - b).abs() < 0.01 * (1.0 + a), "{a} {b}");
        }
    }

    #[test]
    fn a_segment_beyond_a_gate_is_not_the_wall() {
        let world = wall(2.0, 0.3, 0.0);
        let is_wall = |segment| held(segment, &world).cost.is_some();
        assert!(is_wall(segment(2.0, 0.3, 0.5, 1.0)));
        assert!(is_wall(segment(2.09, 0.3, 0.5, 1.0)));
        assert!(!is_wall(segment(2.11, 0.3, 0.5, 1.0)), "too far off");
        assert!(is_wall(segment(2.0, 0.3, 2.9, 1.0)));
        assert!(!is_wall(segment(2.0, 0.3, 3.1, 1.0)), "past its end");
        assert!(!is_wall(segment(2.0, 0.3, -1.1, 1.0)), "before its start");
        let tilted = |tilt: f64| Segment {
            theta: 0.3 + tilt,
            ..segment(2.0, 0.3, 0.5, 1.0)
        };
        assert!(is_wall(tilted(0.17)));
        assert!(!is_wall(tilted(0.18)), "turned");
        assert!(is_wall(segment(2.0, 0.3, 1.0, 0.0)), "without length");
    }

    #[test]
    fn a_point_is_another_up_to_20_centimetres() {
        let world = World::new(Vec::new(), vec![Vec2::new(1.0, 1.0)]).unwrap();
        let at = |x: f64| {
            let point = Shape::Point(Point {
                position: Vec2::new(x, 1.0),
                covariance: Matrix2::identity() * 0.01,
            });
            compare(&point, Reflector::Point(0), &world).unwrap()
        };
        assert!(at(1.199).cost.is_some());
        assert_eq!(at(1.201).cost, None);
        assert!((at(1.1).nees.unwrap() - 1.0).abs() < 1e-9);
        assert_eq!(
            at(1.1).error,
            Error::Point {
                distance: 1.1 - 1.0
            }
        );
    }

    #[test]
    fn a_covariance_without_an_inverse_has_no_nees() {
        let world = World::new(Vec::new(), vec![Vec2::zeros()]).unwrap();
        let point = Shape::Point(Point {
            position: Vec2::new(0.1, 0.0),
            covariance: Matrix2::zeros(),
        });
        let held = compare(&point, Reflector::Point(0), &world).unwrap();
        assert_eq!(held.nees, None);
    }

    #[test]
    fn honest_covariances_have_a_nees_of_two() {
        let covariance = Matrix2::new(4e-4, 1e-4, 1e-4, 1e-4);
        let root = covariance.cholesky().unwrap().l();
        let world = wall(3.0, 1.0, 5.0);
        let (mut rng, n) = (Gauss::new(3), 3000);
        let sum: f64 = (0..n)
            .map(|_| {
                let e = root * Vec2::new(rng.sample(), rng.sample());
                let found = Segment {
                    covariance,
                    ..segment(3.0 + e.x, 1.0 + e.y, 5.0, 2.0)
                };
                held(found.flipped(), &world).nees.unwrap()
            })
            .sum();
        let mean = sum / f64::from(n);
        assert!((1.9..2.1).contains(&mean), "{mean}");
    }
}
