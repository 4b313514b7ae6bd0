//! How far features are off the walls and points of the world, and whether their covariances say so.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix2, Matrix3, Vector2};
use serde::{Serialize, Serializer};

use crate::core::geometry::{Vec2, angle_between, direction, unit, wrap_angle};
use crate::core::rounding::{number, optional};
use crate::core::statistics::share;
use crate::core::tmam::feature::{Circle, Point, Segment, Shape};
use crate::core::world::{Pillar, Reflector, Wall, World};

/// A segment whose middle lies farther than this from a wall's line is not that wall, metres.
pub const LINE_OFFSET: f64 = 0.10;
/// A segment turned more than this against a wall is not that wall, radians.
pub const LINE_ANGLE: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// A point farther than this from another is not that point, metres.
pub const POINT_DISTANCE: f64 = 0.20;

/// The value that a chi2 with two degrees of freedom exceeds one time in twenty.
const CHI2_95: f64 = 5.991;

/// The same with three.
const CHI2_95_OF_THREE: f64 = 7.815;

/// How far a feature is from the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Error {
    /// Of a line: feature minus truth.
    Line {
        /// Seen from the wall's middle, metres: positive where the line is farther from the origin.
        #[serde(serialize_with = "number")]
        rho: f64,
        /// Radians.
        #[serde(serialize_with = "number")]
        theta: f64,
        /// Seen from the world's origin, metres: it grows with the distance from there.
        #[serde(skip)]
        rho_at_origin: f64,
    },
    /// Of a circle.
    Circle {
        /// Of the centre, metres.
        #[serde(serialize_with = "number")]
        distance: f64,
        /// Feature minus truth, metres.
        #[serde(serialize_with = "number")]
        radius: f64,
    },
    Point {
        /// Metres.
        #[serde(serialize_with = "number")]
        distance: f64,
    },
}

/// A feature held against the wall or point that it should be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison {
    #[serde(flatten)]
    pub error: Error,
    /// Normalised error squared, e^T P^-1 e, with two degrees of freedom, of circles three; `None` where the
    /// covariance has no inverse.
    #[serde(serialize_with = "optional")]
    pub nees: Option<f64>,
    /// For an assignment: 0 for a perfect match, at most 3; `None` beyond the gates.
    #[serde(skip)]
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
        (Shape::Circle(circle), Reflector::Circle(index)) => {
            Some(compare_circle(circle, world.pillars().get(index)?))
        }
        _ => None,
    }
}

/// Serialises a wall or point by its place among those of the world.
///
/// # Errors
/// When the serializer fails.
pub fn index<S: Serializer>(reflector: &Reflector, serializer: S) -> Result<S::Ok, S::Error> {
    reflector.index().serialize(serializer)
}

/// The place of a wall's line that is nearest to `place`, or the point itself.
pub fn nearest_truth(place: Vec2, reflector: Reflector, world: &World) -> Option<Vec2> {
    match reflector {
        Reflector::Line(index) => {
            let line = TrueLine::of(world.walls().get(index)?);
            Some(line.start + line.along * (place - line.start).dot(&line.along))
        }
        Reflector::Point(index) => world.points().get(index).copied(),
        Reflector::Circle(index) => Some(world.pillars().get(index)?.center),
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
        let [a, b] = segment
            .ends()
            .map(|end| (end - self.start).dot(&self.along));
        (a.min(b).max(0.0), a.max(b).min(self.length))
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

fn compare_circle(circle: &Circle, truth: &Pillar) -> Comparison {
    let error = circle.parameters() - truth.center.push(truth.radius);
    let (distance, radius) = (error.xy().norm(), error.z);
    let square = |x: f64| (x / POINT_DISTANCE) * (x / POINT_DISTANCE);
    let inverse = circle.covariance.try_inverse();
    let nees = inverse.map(|inverse: Matrix3<f64>| error.dot(&(inverse * error)));
    let is_near = distance <= POINT_DISTANCE && radius.abs() <= POINT_DISTANCE;
    Comparison {
        error: Error::Circle { distance, radius },
        nees: nees.filter(|nees| nees.is_finite() && *nees >= 0.0),
        cost: is_near.then(|| square(distance) + square(radius)),
    }
}

/// e^T P^-1 e.
fn nees(error: Vector2<f64>, covariance: &Matrix2<f64>) -> Option<f64> {
    let nees = error.dot(&(covariance.try_inverse()? * error));
    (nees.is_finite() && nees >= 0.0).then_some(nees)
}

/// Mean and largest magnitude of an error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Mean magnitude.
    #[serde(serialize_with = "number")]
    pub mean: f64,
    /// Largest magnitude.
    #[serde(serialize_with = "number")]
    pub max: f64,
}

/// Whether the covariances are honest: normalised errors squared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Nees {
    /// Features it is taken over; those without an inverse covariance are left out.
    pub features: u64,
    /// Mean per degree of freedom: 1 where the covariances are honest, more where they are too
    /// small.
    #[serde(serialize_with = "optional")]
    pub mean: Option<f64>,
    /// Share inside the ellipse that should hold 95 %.
    #[serde(serialize_with = "optional")]
    pub within_95: Option<f64>,
}

/// How much they are off.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Of lines, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rho: Option<Spread>,
    /// Of lines, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta: Option<Spread>,
    /// Of points and centres of circles, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<Spread>,
    /// Of circles, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<Spread>,
    /// Against their covariances.
    pub nees: Nees,
}

impl Errors {
    /// Sums up.
    pub fn of<'a>(comparisons: impl Iterator<Item = &'a Comparison> + Clone) -> Self {
        let spread = |of: fn(Error) -> Option<f64>| {
            let errors = comparisons.clone().filter_map(|c| of(c.error));
            let errors: Vec<f64> = errors.map(f64::abs).collect();
            (!errors.is_empty()).then(|| Spread {
                mean: errors.iter().sum::<f64>() / errors.len() as f64,
                max: errors.iter().copied().fold(0.0, f64::max),
            })
        };
        // Each with its degrees of freedom, and what one in twenty exceeds.
        let known = |c: &Comparison| {
            let (freedom, most) = match c.error {
                Error::Circle { .. } => (3, CHI2_95_OF_THREE),
                Error::Line { .. } | Error::Point { .. } => (2, CHI2_95),
            };
            Some((c.nees?, freedom, most))
        };
        let nees: Vec<(f64, u64, f64)> = comparisons.clone().filter_map(known).collect();
        let count = nees.len() as u64;
        let within = nees.iter().filter(|(nees, _, most)| nees <= most).count() as u64;
        let freedom: u64 = nees.iter().map(|(_, freedom, _)| freedom).sum();
        let sum: f64 = nees.iter().map(|(nees, ..)| nees).sum();
        Self {
            rho: spread(|error| match error {
                Error::Line { rho, .. } => Some(rho),
                Error::Point { .. } | Error::Circle { .. } => None,
            }),
            theta: spread(|error| match error {
                Error::Line { theta, .. } => Some(theta),
                Error::Point { .. } | Error::Circle { .. } => None,
            }),
            position: spread(|error| match error {
                Error::Point { distance } | Error::Circle { distance, .. } => Some(distance),
                Error::Line { .. } => None,
            }),
            radius: spread(|error| match error {
                Error::Circle { radius, .. } => Some(radius),
                Error::Line { .. } | Error::Point { .. } => None,
            }),
            nees: Nees {
                features: count,
                mean: (count > 0).then(|| sum / freedom as f64),
                within_95: share(within, count),
            },
        }
    }
}

#[cfg(test)]
mod tests;
