//! The paper's fusion: (24) to (27) and means weighted with numbers of readings.

use nalgebra::Matrix2;

use super::{signed_like, spanning};
use crate::core::geometry::wrap_angle;
use crate::core::tmam::feature::{MapFeature, Point, Segment, Shape};

/// How far a feature is from a registered one; `None` beyond the gates.
pub fn deviation(extracted: &Shape, registered: &MapFeature, match_distance: f64) -> Option<f64> {
    match (extracted, &registered.shape) {
        (Shape::Line(e), Shape::Line(r)) => line_deviation(e, r),
        (Shape::Point(e), Shape::Point(r)) => {
            let distance = (e.position - r.position).norm();
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
pub fn fuse(registered: &MapFeature, extracted: &Shape, readings: u32) -> Shape {
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
            Shape::Line(spanning(fused, &[*r, e]).canonical())
        }
        (Shape::Point(r), Shape::Point(e)) => Shape::Point(Point {
            position: r.position + (e.position - r.position) * weight,
            covariance: covariance(&r.covariance, &e.covariance),
        }),
        (kept, _) => *kept,
    }
}
