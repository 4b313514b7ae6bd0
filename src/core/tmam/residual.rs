//! The range that a feature should give a sensor, and how far a reading is from it: observation models
//! (6) and (7).

use std::f64::consts::PI;

use nalgebra::{RowVector2, Vector2};

use super::arc::Arc;
use super::circle::circle_range;
use super::feature::{Circle, Point, Segment, Shape};
use crate::core::geometry::{Vec2, direction, unit, wrap_angle};
use crate::core::ties;

/// The range (6) to a line at (distance from the origin along the normal, theta), negative behind it,
/// and its derivative by the two. The sensor is in the frame that the line is in.
pub fn line_range(line: Vector2<f64>, sensor: Vec2) -> (f64, RowVector2<f64>) {
    let normal = unit(line.y);
    let range = line.x - sensor.dot(&normal); // (19)
    let by_theta = normal.y * sensor.x - normal.x * sensor.y; // (21)
    (range, RowVector2::new(1.0, by_theta)) // (20)
}

/// The range (7) to a point and its derivative by the point's coordinates; `None` where the sensor
/// stands on it.
pub fn point_range(point: Vec2, sensor: Vec2) -> Option<(f64, RowVector2<f64>)> {
    let from_sensor = point - sensor;
    let range = from_sensor.norm(); // (7)
    (range > 0.0).then(|| (range, from_sensor.transpose() / range)) // (14), (15) by x and y
}

/// How far a reading is from what a feature of the map should have given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeResidual {
    /// Range beyond the feature, metres.
    pub residual: f64,
    /// Its variance, square metres: the reading's and the feature's.
    pub variance: f64,
    /// The bearing in the world at which the sensor sees the feature.
    pub bearing: f64,
}

impl RangeResidual {
    /// `None` where the sensor stands on a point.
    pub fn of(shape: &Shape, arc: &Arc) -> Option<Self> {
        match shape {
            Shape::Line(segment) => Some(Self::of_line(segment, arc)),
            Shape::Point(point) => Self::of_point(point, arc),
            Shape::Circle(circle) => Self::of_circle(circle, arc),
        }
    }

    /// Of a wall, from either side, wherever it ends.
    pub fn of_line(segment: &Segment, arc: &Arc) -> Self {
        let line = Vector2::new(segment.rho, segment.theta);
        let (range, jacobian) = line_range(line, arc.center());
        let variance = (jacobian * segment.covariance * jacobian.transpose()).x;
        let bearing = if range < 0.0 {
            wrap_angle(segment.theta + PI)
        } else {
            segment.theta
        };
        Self {
            residual: arc.range - range.abs(),
            variance: arc.variance + variance.max(0.0),
            bearing,
        }
    }

    /// Of a corner or an edge.
    pub fn of_point(point: &Point, arc: &Arc) -> Option<Self> {
        let (range, ray) = point_range(point.position, arc.center())?;
        let variance = (ray * point.covariance * ray.transpose()).x;
        (range > ties::LENGTH).then(|| Self {
            residual: arc.range - range,
            variance: arc.variance + variance.max(0.0),
            bearing: direction(ray.transpose()),
        })
    }

    /// Of a cylinder; `None` where the sensor stands in it.
    pub fn of_circle(circle: &Circle, arc: &Arc) -> Option<Self> {
        let (range, by) = circle_range(&circle.parameters(), arc.center())?;
        let variance = (by * circle.covariance * by.transpose()).x;
        (range > ties::LENGTH).then(|| Self {
            residual: arc.range - range,
            variance: arc.variance + variance.max(0.0),
            bearing: direction(by.transpose().xy()),
        })
    }

    /// In standard deviations, squared.
    pub fn chi2(&self) -> f64 {
        self.residual * self.residual / self.variance
    }

    /// Whether the beam of the reading holds the feature.
    pub fn is_in_beam(&self, arc: &Arc) -> bool {
        arc.beam_nearly_holds(self.bearing, ties::ANGLE)
    }
}
