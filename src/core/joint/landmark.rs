//! A feature as an unknown of the joint estimate.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix2, RowVector2, Vector2};

use crate::core::geometry::{Vec2, angle_between, unit, wrap_angle};
use crate::core::tmam::feature::{Point, Segment, Shape};
use crate::core::tmam::residual::{line_range, point_range};

/// A feature over two parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Landmark {
    /// A line over (distance along its normal, theta), seen from a place near its own middle, where the
    /// two are nearly independent.
    Line {
        /// That place.
        origin: Vec2,
        /// The parameters.
        local: Vector2<f64>,
    },
    /// A point over (x, y).
    Point(Vec2),
}

/// The range that a landmark gives a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Metres.
    pub range: f64,
    /// Its derivative by the landmark's parameters.
    pub by_landmark: RowVector2<f64>,
    /// Its derivative by the sensor's place.
    pub by_sensor: RowVector2<f64>,
}

impl Landmark {
    /// From where a feature is.
    pub fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Line(segment) => Self::Line {
                origin: segment.mid,
                local: segment.about(segment.mid).0,
            },
            Shape::Point(point) => Self::Point(point.position),
        }
    }

    /// The parameters moved by `step`.
    pub fn moved(&self, step: Vector2<f64>) -> Self {
        match *self {
            Self::Line { origin, local } => Self::Line {
                origin,
                local: local + step,
            },
            Self::Point(position) => Self::Point(position + step),
        }
    }

    /// The range (6) or (7) that a sensor should measure, from whichever side of a line it is on; `None`
    /// where it stands on a point.
    pub fn predict(&self, sensor: Vec2) -> Option<Predicted> {
        match *self {
            Self::Line { origin, local } => {
                let (range, by_landmark) = line_range(local, sensor - origin); // (6)
                let side = if range < 0.0 { -1.0 } else { 1.0 };
                Some(Predicted {
                    range: side * range,
                    by_landmark: by_landmark * side,
                    by_sensor: unit(local.y).transpose() * -side,
                })
            }
            Self::Point(position) => {
                let (range, by_landmark) = point_range(position, sensor)?; // (7)
                Some(Predicted {
                    range,
                    by_landmark,
                    by_sensor: -by_landmark,
                })
            }
        }
    }

    /// The parameters of a line as seen from another place, and their derivative by its own.
    pub fn line_about(&self, place: Vec2) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let Self::Line { origin, local } = *self else {
            return None;
        };
        let (normal, along) = (unit(local.y), unit(local.y + FRAC_PI_2));
        let away = origin - place;
        let about = Vector2::new(local.x + normal.dot(&away), local.y);
        Some((about, Matrix2::new(1.0, along.dot(&away), 0.0, 1.0)))
    }

    /// How far two landmarks of one kind are apart, by two numbers, and the derivatives of these by the
    /// parameters of each. Lines are compared at `place`.
    pub fn difference(
        &self,
        other: &Self,
        place: Vec2,
    ) -> Option<(Vector2<f64>, [Matrix2<f64>; 2])> {
        match (self, other) {
            (Self::Point(a), Self::Point(b)) => {
                Some((a - b, [Matrix2::identity(), -Matrix2::identity()]))
            }
            (Self::Line { .. }, Self::Line { .. }) => {
                let (a, by_a) = self.line_about(place)?;
                let (mut b, mut by_b) = other.line_about(place)?;
                // (distance, theta) and (-distance, theta + pi) are one line.
                if angle_between(a.y, b.y) > FRAC_PI_2 {
                    b = Vector2::new(-b.x, b.y + PI);
                    by_b = Matrix2::new(-1.0, 0.0, 0.0, 1.0) * by_b;
                }
                let apart = Vector2::new(a.x - b.x, wrap_angle(a.y - b.y));
                Some((apart, [by_a, -by_b]))
            }
            _ => None,
        }
    }

    /// The feature with a covariance over the parameters; a line reaches as far as the feet of `sensors`.
    pub fn shape(&self, covariance: Matrix2<f64>, sensors: &[Vec2]) -> Shape {
        let covariance = (covariance + covariance.transpose()) / 2.0;
        match *self {
            Self::Line { origin, local } => {
                let line = Segment::of_line_about(origin, local, covariance);
                Shape::Line(line.reaching_over(sensors.iter().copied()).canonical())
            }
            Self::Point(position) => Shape::Point(Point {
                position,
                covariance,
            }),
        }
    }

    /// The feature with a covariance over the parameters; a line reaches as far as a known one does.
    pub fn covering(&self, covariance: Matrix2<f64>, known: &Shape) -> Shape {
        match known {
            Shape::Line(segment) => self.shape(covariance, &segment.ends()),
            Shape::Point(_) => self.shape(covariance, &[]),
        }
    }
}
