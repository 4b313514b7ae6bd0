//! The point: observation model (7), fitted in Cartesian coordinates.
//!
//! The paper fits (rho, alpha), which are singular where a point lies near the world's origin, as
//! point 1 of its Table I does.

use nalgebra::{RowVector2, Vector2};

use super::consistency::estimate;
use super::start::Start;
use super::{Estimate, Fit, FitOptions, Model, Observation};
use crate::core::geometry::direction;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Point, Rejection, Shape};
use crate::core::tmam::pair::Points;

/// Points over (x, y) in the world.
pub(super) struct PointRanges;

/// The same for the readings of a run.
struct CartesianPoint {
    first: Arc,
}

impl Observation for PointRanges {
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        let from_sensor = parameters - arc.center();
        let range = from_sensor.norm(); // (7)
        (range > 0.0).then(|| (range, from_sensor.transpose() / range)) // (14), (15) by x and y
    }

    fn step_norm(step: Vector2<f64>) -> f64 {
        100.0 * step.norm()
    }
}

impl Observation for CartesianPoint {
    fn predict(&self, parameters: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        PointRanges.predict(parameters, arc)
    }

    fn step_norm(step: Vector2<f64>) -> f64 {
        PointRanges::step_norm(step)
    }
}

impl Model for CartesianPoint {
    fn starts(&self, points: &Points) -> [Option<Start>; 2] {
        points
            .intersection
            .map(|side| side.map(|p| Start::at(p.on_a, &p, &self.first)))
    }

    fn mirrored(&self, parameters: Vector2<f64>, first: &Arc, last: &Arc) -> Vector2<f64> {
        let path = last.center() - first.center();
        let along = path / path.norm().max(f64::MIN_POSITIVE);
        let from_path = parameters - first.center();
        first.center() + along * (2.0 * along.dot(&from_path)) - from_path
    }

    fn in_beam(&self, parameters: Vector2<f64>, arc: &Arc, slack: f64) -> bool {
        arc.beam_nearly_holds(direction(parameters - arc.center()), slack)
    }

    fn bearing_variance(&self, estimate: &Estimate, first: &Arc) -> f64 {
        let away = estimate.parameters - first.center();
        let across = Vector2::new(-away.y, away.x) / away.norm_squared().max(f64::MIN_POSITIVE);
        across.dot(&(estimate.covariance * across))
    }
}

