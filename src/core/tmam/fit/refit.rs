//! A known feature fitted anew to readings of any sonars, from where it is.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{RowVector2, Vector2};

use super::{Observation, iterate, weighted_square_sum};
use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Point, Segment, Shape};

use super::point::PointRanges;

/// A feature after it was fitted anew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refit {
    /// Where it is now; a line reaches from the first to the last place that a reading came from.
    pub shape: Shape,
    /// Squared residuals, each divided by its variance.
    pub chi2: f64,
}

/// Fits a feature to readings, starting from where it is; `None` where they do not determine it.
pub fn refit(shape: &Shape, arcs: &[Arc]) -> Option<Refit> {
    match shape {
        Shape::Line(segment) => refit_line(segment, arcs),
        Shape::Point(point) => refit_point(point, arcs),
    }
}

/// Lines over (distance along the normal, theta) seen from a place on them, so that the two are
/// nearly independent. Readings may come from either side.
struct LineRanges {
    origin: Vec2,
    normal: Vec2,
}

impl Observation for LineRanges {
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        let sensor = arc.center() - self.origin;
        let normal = unit(parameters.y);
        let away = parameters.x - sensor.dot(&normal);
        // The side that the sensor is on is that of the line as it was, (17) and (18).
        let side = if self.normal.dot(&sensor) > 0.0 {
            -1.0
        } else {
            1.0
        };
        let by_theta = normal.y * sensor.x - normal.x * sensor.y;
        Some((side * away, RowVector2::new(side, side * by_theta)))
    }

    fn step_norm(step: Vector2<f64>) -> f64 {
        Vector2::new(100.0 * step.x, step.y).norm()
    }
}

fn refit_line(segment: &Segment, arcs: &[Arc]) -> Option<Refit> {
    let model = LineRanges {
        origin: segment.mid,
        normal: unit(segment.theta),
    };
    let start = Vector2::new(segment.about(segment.mid).0.x, segment.theta);
    let estimate = iterate(&model, arcs, start, true).ok()?;
    let along = unit(estimate.parameters.y + FRAC_PI_2);
    let (low, high) = arcs
        .iter()
        .map(|arc| arc.center().dot(&along))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), way| {
            (low.min(way), high.max(way))
        });
    let line = segment.with_line_about(segment.mid, estimate.parameters, estimate.covariance);
    let shape = Shape::Line(Segment {
        mid: unit(line.theta) * line.rho + along * ((low + high) / 2.0),
        half_length: (high - low) / 2.0,
        ..line
    });
    let chi2 = weighted_square_sum(&model, estimate.parameters, arcs);
    Some(Refit { shape, chi2 })
}

fn refit_point(point: &Point, arcs: &[Arc]) -> Option<Refit> {
    let estimate = iterate(&PointRanges, arcs, point.position, true).ok()?;
    let shape = Shape::Point(Point {
        position: estimate.parameters,
        covariance: estimate.covariance,
    });
    let chi2 = weighted_square_sum(&PointRanges, estimate.parameters, arcs);
    Some(Refit { shape, chi2 })
}
