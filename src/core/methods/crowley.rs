//! Three aligned readings: Crowley, *World Modeling and Position Estimation for a Mobile Robot Using Ultrasonic
//! Ranging*, ICRA 1989.
//!
//! A reading is the place on the axis of its beam (the centre-line model) with an elliptic uncertainty: the range's
//! own along the beam, the beam's width across. Three consecutive ones that are aligned make a segment, and a
//! segment of the map is updated with them by a Kalman filter.
//!
//! Assumed: consecutive readings are those of one sonar (of Crowley's 24 in a ring neighbours see one wall; of sixteen
//! narrower ones, before a smooth wall, one alone does); aligned are three of which the middle one lies within
//! [`ALIGNED`] of the line through the others; the ellipse's width is the standard deviation of a place anywhere
//! on the arc.
//!
//! It has no points: what echoes from a corner is a piece of a line as well, wherever the robot passes it. Walls are
//! too near where beams meet them at an angle, by up to 2 % of the range.

use nalgebra::{Matrix2, Vector2};

use super::regression::line_through;
use super::rival::{Found, Rival, Scan};
use super::sequences::Sequences;
use crate::core::config::{Config, Map as Bounds};
use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Segment, Shape};
use crate::core::tmam::map::fusion::{fuse_by_information, mahalanobis_distance};

/// How far the middle one of three aligned places lies beside the line through the others at most, metres.
const ALIGNED: f64 = 0.02;
/// How far the outer ones are apart at least, metres.
const APART: f64 = 0.1;

/// The last three readings of each sonar.
#[derive(Debug)]
pub struct Crowley {
    sequences: Sequences,
}

impl Crowley {
    pub fn new(config: &Config) -> Self {
        Self {
            sequences: Sequences::new(3, &config.sequence),
        }
    }
}

/// The place on the axis of the beam.
fn on_axis(arc: &Arc) -> Vec2 {
    arc.point_at(arc.world_from_sensor.yaw)
}

/// The variance of that place along a direction.
fn variance_along(arc: &Arc, direction: Vec2) -> f64 {
    let axis = unit(arc.world_from_sensor.yaw);
    let along = axis.dot(&direction);
    let across = arc.range * arc.beam_width;
    // A place anywhere on the arc: the variance of a uniform distribution.
    along * along * arc.variance + (1.0 - along * along) * across * across / 12.0
}

/// The segment of three places that are aligned.
fn aligned(arcs: &[Arc]) -> Option<Segment> {
    let places: Vec<Vec2> = arcs.iter().map(on_axis).collect();
    let [first, middle, last] = places.as_slice() else {
        return None;
    };
    let baseline = last - first;
    let length = baseline.norm();
    let off = middle - first;
    let beside = (baseline.x * off.y - baseline.y * off.x).abs() / length;
    if !(length >= APART && beside <= ALIGNED) {
        return None;
    }
    let line = line_through(&places)?;
    let normal = unit(line.theta);
    let variances = arcs.iter().map(|arc| variance_along(arc, normal));
    let variance = variances.fold(0.0, |sum, variance| sum + variance) / 3.0;
    let ways = places
        .iter()
        .map(|place| (place - line.mid).dot(&line.along()));
    let spread = ways.fold(0.0, |sum, way| sum + way * way);
    // Errors of neighbouring readings are the beam's, and common to all three: no mean makes them less.
    let covariance = Matrix2::new(variance, 0.0, 0.0, variance / spread);
    let local = Vector2::new(0.0, line.theta);
    Some(
        line.with_line_about(line.mid, local, covariance)
            .canonical(),
    )
}

impl Rival for Crowley {
    fn take(&mut self, scan: &Scan) -> Vec<Found> {
        let sequences = self.sequences.take(scan).into_iter();
        let found = sequences.filter_map(|arcs| {
            let segment = aligned(&arcs)?;
            Some(Found {
                shape: Shape::Line(segment),
                arcs,
            })
        });
        found.collect()
    }

    fn distance(&self, known: &MapFeature, shape: &Shape, bounds: &Bounds) -> Option<f64> {
        let distance = mahalanobis_distance(shape, &known.shape, bounds.max_wall_gap);
        distance.filter(|distance| *distance < bounds.gate)
    }

    fn fused(&self, known: &MapFeature, shape: &Shape, _readings: u32) -> Shape {
        fuse_by_information(&known.shape, shape)
    }
}
