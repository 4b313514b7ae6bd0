//! Circles: convex cylinders, such as pillars and legs of tables, whose nearest place echoes.
//!
//! A sensor at `s` outside a circle of radius `r` about `c` measures `|c - s| - r`, at the bearing of the centre.
//! A point is the circle whose radius is 0, a wall the one whose radius has no end. The centre's distance and the
//! radius can be told apart only by how the range curves while the bearing sweeps: three readings always fit.

use std::ops::RangeInclusive;

use nalgebra::{Matrix3, RowVector3, Vector3};

use super::arc::Arc;
use crate::core::geometry::{Vec2, direction, unit};

/// Radii that a cylinder can have, metres: thinner ones are points, thicker ones are seen as walls.
pub const RADII: RangeInclusive<f64> = 0.03..=1.0;

/// Readings that tell a circle from a point and from a wall, at least: two degrees of freedom.
pub const FEWEST: usize = 5;

/// Bearings over half the width of the beam, and radii, from which a fit may start; the best of them does.
const BEARINGS: i32 = 4;
const STARTS: [f64; 3] = [0.05, 0.2, 0.6];

/// Steps after which a fit ends in any case.
const STEPS: u32 = 60;
/// A gain in chi2 below this, relative, is the end.
const GAIN: f64 = 1e-12;
/// Damping (Levenberg and Marquardt) at first, and the most.
const DAMPING: (f64, f64) = (1e-3, 1e9);
/// A radius beyond this has run away, metres.
const FAR: f64 = 50.0;

/// A circle over (x, y, radius), metres.
pub type Parameters = Vector3<f64>;

/// A circle that fits readings best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleFit {
    pub parameters: Parameters,
    /// Weighted squares that remain.
    pub chi2: f64,
    /// Steps that were made.
    pub iterations: u32,
}

/// The range to a circle and its derivative by (x, y, radius); `None` where the sensor stands in its centre.
pub fn circle_range(circle: &Parameters, sensor: Vec2) -> Option<(f64, RowVector3<f64>)> {
    let from_sensor = circle.xy() - sensor;
    let distance = from_sensor.norm();
    let ray = from_sensor / distance;
    let by = RowVector3::new(ray.x, ray.y, -1.0);
    (distance > 0.0).then(|| (distance - circle.z, by))
}

/// Sum over the arcs of squared residuals, each divided by its variance; infinite in the centre.
pub fn chi2(circle: &Parameters, arcs: &[Arc]) -> f64 {
    let misfit = |arc: &Arc| {
        let predicted = circle_range(circle, arc.center());
        predicted.map_or(f64::INFINITY, |(range, _)| {
            (arc.range - range) * (arc.range - range) / arc.variance
        })
    };
    arcs.iter().map(misfit).sum()
}

/// The mean square error (12); `None` where the readings do not determine it.
pub fn covariance(circle: &Parameters, arcs: &[Arc]) -> Option<Matrix3<f64>> {
    let (information, _) = normal_equations(circle, arcs)?;
    let covariance = information.try_inverse()?;
    let is_one = covariance
        .diagonal()
        .iter()
        .all(|v| *v > 0.0 && v.is_finite());
    is_one.then(|| (covariance + covariance.transpose()) / 2.0)
}

/// Whether all beams hold the centre, with `slack` radians on either side, and no sensor is inside.
pub fn is_held(circle: &Parameters, arcs: &[Arc], slack: f64) -> bool {
    arcs.iter().all(|arc| {
        let towards = circle.xy() - arc.center();
        towards.norm() > circle.z && arc.beam_nearly_holds(direction(towards), slack)
    })
}

impl CircleFit {
    /// The circle that fits best, whatever its radius; `None` where none does better than any other.
    pub fn best(arcs: &[Arc]) -> Option<Self> {
        let middle = arcs.get(arcs.len() / 2)?;
        let half = middle.beam_width / 2.0;
        let bearings = (-BEARINGS..=BEARINGS).map(|k| f64::from(k) / f64::from(BEARINGS) * half);
        let starts = bearings.flat_map(|off| {
            let along = unit(middle.world_from_sensor.yaw + off);
            STARTS.map(|radius| {
                let center = middle.center() + along * (middle.range + radius);
                Vector3::new(center.x, center.y, radius)
            })
        });
        let starts = starts.map(|start| (chi2(&start, arcs), start));
        let (_, start) = starts.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
        Self::from(start, arcs)
    }

    /// The one that is reached from a start: (10), damped.
    pub fn from(start: Parameters, arcs: &[Arc]) -> Option<Self> {
        let (mut damping, most) = DAMPING;
        let mut fit = Self {
            parameters: start,
            chi2: chi2(&start, arcs),
            iterations: 0,
        };
        while fit.iterations < STEPS && damping < most {
            let (information, gradient) = normal_equations(&fit.parameters, arcs)?;
            let damped = information + Matrix3::from_diagonal(&(information.diagonal() * damping));
            let next = fit.parameters + damped.try_inverse()? * gradient; // (10)
            fit.iterations += 1;
            let cost = chi2(&next, arcs);
            // NaN is no gain.
            if cost < fit.chi2 {
                let gain = fit.chi2 - cost;
                (fit.parameters, fit.chi2) = (next, cost);
                damping /= 10.0;
                if gain < GAIN * (1.0 + cost) {
                    break;
                }
            } else {
                damping *= 10.0;
            }
        }
        let is_near = fit.parameters.z.abs() < FAR && fit.chi2.is_finite();
        is_near.then_some(fit)
    }

