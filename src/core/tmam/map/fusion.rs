//! When two features are the same, and what they are together: (24) to (27) with means weighted with
//! numbers of readings, as the paper has it, or by information: inverse covariances, and Mahalanobis
//! distances as gates.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix2, Vector2};

use crate::core::geometry::{angle_between, unit, wrap_angle};
use crate::core::tmam::feature::{Circle, MapFeature, Point, Segment, Shape};

/// How far a feature is from a registered one; `None` beyond the gates.
pub fn deviation(extracted: &Shape, registered: &MapFeature, match_distance: f64) -> Option<f64> {
    match (extracted, &registered.shape) {
        (Shape::Line(e), Shape::Line(r)) => line_deviation(e, r),
        (Shape::Point(e), Shape::Point(r)) => {
            let distance = (e.position - r.position).norm();
            (distance < match_distance).then_some(distance)
        }
        (Shape::Circle(e), Shape::Circle(r)) => {
            let distance = (e.center - r.center).norm();
            (distance < match_distance).then_some(distance)
        }
        _ => None,
    }
}

/// The deviation (27) of two lines that pass the tests (24) to (26).
fn line_deviation(extracted: &Segment, registered: &Segment) -> Option<f64> {
    let e = signed_like(extracted, registered);
    let square = |x: f64| x * x;
    let angle = square(wrap_angle(e.theta - registered.theta));
    let offset = square(e.rho - registered.rho); // the paper's (25) forgets the square
    let apart = (e.mid - registered.mid).norm_squared();
    let angle_gate = e.covariance.m22 + registered.covariance.m22;
    let offset_gate = e.covariance.m11 + registered.covariance.m11;
    let overlap_gate = square(e.half_length + registered.half_length);
    let matches = angle < angle_gate // (24)
        && offset < offset_gate // (25)
        && apart < overlap_gate; // (26)
    matches.then(|| angle / angle_gate + offset / offset_gate + apart / overlap_gate) // (27)
}

/// The n-weighted means of a registered feature and an extracted one.
pub fn fuse_by_readings(registered: &MapFeature, extracted: &Shape, readings: u32) -> Shape {
    let total = registered.readings.saturating_add(readings);
    let weight = f64::from(readings) / f64::from(total.max(1));
    let covariance = |r: &Matrix2<f64>, e: &Matrix2<f64>| r * (1.0 - weight) + e * weight;
    match (&registered.shape, extracted) {
        (Shape::Line(r), Shape::Line(e)) => {
            let e = signed_like(e, r);
            let rho = r.rho + weight * (e.rho - r.rho);
            let theta = r.theta + weight * wrap_angle(e.theta - r.theta);
            let fused = Segment {
                rho,
                theta,
                covariance: covariance(&r.covariance, &e.covariance),
                ..*r
            };
            Shape::Line(
                fused
                    .reaching_over([*r, e].iter().flat_map(Segment::ends))
                    .canonical(),
            )
        }
        (Shape::Point(r), Shape::Point(e)) => Shape::Point(Point {
            position: r.position + (e.position - r.position) * weight,
            covariance: covariance(&r.covariance, &e.covariance),
        }),
        (Shape::Circle(r), Shape::Circle(e)) => Shape::Circle(Circle::of(
            r.parameters() + (e.parameters() - r.parameters()) * weight,
            r.covariance * (1.0 - weight) + e.covariance * weight,
        )),
        (kept, _) => *kept,
    }
}

/// Squared Mahalanobis distance of two features (two degrees of freedom, of circles three); `None` where they are of
/// different kinds, or lie farther apart along a wall than `max_wall_gap` metres.
pub fn mahalanobis_distance(a: &Shape, b: &Shape, max_wall_gap: f64) -> Option<f64> {
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
        (Shape::Circle(a), Shape::Circle(b)) => {
            let apart = b.parameters() - a.parameters();
            let inverse = (a.covariance + b.covariance).try_inverse()?;
            Some(apart.dot(&(inverse * apart)))
        }
        _ => None,
    }
}

/// The estimate of both, each weighted with its information.
pub fn fuse_by_information(registered: &Shape, other: &Shape) -> Shape {
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
            Shape::Line(
                line.reaching_over([*r, *o].iter().flat_map(Segment::ends))
                    .canonical(),
            )
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
        (Shape::Circle(r), Shape::Circle(o)) => {
            let Some(inverse) = (r.covariance + o.covariance).try_inverse() else {
                return *registered;
            };
            let gain = r.covariance * inverse;
            let covariance = r.covariance - gain * r.covariance;
            Shape::Circle(Circle::of(
                r.parameters() + gain * (o.parameters() - r.parameters()),
                (covariance + covariance.transpose()) / 2.0,
            ))
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

/// How many features of a map look like another one: lines that overlap within 5 cm and 5 degrees,
/// points within `match_distance`. The gates of (24) and (25), a standard deviation wide, leave
/// such duplicates.
pub fn duplicates(features: &[MapFeature], match_distance: f64) -> usize {
    features
        .iter()
        .enumerate()
        .filter(|(place, feature)| {
            features
                .iter()
                .take(*place)
                .any(|other| alike(other, feature, match_distance))
        })
        .count()
}

pub fn alike(a: &MapFeature, b: &MapFeature, match_distance: f64) -> bool {
    match (&a.shape, &b.shape) {
        (Shape::Line(a), Shape::Line(b)) => coincide(a, b),
        (Shape::Point(a), Shape::Point(b)) => (a.position - b.position).norm() < match_distance,
        (Shape::Circle(a), Shape::Circle(b)) => (a.center - b.center).norm() < match_distance,
        _ => false,
    }
}

fn coincide(a: &Segment, b: &Segment) -> bool {
    let offset = unit(a.theta).dot(&b.mid) - a.rho;
    let way = a.along().dot(&(b.mid - a.mid)).abs();
    let tilt = angle_between(a.theta, signed_like(b, a).theta);
    offset.abs() < 0.05 && tilt < 5_f64.to_radians() && way < a.half_length + b.half_length
}

/// The segment under the sign of (rho, theta) that is nearer to the other's.
pub fn signed_like(segment: &Segment, other: &Segment) -> Segment {
    if angle_between(segment.theta, other.theta) > FRAC_PI_2 {
        segment.flipped()
    } else {
        *segment
    }
}

/// By how much two segments overlap along the first one's line, metres; negative where there is a
/// gap between them.
pub fn overlap(a: &Segment, b: &Segment) -> f64 {
    let way = a.along().dot(&(b.mid - a.mid)).abs();
    a.half_length + b.half_length - way
}
