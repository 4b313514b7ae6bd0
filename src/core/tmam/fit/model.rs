//! What is fitted to the readings of a run: a line (6), in the frame of its first sensor (16), or a
//! point (7), in Cartesian coordinates.
//!
//! The paper fits (rho, alpha) of a point, which are singular where it lies near the world's origin,
//! as point 1 of its Table I does.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix2, RowVector2, Vector2};

use crate::core::geometry::{Pose2, Vec2, direction, unit, wrap_angle};
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{Point, Rejection, Segment, Shape};
use crate::core::tmam::gauss_newton::Observation;
use crate::core::tmam::pair::{PairPoint, Points};
use crate::core::tmam::residual::{line_range, point_range};

/// An observation model for the readings of a run, with what it takes to find a start and to see
/// whether the estimate makes sense.
pub trait Model: Observation {
    /// The points of a pair of arcs that suggest a start.
    fn suggesting(&self, points: &Points) -> [Option<PairPoint>; 2];

    /// The parameters that such a point suggests.
    fn through(&self, point: &PairPoint) -> Vector2<f64>;

    /// The mirror image at the line through two sensor centres.
    fn mirrored(&self, parameters: Vector2<f64>, first: &Arc, last: &Arc) -> Vector2<f64>;

    /// Whether the beam of an arc holds the feature, with `slack` radians on either side.
    fn in_beam(&self, parameters: Vector2<f64>, arc: &Arc, slack: f64) -> bool;

    /// Variance of the bearing at which the first arc sees the feature.
    fn bearing_variance(&self, estimate: &Estimate, first: &Arc) -> f64;

    /// Norm of a step with lengths in centimetres and angles in radians, as the paper adds them.
    fn step_norm(&self, step: Vector2<f64>) -> f64;

    /// The estimate in the world; `arcs` are those that it was fitted to.
    fn shape(&self, estimate: &Estimate, arcs: &[Arc]) -> Shape;
}

/// The estimate of (10) with its mean square error (12), in the parameters of the model.
pub struct Estimate {
    pub parameters: Vector2<f64>,
    pub covariance: Matrix2<f64>,
    pub residual_rms: f64,
    pub iterations: u32,
    pub converged: bool,
    pub rejection: Option<Rejection>,
    pub outliers: Vec<ArcId>,
}

/// Lines over (p_r, p_theta) in a local frame: origin at the first sensor, y along its bearing.
pub struct LocalLine {
    world_from_local: Pose2,
}

impl LocalLine {
    pub fn new(first: &Arc) -> Self {
        let sensor = first.world_from_sensor;
        Self {
            world_from_local: Pose2::new(sensor.x, sensor.y, sensor.yaw - FRAC_PI_2), // (16)
        }
    }
}

impl Observation for LocalLine {
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        let sensor = self.world_from_local.inverse_transform(arc.center());
        Some(line_range(parameters, sensor))
    }
}

impl Model for LocalLine {
    fn suggesting(&self, points: &Points) -> [Option<PairPoint>; 2] {
        points.contact
    }

    fn through(&self, point: &PairPoint) -> Vector2<f64> {
        let theta = point.bearing_a - self.world_from_local.yaw;
        let touch = self.world_from_local.inverse_transform(point.on_a);
        Vector2::new(touch.dot(&unit(theta)), theta)
    }

    fn mirrored(&self, parameters: Vector2<f64>, first: &Arc, last: &Arc) -> Vector2<f64> {
        let path = direction(last.center() - first.center()) - self.world_from_local.yaw;
        // The local origin is a sensor on the path, so the distance from it stays.
        Vector2::new(parameters.x, wrap_angle(2.0 * path - parameters.y))
    }

    fn in_beam(&self, parameters: Vector2<f64>, arc: &Arc, slack: f64) -> bool {
        let in_front = self
            .predict(parameters, arc)
            .is_some_and(|(range, _)| range > 0.0); // (18)
        in_front && arc.beam_nearly_holds(parameters.y + self.world_from_local.yaw, slack)
    }

    fn bearing_variance(&self, estimate: &Estimate, _: &Arc) -> f64 {
        estimate.covariance.m22
    }

    fn step_norm(&self, step: Vector2<f64>) -> f64 {
        Vector2::new(100.0 * step.x, step.y).norm()
    }

    /// The line and its covariance (23); its ends are the extreme tangent points.
    fn shape(&self, estimate: &Estimate, arcs: &[Arc]) -> Shape {
        let local = Vector2::new(
            estimate.parameters.x,
            estimate.parameters.y + self.world_from_local.yaw,
        );
        let origin = self.world_from_local.position();
        let line = Segment::of_line_about(origin, local, estimate.covariance);
        Shape::Line(line.reaching_over(arcs.iter().map(Arc::center)).canonical())
    }
}

/// Lines over (distance along the normal, theta) seen from a place on a known one, so that the two are
/// nearly independent. Readings may come from either side.
pub struct LineFromEitherSide {
    origin: Vec2,
    normal: Vec2,
}

impl LineFromEitherSide {
    pub fn of(segment: &Segment) -> Self {
        Self {
            origin: segment.mid,
            normal: unit(segment.theta),
        }
    }

    /// The estimate in the world; it reaches as far as the feet of the arcs' sensors.
    pub fn shape(&self, estimate: &Estimate, arcs: &[Arc]) -> Shape {
        let line = Segment::of_line_about(self.origin, estimate.parameters, estimate.covariance);
        Shape::Line(line.reaching_over(arcs.iter().map(Arc::center)))
    }
}

impl Observation for LineFromEitherSide {
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        let sensor = arc.center() - self.origin;
        let (range, jacobian) = line_range(parameters, sensor);
        // The side that the sensor is on is that of the line as it was, (17) and (18).
        let is_behind = self.normal.dot(&sensor) > 0.0;
        Some(if is_behind {
            (-range, -jacobian)
        } else {
            (range, jacobian)
        })
    }
}

/// Points over (x, y) in the world.
pub struct CartesianPoint;

impl Observation for CartesianPoint {
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        point_range(parameters, arc.center())
    }
}

impl Model for CartesianPoint {
    fn suggesting(&self, points: &Points) -> [Option<PairPoint>; 2] {
        points.intersection
    }

    fn through(&self, point: &PairPoint) -> Vector2<f64> {
        point.on_a
    }

    fn mirrored(&self, parameters: Vector2<f64>, first: &Arc, last: &Arc) -> Vector2<f64> {
        let path = last.center() - first.center();
        let along = path / path.norm().max(f64::MIN_POSITIVE);
        let from_path = parameters - first.center();
        first.center() + along * (2.0 * along.dot(&from_path)) - from_path
    }

    fn in_beam(&self, parameters: Vector2<f64>, arc: &Arc, slack: f64) -> bool {
        arc.beam_nearly_holds(direction(parameters - arc.center()), slack)
    }

    fn bearing_variance(&self, estimate: &Estimate, first: &Arc) -> f64 {
        let away = estimate.parameters - first.center();
        let across = Vec2::new(-away.y, away.x) / away.norm_squared().max(f64::MIN_POSITIVE);
        across.dot(&(estimate.covariance * across))
    }

    fn step_norm(&self, step: Vector2<f64>) -> f64 {
        100.0 * step.norm()
    }

    fn shape(&self, estimate: &Estimate, _: &[Arc]) -> Shape {
        Shape::Point(Point {
            position: estimate.parameters,
            covariance: estimate.covariance,
        })
    }
}
