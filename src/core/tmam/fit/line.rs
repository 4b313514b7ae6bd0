//! The line: observation model (6), (16) to (21), fitted in the frame of its first sensor.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix2, RowVector2, Vector2};

use super::consistency::estimate;
use super::start::Start;
use super::{Estimate, Fit, FitOptions, Model, Observation};
use crate::core::geometry::{Pose2, Vec2, direction, unit, wrap_angle};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Rejection, Segment, Shape};
use crate::core::tmam::pair::Points;

/// Lines over (p_r, p_theta) in a local frame: origin at the first sensor, y along its bearing.
struct LocalLine {
    world_from_local: Pose2,
    first: Arc,
}

impl LocalLine {
    fn new(first: Arc) -> Self {
        let sensor = first.world_from_sensor;
        Self {
            world_from_local: Pose2::new(sensor.x, sensor.y, sensor.yaw - FRAC_PI_2), // (16)
            first,
        }
    }
}

impl Observation for LocalLine {
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        let sensor = self.world_from_local.inverse_transform(arc.center());
        let normal = unit(parameters.y);
        let range = parameters.x - sensor.dot(&normal); // (19)
        let by_theta = normal.y * sensor.x - normal.x * sensor.y; // (21)
        Some((range, RowVector2::new(1.0, by_theta))) // (20)
    }

    fn step_norm(step: Vector2<f64>) -> f64 {
        Vector2::new(100.0 * step.x, step.y).norm()
    }
}

