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
    /// From where a feature is; circles are none.
    pub fn of(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Line(segment) => Some(Self::Line {
                origin: segment.mid,
                local: segment.about(segment.mid).0,
            }),
            Shape::Point(point) => Some(Self::Point(point.position)),
            Shape::Circle(_) => None,
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
            Shape::Point(_) | Shape::Circle(_) => self.shape(covariance, &[]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn line(x: f64, y: f64, distance: f64, theta: f64) -> Landmark {
        Landmark::Line {
            origin: Vec2::new(x, y),
            local: Vector2::new(distance, theta),
        }
    }

    fn hold_derivatives(landmark: Landmark, sensor: Vec2) -> Result<(), TestCaseError> {
        const STEP: f64 = 1e-6;
        let predicted = landmark.predict(sensor).unwrap();
        prop_assume!(predicted.range > 0.05);
        for axis in 0..2 {
            let step = Vector2::ith(axis, STEP);
            let range = |landmark: Landmark, sensor| landmark.predict(sensor).unwrap().range;
            let by_landmark = (range(landmark.moved(step), sensor)
                - range(landmark.moved(-step), sensor))
                / (2.0 * STEP);
            prop_assert!((by_landmark - predicted.by_landmark[axis]).abs() < 1e-6);
            let by_sensor =
                (range(landmark, sensor + step) - range(landmark, sensor - step)) / (2.0 * STEP);
            prop_assert!((by_sensor - predicted.by_sensor[axis]).abs() < 1e-6);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn the_derivatives_are_those_of_the_range(
            x in -5.0..5.0, y in -5.0..5.0, d in -0.5..0.5, t in -3.0..3.0, sx in -5.0..5.0, sy in -5.0..5.0,
        ) {
            let sensor = Vec2::new(sx, sy);
            hold_derivatives(line(x, y, d, t), sensor)?;
            hold_derivatives(Landmark::Point(Vec2::new(x, y)), sensor)?;
        }

        #[test]
        fn the_derivatives_of_a_difference_are_right(
            d in -0.2..0.2, t in -0.3..0.3, e in -0.2..0.2_f64, px in -3.0..3.0, flipped: bool,
        ) {
            const STEP: f64 = 1e-6;
            let a = line(0.0, 0.0, d, 1.0 + t);
            let b = if flipped {
                line(1.0, 0.5, -e, 1.0 + std::f64::consts::PI)
            } else {
                line(1.0, 0.5, e, 1.0)
            };
            let place = Vec2::new(px, 0.3);
            let (_, [by_a, by_b]) = a.difference(&b, place).unwrap();
            for axis in 0..2 {
                let step = Vector2::ith(axis, STEP);
                let apart = |a: Landmark, b: Landmark| a.difference(&b, place).unwrap().0;
                let found_a = (apart(a.moved(step), b) - apart(a.moved(-step), b)) / (2.0 * STEP);
                let found_b = (apart(a, b.moved(step)) - apart(a, b.moved(-step))) / (2.0 * STEP);
                prop_assert!((found_a - by_a.column(axis)).norm() < 1e-6);
                prop_assert!((found_b - by_b.column(axis)).norm() < 1e-6);
            }
        }
    }
}
