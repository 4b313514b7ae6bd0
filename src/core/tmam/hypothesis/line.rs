//! The line that explains readings best.

use nalgebra::Matrix2;

use super::minimum::{Bearings, least};
use crate::core::geometry::{Vec2, unit, wrap_angle};
use crate::core::ties;
use crate::core::tmam::arc::{Arc, BEAM_SLACK};

/// How far beyond the beams a line is tried that fits best at their edge, radians.
const BEYOND: f64 = 0.01;

/// Steps of Newton's method, at most: from a sample on three or four suffice.
const NEWTON_STEPS: u32 = 8;

/// Newton's method ends at a turn of so many radians: the next one would be the square of that.
const SETTLED: f64 = 1e-8;

/// The line that fits best of those whose normals lie in all beams.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BestLine {
    /// Weighted squares that remain; infinite where the beams have no bearing in common.
    pub chi2: f64,
    /// Whether a line with its normal just beyond the beams fits better still.
    pub is_beside: bool,
}

/// Fits the line. For a given normal n the best offset of the line is the weighted mean of r_i + s_i . n, and what
/// remains is a quadratic form in n.
pub fn best(arcs: &[Arc]) -> BestLine {
    let Some((yaw, low, high)) = common_beam(arcs) else {
        return BestLine {
            chi2: f64::INFINITY,
            is_beside: false,
        };
    };
    let total: f64 = arcs.iter().map(|arc| 1.0 / arc.variance).sum();
    let mut mean_range = 0.0;
    let mut mean_center = Vec2::zeros();
    for arc in arcs {
        let share = 1.0 / (arc.variance * total);
        mean_range += arc.range * share;
        mean_center += arc.center() * share;
    }
    let (mut constant, mut linear, mut quadratic) = (0.0, Vec2::zeros(), Matrix2::zeros());
    for arc in arcs {
        let (r, s) = (arc.range - mean_range, arc.center() - mean_center);
        constant += r * r / arc.variance;
        linear += s * (r / arc.variance);
        quadratic += s * s.transpose() / arc.variance;
    }
    let chi2 = |normal: Vec2| {
        (constant + 2.0 * linear.dot(&normal) + normal.dot(&(quadratic * normal))).max(0.0)
    };
    // Half of slope and curvature over the bearing follow from the same sums; the normal turns without a sine.
    let bottom = |mut normal: Vec2| {
        for _ in 0..NEWTON_STEPS {
            let across = Vec2::new(-normal.y, normal.x);
            let pull = linear + quadratic * normal;
            let curvature = across.dot(&(quadratic * across)) - pull.dot(&normal);
            if curvature <= 0.0 {
                return None;
            }
            let turn = -pull.dot(&across) / curvature;
            normal = (normal + across * turn).normalize();
            if turn.abs() < SETTLED {
                return Some(normal);
            }
        }
        None
    };
    let bearings = Bearings {
        axis: yaw,
        low,
        high,
    };
    let (_, least) = least(&bearings, |all| all.map(chi2), bottom, chi2);
    let beside = [low - BEYOND, high + BEYOND].map(|place| chi2(unit(yaw + place)));
    let beside = beside[0].min(beside[1]);
    BestLine {
        chi2: least,
        is_beside: ties::below(beside, least, ties::of_chi2(beside, least)),
    }
}

/// The bearings that all beams hold, as offsets from the yaw of the first one.
fn common_beam(arcs: &[Arc]) -> Option<(f64, f64, f64)> {
    let yaw = arcs.first()?.world_from_sensor.yaw;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for arc in arcs {
        let axis = wrap_angle(arc.world_from_sensor.yaw - yaw);
        let half = arc.beam_width / 2.0 + BEAM_SLACK;
        (low, high) = (low.max(axis - half), high.min(axis + half));
    }
    // Beams that only just touch have a bearing in common.
    ties::at_most(low, high, ties::ANGLE).then_some((yaw, low.min(high), high.max(low)))
}