impl Model for LocalLine {
    fn starts(&self, points: &Points) -> [Option<Start>; 2] {
        points.contact.map(|side| {
            side.map(|p| {
                let theta = p.bearing_a - self.world_from_local.yaw;
                let touch = self.world_from_local.inverse_transform(p.on_a);
                let rho = touch.dot(&unit(theta));
                Start::at(Vector2::new(rho, theta), &p, &self.first)
            })
        })
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
}

/// Fits a line to the arcs of a run.
///
/// The estimate and its covariance (23) are in the world; the ends are the extreme tangent points.
pub fn fit_line(arcs: &[Arc], demands: &FitOptions) -> Fit {
    let Some(first) = arcs.first() else {
        return Fit::failed(Rejection::NoStart, 0);
    };
    let model = LocalLine::new(*first);
    match estimate(&model, arcs, demands) {
        Ok(estimate) => {
            let segment = to_world(&model.world_from_local, &estimate, arcs);
            estimate.fit(Shape::Line(segment))
        }
        Err(failed) => failed,
    }
}

/// The local line with its mean square error, transformed to the world, and its ends.
fn to_world(world_from_local: &Pose2, estimate: &Estimate, arcs: &[Arc]) -> Segment {
    let (rho, theta) = (estimate.parameters.x, estimate.parameters.y);
    let normal = unit(theta + world_from_local.yaw);
    let along = Vec2::new(-normal.y, normal.x);
    let origin = world_from_local.position();
    let world_rho = rho + origin.dot(&normal);
    // Turning the line about the local origin moves its foot in the world.
    let world_from_local_parameters = Matrix2::new(1.0, origin.dot(&along), 0.0, 1.0);
    let (low, high) = arcs
        .iter()
        .filter(|arc| !estimate.outliers.contains(&arc.id))
        .map(|arc| arc.center().dot(&along))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), way| {
            (low.min(way), high.max(way))
        });
    Segment {
        rho: world_rho,
        theta: theta + world_from_local.yaw,
        covariance: world_from_local_parameters
            * estimate.covariance
            * world_from_local_parameters.transpose(),
        mid: normal * world_rho + along * ((low + high) / 2.0),
        half_length: (high - low) / 2.0,
    }
    .canonical()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Gauss, SIGMA, arc};
    use super::*;
    use crate::core::geometry::angle_between;
    use proptest::prelude::*;

    fn wall_arcs(start: Vec2, travel: f64, normal: f64, rho: f64, noise: &[f64]) -> Vec<Arc> {
        noise
            .iter()
            .zip(0..)
            .map(|(e, frame)| {
                let s = start + unit(travel) * (0.12 * f64::from(frame));
                arc(frame, s, normal + 0.05, rho - unit(normal).dot(&s) + e)
            })
            .collect()
    }

    fn segment(fit: Fit) -> Segment {
        match fit.shape {
            Some(Shape::Line(segment)) => segment,
            other => panic!("no line: {other:?} {:?}", fit.rejection),
        }
    }

    proptest! {
        #[test]
        fn jacobian_20_21_equals_differences(x in -1.0..1.0, y in -1.0..1.0, yaw in -3.0..3.0, rho in 0.5..4.0, theta in 0.8..2.3) {
            let model = LocalLine::new(arc(0, Vec2::new(0.3, -0.2), 0.7, 1.0));
            let seen = arc(1, Vec2::new(x, y), yaw, 1.0);
            let at = |p: Vector2<f64>| model.predict(p, &seen).unwrap();
            let p = Vector2::new(rho, theta);
            let h = 1e-6;
            for (i, step) in [Vector2::new(h, 0.0), Vector2::new(0.0, h)].into_iter().enumerate() {
                let difference = (at(p + step).0 - at(p - step).0) / (2.0 * h);
                prop_assert!((difference - at(p).1[i]).abs() < 1e-8);
            }
        }

        #[test]
        fn exact_readings_give_the_wall_back(x in -2.0..2.0, y in -2.0..2.0, travel in -3.0..3.0, off in 0.6..2.5, ahead in 0.5..4.0) {
            let (start, normal) = (Vec2::new(x, y), travel + off);
            let rho = unit(normal).dot(&start) + ahead + 0.5;
            let arcs = wall_arcs(start, travel, normal, rho, &[0.0; 6]);
            let fit = fit_line(&arcs, &FitOptions::default());
            prop_assert_eq!(fit.rejection, None);
            prop_assert!(fit.converged);
            let found = segment(fit);
            let truth = Segment { rho, theta: normal, ..found }.canonical();
            prop_assert!((found.rho - truth.rho).abs() < 1e-6);
            prop_assert!(angle_between(found.theta, truth.theta) < 1e-6);
            // The ends are the feet of the first and the last sensor on the wall.
            let foot = |a: &Arc| a.center() + unit(normal) * a.range;
            let [one, two] = found.ends();
            let (first, last) = (foot(&arcs[0]), foot(&arcs[5]));
            let apart = ((one - first).norm() + (two - last).norm()).min((one - last).norm() + (two - first).norm());
            prop_assert!(apart < 1e-5, "{apart}");
        }
    }

    /// (12), transformed to the world, against the spread of many noisy fits.
    #[test]
    fn covariance_12_is_the_spread_of_the_estimates() {
        let (start, travel, normal, rho) = (Vec2::new(1.5, -2.0), 0.4, 1.9, 3.0);
        let mut rng = Gauss::new(7);
        let n = 4000;
        let estimates: Vec<Segment> = (0..n)
            .map(|_| {
                let noise: Vec<f64> = (0..8).map(|_| SIGMA * rng.sample()).collect();
                segment(fit_line(
                    &wall_arcs(start, travel, normal, rho, &noise),
                    &FitOptions::default(),
                ))
            })
            .collect();
        let predicted = segment(fit_line(
            &wall_arcs(start, travel, normal, rho, &[0.0; 8]),
            &FitOptions::default(),
        ))
        .covariance;
        let spread = estimates.iter().fold(Matrix2::zeros(), |sum, s| {
            let e = Vector2::new(s.rho - rho, s.theta - normal);
            sum + e * e.transpose() / f64::from(n)
        });
        for i in 0..2 {
            let ratio = spread[(i, i)] / predicted[(i, i)];
            assert!((0.9..1.1).contains(&ratio), "variance {i}: {ratio}");
        }
        let ratio = spread[(0, 1)] / predicted[(0, 1)];
        assert!((0.85..1.15).contains(&ratio), "covariance: {ratio}");
    }

    #[test]
    fn seen_straight_ahead_left_comes_before_right() {
        // Both tangents of an end-on wall fit equally well and lie equally far from the axis, but
        // for the last bit. The travel and the noise are chosen so that rounding would say right.
        for travel in [0.0, 0.3, 1.1, 2.7, -0.4, -1.9] {
            let arcs = [0, 1, 2, 3].map(|k| {
                let way = 0.12 * f64::from(k);
                arc(k, unit(travel) * way, travel, 3.0 - 0.995 * way)
            });
            let Some(Shape::Line(found)) = fit_line(&arcs, &FitOptions::default()).shape else {
                panic!("no line");
            };
            let normal = if found.rho > 0.0 {
                found.theta
            } else {
                found.theta + 3.2
            };
            assert!(
                crate::core::geometry::wrap_angle(normal - travel) > 0.0,
                "{travel}"
            );
        }
    }

    #[test]
    fn the_stopping_rule_adds_centimetres_to_radians() {
        let norm = |rho, theta| LocalLine::step_norm(Vector2::new(rho, theta));
        assert!(norm(0.009, 0.4) < 1.0, "9 mm and 23 deg are small enough");
        assert!(norm(0.011, 0.0) > 1.0, "11 mm are not");
        // So a fit from a start that is a few millimetres off ends after one step.
        let arcs = wall_arcs(Vec2::zeros(), 0.0, 1.57, 2.0, &[1e-3, -1e-3, 1e-3, 0.0]);
        assert_eq!(fit_line(&arcs, &FitOptions::default()).iterations, 1);
    }

    #[test]
    fn a_line_outside_the_beams_is_rejected() {
        let mut arcs = wall_arcs(Vec2::zeros(), 0.0, 1.57, 2.0, &[0.0; 4]);
        for a in arcs.iter_mut().skip(2) {
            a.world_from_sensor.yaw += 0.4;
        }
        assert_eq!(
            fit_line(&arcs, &FitOptions::default()).rejection,
            Some(Rejection::OutsideBeams)
        );
    }

    #[test]
    fn without_a_common_tangent_there_is_nothing_to_start_from() {
        let arcs = [
            arc(0, Vec2::new(0.0, 0.0), 1.57, 1.0),
            arc(1, Vec2::new(0.1, 0.0), 1.57, 2.0),
        ];
        assert_eq!(
            fit_line(&arcs, &FitOptions::default()).rejection,
            Some(Rejection::NoStart)
        );
        assert_eq!(
            fit_line(&[], &FitOptions::default()).rejection,
            Some(Rejection::NoStart)
        );
    }

    #[test]
    fn a_base_line_of_no_length_is_singular() {
        let arcs = [0.0, 2e-6].map(|x| arc(0, Vec2::new(x, 0.0), 1.57, 1.0));
        assert_eq!(
            fit_line(&arcs, &FitOptions::default()).rejection,
            Some(Rejection::Singular)
        );
    }
}
