//! Outlines of what a feature's covariance leaves open, at true scale.

use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::feature::{Point, Segment};

/// How many standard deviations the outlines of uncertainty lie out.
const SIGMAS: f64 = 3.0;

fn tangent(segment: &Segment) -> Vec2 {
    let normal = unit(segment.theta);
    Vec2::new(-normal.y, normal.x)
}

/// Where the line may run: [`SIGMAS`] of its distance to either side, all along the segment.
///
/// A point of the line at `s` from the foot of the origin's perpendicular moves by
/// `d rho - s d theta` along the normal.
pub fn band(segment: &Segment) -> Vec<Vec2> {
    const STEPS: u32 = 4;
    let (normal, tangent) = (unit(segment.theta), tangent(segment));
    let (rr, rt, tt) = (
        segment.covariance.m11,
        segment.covariance.m12,
        segment.covariance.m22,
    );
    let offset = |at: Vec2| {
        let s = at.dot(&tangent);
        SIGMAS * (rr - 2.0 * s * rt + s * s * tt).max(0.0).sqrt()
    };
    let stations: Vec<Vec2> = (0..=STEPS)
        .map(|i| f64::from(i) / f64::from(STEPS) * 2.0 - 1.0)
        .map(|t| segment.mid + tangent * (t * segment.half_length))
        .collect();
    let near = stations.iter().map(|at| at + normal * offset(*at));
    let far = stations.iter().rev().map(|at| at - normal * offset(*at));
    let mut outline: Vec<Vec2> = near.chain(far).collect();
    outline.extend(outline.first().copied());
    outline
}

/// The ellipse at [`SIGMAS`] around a point, closed.
pub fn ellipse(point: &Point) -> Vec<Vec2> {
    const STEPS: u32 = 24;
    let (a, b, d) = (
        point.covariance.m11,
        point.covariance.m12,
        point.covariance.m22,
    );
    // The lower triangular root of the covariance takes the unit circle to the ellipse.
    let l11 = a.max(0.0).sqrt();
    let l21 = if l11 > 0.0 { b / l11 } else { 0.0 };
    let l22 = (d - l21 * l21).max(0.0).sqrt();
    (0..=STEPS)
        .map(|i| std::f64::consts::TAU * f64::from(i % STEPS) / f64::from(STEPS))
        .map(unit)
        .map(|c| point.position + Vec2::new(l11 * c.x, l21 * c.x + l22 * c.y) * SIGMAS)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix2;

    #[test]
    fn the_ellipse_lies_three_sigmas_out_in_every_direction() {
        let covariance = Matrix2::new(0.04, 0.01, 0.01, 0.02);
        let point = Point {
            position: Vec2::new(1.0, -2.0),
            covariance,
        };
        let inverse = covariance.try_inverse().unwrap();
        let outline = ellipse(&point);
        for corner in &outline {
            let off = corner - point.position;
            let mahalanobis = off.dot(&(inverse * off));
            assert!((mahalanobis - SIGMAS * SIGMAS).abs() < 1e-9);
        }
        assert_eq!(outline.first(), outline.last());
    }

    #[test]
    fn the_band_of_a_sure_line_is_the_line() {
        let segment = Segment {
            rho: 2.0,
            theta: std::f64::consts::FRAC_PI_2,
            covariance: Matrix2::zeros(),
            mid: Vec2::new(3.0, 2.0),
            half_length: 1.5,
        };
        for at in band(&segment) {
            assert!((at.y - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn an_uncertain_angle_opens_the_band_away_from_the_foot() {
        let mut covariance = Matrix2::zeros();
        covariance.m22 = 0.01;
        let segment = Segment {
            rho: 2.0,
            theta: 0.0,
            covariance,
            mid: Vec2::new(2.0, 5.0),
            half_length: 1.0,
        };
        let widest = band(&segment).iter().map(|at| at.x).fold(0.0, f64::max);
        assert!((widest - (2.0 + 3.0 * 0.1 * 6.0)).abs() < 1e-9);
    }
}