    /// Whether it is a cylinder: of a radius that these have.
    pub fn is_cylinder(&self) -> bool {
        RADII.contains(&self.parameters.z)
    }
}

/// `J^T R^-1 J` and `J^T R^-1 (r - h)`.
fn normal_equations(circle: &Parameters, arcs: &[Arc]) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    let (mut information, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
    for arc in arcs {
        let (range, by) = circle_range(circle, arc.center())?;
        information += by.transpose() * by / arc.variance;
        gradient += by.transpose() * ((arc.range - range) / arc.variance);
    }
    Some((information, gradient))
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use crate::core::tmam::fit::testing::arc;

    /// Arcs of a sensor that drives along x in steps of `step` from `-reach` to `reach` and looks at a circle
    /// `range` ahead of the middle of its way, in a beam that holds it all the while.
    pub fn passing(range: f64, radius: f64, reach: f64, step: f64) -> Vec<Arc> {
        let center = Vec2::new(0.0, range + radius);
        let count = (2.0 * reach / step) as u32;
        let at = |k: u32| Vec2::new(-reach + step * f64::from(k), 0.0);
        let one = |k: u32| {
            let mut arc = arc(
                k,
                at(k),
                std::f64::consts::FRAC_PI_2,
                (center - at(k)).norm() - radius,
            );
            arc.beam_width = 3.0;
            arc
        };
        (0..=count).map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::testing::passing;
    use super::*;
    use crate::core::tmam::hypothesis::{Gate, HypothesisTest};

    proptest! {
        #[test]
        fn a_fit_recovers_circles_without_noise(
            range in 0.4..3.0f64, radius in 0.05..0.9f64, share in 0.4..1.2f64, turn in -3.0..3.0f64
        ) {
            // Over a sweep of 45 to 100 deg.
            let reach = share * (range + radius);
            let (mut arcs, spin) = (passing(range, radius, reach, reach / 10.0), unit(turn));
            for arc in &mut arcs {
                let (x, y) = (arc.world_from_sensor.x, arc.world_from_sensor.y);
                arc.world_from_sensor.x = spin.x * x - spin.y * y + 3.0;
                arc.world_from_sensor.y = spin.y * x + spin.x * y - 2.0;
                arc.world_from_sensor.yaw += turn;
            }
            let fit = CircleFit::best(&arcs).unwrap();
            let center = Vec2::new(-spin.y, spin.x) * (range + radius) + Vec2::new(3.0, -2.0);
            prop_assert!((fit.parameters.xy() - center).norm() < 1e-5, "{fit:?}");
            prop_assert!((fit.parameters.z - radius).abs() < 1e-5, "{fit:?} {radius}");
            prop_assert!(fit.is_cylinder() && is_held(&fit.parameters, &arcs, 0.0));
        }

        #[test]
        fn derivatives_equal_differences(x in -2.0..2.0f64, y in 0.5..3.0f64, r in 0.0..1.0f64) {
            let (circle, h) = (Vector3::new(x, y, r), 1e-6);
            let sensor = Vec2::new(0.1, -0.3);
            let (_, by) = circle_range(&circle, sensor).unwrap();
            for axis in 0..3 {
                let step = Vector3::ith(axis, h);
                let range = |circle: Parameters| circle_range(&circle, sensor).unwrap().0;
                let slope = (range(circle + step) - range(circle - step)) / (2.0 * h);
                prop_assert!((slope - by[axis]).abs() < 1e-6);
            }
        }

        #[test]
        fn without_a_radius_it_is_the_point(x in -2.0..2.0f64, y in 0.5..3.0f64) {
            use crate::core::tmam::residual::point_range;
            let (sensor, point) = (Vec2::new(0.1, -0.3), Vec2::new(x, y));
            let (range, by) = circle_range(&Vector3::new(x, y, 0.0), sensor).unwrap();
            let (to_point, by_point) = point_range(point, sensor).unwrap();
            prop_assert!((range - to_point).abs() < 1e-12);
            prop_assert!((by.fixed_columns::<2>(0) - by_point).norm() < 1e-12);
        }
    }

    #[test]
    fn readings_of_a_point_are_no_cylinder() {
        let arcs = passing(1.0, 0.0, 0.6, 0.05);
        let fit = CircleFit::best(&arcs).unwrap();
        assert!(
            fit.parameters.z.abs() < 1e-4 && !fit.is_cylinder(),
            "{fit:?}"
        );
        let test = HypothesisTest::of(&arcs, &Gate::new(6.63));
        assert!(test.chi2_point < 1e-3);
    }

    #[test]
    fn a_short_way_leaves_the_radius_open() {
        let [short, long] = [0.2, 0.8].map(|reach| {
            let arcs = passing(1.0, 0.2, reach, reach / 10.0);
            let covariance = covariance(&Vector3::new(0.0, 1.2, 0.2), &arcs).unwrap();
            covariance.m33.sqrt()
        });
        assert!(short > 0.1 && long < 0.02, "{short} {long}");
        assert!(
            covariance(
                &Vector3::new(0.0, 1.2, 0.2),
                &passing(1.0, 0.2, 0.01, 0.01)[..2]
            )
            .is_none()
        );
    }
}