/// Fits a point to the arcs of a run; estimate and covariance in the world.
pub fn fit_point(arcs: &[Arc], demands: &FitOptions) -> Fit {
    let Some(first) = arcs.first() else {
        return Fit::failed(Rejection::NoStart, 0);
    };
    match estimate(&CartesianPoint { first: *first }, arcs, demands) {
        Ok(estimate) => {
            let point = Point {
                position: estimate.parameters,
                covariance: estimate.covariance,
            };
            estimate.fit(Shape::Point(point))
        }
        Err(failed) => failed,
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Gauss;
    use super::super::testing::{SIGMA, arc};
    use super::*;
    use crate::core::geometry::{Vec2, unit};
    use nalgebra::Matrix2;
    use proptest::prelude::*;

    /// Derivatives of the range (7) by the polar coordinates (rho, alpha) of the point, as the paper
    /// has them.
    fn polar_jacobian(rho: f64, alpha: f64, sensor: Vector2<f64>) -> RowVector2<f64> {
        let (sin, cos) = libm::sincos(alpha);
        let range = (Vector2::new(rho * cos, rho * sin) - sensor).norm();
        RowVector2::new(
            (rho - sensor.x * cos - sensor.y * sin) / range, // (14)
            rho * (sensor.x * sin - sensor.y * cos) / range, // (15)
        )
    }

    fn corner_arcs(start: Vec2, travel: f64, corner: Vec2, noise: &[f64]) -> Vec<Arc> {
        let axis = direction(corner - start - unit(travel) * 0.2);
        noise
            .iter()
            .zip(0..)
            .map(|(e, frame)| {
                let s = start + unit(travel) * (0.1 * f64::from(frame));
                arc(frame, s, axis, (corner - s).norm() + e)
            })
            .collect()
    }

    fn point(fit: Fit) -> Point {
        match fit.shape {
            Some(Shape::Point(point)) => point,
            other => panic!("no point: {other:?} {:?}", fit.rejection),
        }
    }

    proptest! {
        #[test]
        fn jacobian_14_15_equals_differences_and_ours_by_the_chain_rule(rho in 0.5..6.0f64, alpha in -3.0..3.0, x in -3.0..3.0, y in -3.0..3.0) {
            let s = Vec2::new(x, y);
            prop_assume!((unit(alpha) * rho - s).norm() > 0.1);
            let range = |rho: f64, alpha: f64| (unit(alpha) * rho - s).norm();
            let paper = polar_jacobian(rho, alpha, s);
            let h = 1e-6;
            let by_rho = (range(rho + h, alpha) - range(rho - h, alpha)) / (2.0 * h);
            let by_alpha = (range(rho, alpha + h) - range(rho, alpha - h)) / (2.0 * h);
            prop_assert!((by_rho - paper.x).abs() < 1e-7 && (by_alpha - paper.y).abs() < 1e-6);

            let seen = arc(0, s, 0.0, 1.0);
            let (_, ours) = CartesianPoint { first: seen }.predict(unit(alpha) * rho, &seen).unwrap();
            let n = unit(alpha);
            let xy_from_polar = Matrix2::new(n.x, -n.y * rho, n.y, n.x * rho);
            prop_assert!((ours * xy_from_polar - paper).norm() < 1e-9);
        }

        #[test]
        fn exact_readings_give_the_corner_back(x in -2.0..2.0, y in -2.0..2.0, travel in -3.0..3.0, off in 0.7..2.4, range in 1.5..4.0f64) {
            let start = Vec2::new(x, y);
            let corner = start + unit(travel + off) * range;
            let fit = fit_point(&corner_arcs(start, travel, corner, &[0.0; 5]), &FitOptions::default());
            prop_assert_eq!(fit.rejection, None);
            prop_assert!((point(fit).position - corner).norm() < 1e-6);
        }
    }

    #[test]
    fn covariance_12_is_the_spread_of_the_estimates() {
        let (start, travel, corner) = (Vec2::new(1.0, 1.0), 0.3, Vec2::new(2.0, 3.0));
        let mut rng = Gauss::new(11);
        let n = 4000;
        let spread = (0..n).fold(Matrix2::zeros(), |sum, _| {
            let noise: Vec<f64> = (0..7).map(|_| SIGMA * rng.sample()).collect();
            let e = point(fit_point(
                &corner_arcs(start, travel, corner, &noise),
                &FitOptions::default(),
            ))
            .position
                - corner;
            sum + e * e.transpose() / f64::from(n)
        });
        let predicted = point(fit_point(
            &corner_arcs(start, travel, corner, &[0.0; 7]),
            &FitOptions::default(),
        ))
        .covariance;
        for (i, j) in [(0, 0), (1, 1), (0, 1)] {
            let ratio = spread[(i, j)] / predicted[(i, j)];
            assert!((0.88..1.12).contains(&ratio), "({i}, {j}): {ratio}");
        }
    }

    #[test]
    fn a_point_at_the_world_origin_is_nothing_special() {
        let fit = fit_point(
            &corner_arcs(
                Vec2::new(1.0, 1.0),
                2.5,
                Vec2::zeros(),
                &[1e-3, -1e-3, 0.0, 1e-3],
            ),
            &FitOptions::default(),
        );
        assert_eq!(fit.rejection, None);
        let found = point(fit);
        assert!(found.position.norm() < 0.03, "{}", found.position);
        assert_eq!(
            found.polar_covariance(),
            None,
            "polar coordinates are singular here"
        );
    }

    #[test]
    fn the_reported_polar_covariance_is_that_of_22() {
        // (12) with the paper's own Jacobian, at the same estimate.
        let (start, corner) = (Vec2::new(1.0, 1.0), Vec2::new(2.0, 3.0));
        let arcs = corner_arcs(start, 0.3, corner, &[0.0; 6]);
        let found = point(fit_point(&arcs, &FitOptions::default()));
        let (rho, alpha) = found.polar();
        let information = arcs.iter().fold(Matrix2::zeros(), |sum, a| {
            let j = polar_jacobian(rho, alpha, a.center());
            sum + j.transpose() * j / a.variance
        });
        let paper = information.try_inverse().unwrap();
        let ours = found.polar_covariance().unwrap();
        assert!(
            (paper - ours).norm() < 1e-9 * paper.norm().max(1.0),
            "{paper} {ours}"
        );
    }
}
