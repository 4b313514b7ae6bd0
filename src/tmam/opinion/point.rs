//! The point that explains readings best.

use std::cell::Cell;

use nalgebra::Matrix2;

use super::minimum::least;
use crate::geometry::{Vec2, unit};
use crate::tmam::arc::{Arc, BEAM_SLACK};

/// Newton steps along a bearing; the range is known well from the start.
const STEPS: u32 = 3;

/// Ranges below this weigh as if they were so long, metres.
const SHORTEST: f64 = 1e-3;

/// The least chi2 of a point that lies in all beams; infinite where there is none.
pub fn least_chi2(arcs: &[Arc]) -> f64 {
    let Some(middle) = arcs.get(arcs.len() / 2) else {
        return f64::INFINITY;
    };
    let moments = Moments::about(middle.center(), arcs);
    let edges: Vec<(Vec2, f64)> = arcs
        .iter()
        .map(|arc| {
            let half = arc.beam_width / 2.0 + BEAM_SLACK;
            (unit(arc.world_from_sensor.yaw), libm::cos(half))
        })
        .collect();
    let point_at = |offset: f64| {
        let along = unit(middle.world_from_sensor.yaw + offset);
        let (way, chi2) = moments.best_on_ray(along, middle.range);
        (middle.center() + along * way, chi2)
    };
    let least_held = Cell::new(f64::INFINITY);
    let chi2 = |offset: f64| {
        let (point, chi2) = point_at(offset);
        // What is no less than a point that the beams hold need not be looked for in them.
        if chi2 >= least_held.get() {
            return chi2;
        }
        let held = arcs.iter().zip(&edges).all(|(arc, (axis, cosine))| {
            let towards = point - arc.center();
            axis.dot(&towards) >= cosine * towards.norm()
        });
        if !held {
            return f64::INFINITY;
        }
        least_held.set(chi2);
        chi2
    };
    let half = middle.beam_width / 2.0;
    let (offset, value) = least(-half, half, chi2);
    if value.is_infinite() {
        return f64::INFINITY;
    }
    let (point, _) = point_at(offset);
    arcs.iter()
        .map(|arc| {
            let residual = (point - arc.center()).norm() - arc.range;
            residual * residual / arc.variance
        })
        .sum()
}

/// Sums over the readings from which chi2 of any point follows at once.
///
/// With `delta_i` the sensor's place from the origin and `a_i = r_i^2 - |delta_i|^2`, a point at the
/// way `rho` along `u` leaves `(a_i - rho^2 + 2 rho u . delta_i) / 2 r_i` of a reading: the residual,
/// but for a factor that is 1 where the two ranges agree.
struct Moments {
    weight: f64,
    a: f64,
    aa: f64,
    delta: Vec2,
    a_delta: Vec2,
    delta_delta: Matrix2<f64>,
}

impl Moments {
    fn about(origin: Vec2, arcs: &[Arc]) -> Self {
        let mut sums = Self {
            weight: 0.0,
            a: 0.0,
            aa: 0.0,
            delta: Vec2::zeros(),
            a_delta: Vec2::zeros(),
            delta_delta: Matrix2::zeros(),
        };
        for arc in arcs {
            let delta = arc.center() - origin;
            let twice = 2.0 * arc.range.max(SHORTEST);
            let weight = 1.0 / (twice * twice * arc.variance);
            let a = arc.range * arc.range - delta.norm_squared();
            sums.weight += weight;
            sums.a += weight * a;
            sums.aa += weight * a * a;
            sums.delta += delta * weight;
            sums.a_delta += delta * (weight * a);
            sums.delta_delta += delta * delta.transpose() * weight;
        }
        sums
    }

    /// The best way along a ray from the origin, metres, and what chi2 is there.
    fn best_on_ray(&self, along: Vec2, start: f64) -> (f64, f64) {
        let (w, a) = (self.weight, self.a);
        let d = along.dot(&self.delta);
        let ad = along.dot(&self.a_delta);
        let dd = along.dot(&(self.delta_delta * along));
        let mut way = start;
        for _ in 0..STEPS {
            let slope = 4.0 * (((w * way - 3.0 * d) * way + 2.0 * dd - a) * way + ad);
            let curvature = 4.0 * (3.0 * w * way * way - 6.0 * d * way + 2.0 * dd - a);
            if curvature <= 0.0 {
                break;
            }
            way = (way - slope / curvature).max(0.0);
        }
        let square = way * way;
        let chi2 = self.aa + square * (w * square + 4.0 * dd - 2.0 * a) + 4.0 * way * ad
            - 4.0 * square * way * d;
        (way, chi2.max(0.0))
    }
}
