//! Fusion by information: inverse covariances, and Mahalanobis distances as gates.

use nalgebra::{Matrix2, Vector2};

use super::{overlap, signed_like, spanning};
use crate::core::geometry::wrap_angle;
use crate::core::tmam::feature::{Point, Segment, Shape};

/// Squared Mahalanobis distance of two features (two degrees of freedom); `None` where they are of
/// different kinds, or lie farther apart along a wall than `max_wall_gap` metres.
pub fn distance(a: &Shape, b: &Shape, max_wall_gap: f64) -> Option<f64> {
    match (a, b) {
        (Shape::Line(a), Shape::Line(b)) => {
            if overlap(a, b) < -max_wall_gap {
                return None;
            }
            let difference = LineDifference::between(a, b);
            mahalanobis(difference.residual, difference.covariance())
        }
        (Shape::Point(a), Shape::Point(b)) => {
            mahalanobis(b.position - a.position, a.covariance + b.covariance)
        }
        _ => None,
    }
}

/// The estimate of both, each weighted with its information.
pub fn fuse(registered: &Shape, other: &Shape) -> Shape {
    match (registered, other) {
        (Shape::Line(r), Shape::Line(o)) => {
            let difference = LineDifference::between(r, o);
            let Some((step, covariance)) =
                gain(difference.residual, difference.registered, difference.other)
            else {
                return *registered;
            };
            let (local, _) = r.about(difference.origin);
            let line = r.with_line_about(difference.origin, local + step, covariance);
            Shape::Line(spanning(line, &[*r, signed_like(o, r)]).canonical())
        }
        (Shape::Point(r), Shape::Point(o)) => {
            let Some((step, covariance)) =
                gain(o.position - r.position, r.covariance, o.covariance)
            else {
                return *registered;
            };
            Shape::Point(Point {
                position: r.position + step,
                covariance,
            })
        }
        (kept, _) => *kept,
    }
}

/// Two lines seen from the middle of the second, where (distance, theta) are nearly independent and
/// a turn moves nothing.
struct LineDifference {
    origin: Vector2<f64>,
    residual: Vector2<f64>,
    registered: Matrix2<f64>,
    other: Matrix2<f64>,
}

impl LineDifference {
    fn between(registered: &Segment, other: &Segment) -> Self {
        let other = signed_like(other, registered);
        let origin = other.mid;
        let (r, r_covariance) = registered.about(origin);
        let (o, o_covariance) = other.about(origin);
        Self {
            origin,
            residual: Vector2::new(o.x - r.x, wrap_angle(o.y - r.y)),
            registered: r_covariance,
            other: o_covariance,
        }
    }

    fn covariance(&self) -> Matrix2<f64> {
        self.registered + self.other
    }
}

fn mahalanobis(residual: Vector2<f64>, covariance: Matrix2<f64>) -> Option<f64> {
    let inverse = covariance.try_inverse()?;
    Some(residual.dot(&(inverse * residual)))
}

/// The step from the first of two estimates to the fused one, and its covariance.
fn gain(
    residual: Vector2<f64>,
    first: Matrix2<f64>,
    second: Matrix2<f64>,
) -> Option<(Vector2<f64>, Matrix2<f64>)> {
    let gain = first * (first + second).try_inverse()?;
    let covariance = first - gain * first;
    Some((gain * residual, (covariance + covariance.transpose()) / 2.0))
}
