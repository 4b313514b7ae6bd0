//! Fits of runs whose features are known.

use nalgebra::{Matrix2, RowVector2, Vector2};
use proptest::prelude::*;

use super::model::{CartesianPoint, LocalLine, Model};
use super::testing::{Gauss, SIGMA, arc};
use super::*;
use crate::core::geometry::{Vec2, angle_between, direction, unit};
use crate::core::tmam::feature::{Point, Segment};
use crate::core::tmam::gauss_newton::Observation;
use crate::core::tmam::hypothesis::Gate;

fn strict() -> FitOptions {
    FitOptions {
        converge: true,
        misfits: Some(Gate::new(6.63)),
        mirrored: Some(13.0),
    }
}

mod lines {
    use super::*;
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
            let model = LocalLine::new(&arc(0, Vec2::new(0.3, -0.2), 0.7, 1.0));
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
        let model = LocalLine::new(&arc(0, Vec2::zeros(), 0.0, 1.0));
        let norm = |rho, theta| model.step_norm(Vector2::new(rho, theta));
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

mod points {
    use super::*;
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
            let (_, ours) = CartesianPoint.predict(unit(alpha) * rho, &seen).unwrap();
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

mod readings_of_several_features {
    use super::*;
    /// Every 12 cm along x, looking left, with noise.
    fn along_x(range: impl Fn(Vec2) -> f64, n: u32, seed: u64) -> Vec<Arc> {
        let mut rng = Gauss::new(seed);
        (0..n)
            .map(|k| {
                let sensor = Vec2::new(0.12 * f64::from(k), 0.0);
                arc(k, sensor, 1.5, range(sensor) + SIGMA * rng.sample())
            })
            .collect()
    }

    #[test]
    fn readings_of_the_corner_behind_a_wall_are_cut_off() {
        // The wall ends at x = 1; from there on its end echoes.
        let end = Vec2::new(1.0, 2.0);
        let run = along_x(|s| if s.x < 1.0 { 2.0 } else { (end - s).norm() }, 13, 1);
        let fit = fit_line(&run, &strict());
        assert_eq!(fit.rejection, None);
        let cut: Vec<u32> = fit.outliers.iter().map(|arc| arc.frame).collect();
        assert!(cut.iter().all(|frame| *frame > 8), "{cut:?}");
        assert!(cut.contains(&12) && cut.contains(&11), "{cut:?}");
        assert!(fit_line(&run, &FitOptions::default()).outliers.is_empty());
    }

    #[test]
    fn a_few_outliers_are_left_out_and_many_are_a_misfit() {
        let mut run = along_x(|_| 2.0, 12, 2);
        run[5].range += 0.1;
        let fit = fit_line(&run, &strict());
        assert_eq!(fit.rejection, None);
        assert!(fit.outliers.contains(&run[5].id), "{:?}", fit.outliers);
        assert!(fit.outliers.len() <= 2, "{:?}", fit.outliers);
        for at in [3, 4, 6, 7] {
            run[at].range += 0.1 * at as f64;
        }
        assert_eq!(fit_line(&run, &strict()).rejection, Some(Rejection::Misfit));
    }

    #[test]
    fn what_fits_on_either_side_of_the_path_is_not_registered() {
        let corner = Vec2::new(2.0, 0.35);
        let mut run = along_x(|s| (corner - s).norm(), 5, 3);
        for arc in &mut run {
            arc.world_from_sensor.yaw = 0.0;
        }
        let fit = fit_point(&run, &strict());
        assert_eq!(fit.rejection, Some(Rejection::Mirrored), "{fit:?}");
        // Looking to one side only, the beam tells.
        let corner = Vec2::new(0.4, 2.0);
        let fit = fit_point(&along_x(|s| (corner - s).norm(), 6, 3), &strict());
        assert_eq!(fit.rejection, None);
    }

    #[test]
    fn a_feature_at_the_edge_of_a_beam_is_not_lost_to_the_noise() {
        let at_edge = unit(1.5 - 0.25) * 2.0;
        let mut rejected = 0;
        for seed in 0..20 {
            let run = along_x(|s| (at_edge - s).norm(), 4, seed);
            let edge =
                |demands| fit_point(&run, &demands).rejection == Some(Rejection::OutsideBeams);
            assert!(!edge(strict()));
            rejected += u32::from(edge(FitOptions::default()));
        }
        assert!(rejected > 0, "the paper's rule has no slack");
    }

    #[test]
    fn a_wall_at_the_edge_of_a_beam_has_its_double_at_the_other_edge() {
        // Looking ahead with a beam of 180 degrees, along a wall: noise tilts it in or out of the beam.
        for seed in 0..10 {
            let mut arcs = along_x(|_| 2.0, 12, seed);
            for arc in &mut arcs {
                arc.world_from_sensor.yaw = 0.0;
                arc.beam_width = std::f64::consts::PI;
            }
            let demands = FitOptions {
                converge: true,
                misfits: Some(Gate::new(6.63)),
                mirrored: Some(13.0),
            };
            let fit = fit_line(&arcs, &demands);
            assert!(
                matches!(
                    fit.rejection,
                    Some(Rejection::Mirrored | Rejection::NoStart)
                ),
                "{seed}: {fit:?}"
            );
        }
    }
}

mod parts {
    use super::*;
    const READINGS: u32 = 60;

    /// Along a wall, every 10 cm, while the odometry says that the robot drifts away from it.
    fn run(drift: impl Fn(f64) -> f64) -> Run {
        let mut rng = Gauss::new(5);
        let associated: Vec<Arc> = (0..READINGS)
            .map(|k| {
                let x = 0.1 * f64::from(k);
                arc(k, Vec2::new(x, drift(x)), 1.5, 2.0 + SIGMA * rng.sample())
            })
            .collect();
        Run {
            kind: Kind::Line,
            labelled: associated[1..associated.len() - 1]
                .iter()
                .map(|arc| arc.id)
                .collect(),
            associated,
        }
    }

    #[test]
    fn a_wall_that_drift_bends_is_taken_in_parts() {
        let bent = run(|x| 0.004 * x * x);
        assert_eq!(fit_run(&bent, &strict()).rejection, Some(Rejection::Misfit));
        let parts = fit_in_parts(bent.clone(), &strict());
        assert!((2..=6).contains(&parts.len()), "{}", parts.len());
        let fitted = parts.iter().filter(|(_, fit)| fit.rejection.is_none());
        let kept: usize = fitted
            .map(|(part, fit)| part.associated.len() - fit.outliers.len())
            .sum();
        assert!(kept > 40, "{kept} of {READINGS}");
        let labelled: Vec<_> = parts.iter().flat_map(|(p, _)| p.labelled.clone()).collect();
        assert_eq!(labelled, bent.labelled, "in order, each once");
    }

    #[test]
    fn what_fits_stays_whole_and_what_never_fits_stays_rejected() {
        let straight = run(|_| 0.0);
        assert_eq!(fit_in_parts(straight, &strict()).len(), 1);
        let wild = run(|x| 0.3 * ((10.0 * x).round() % 2.0));
        let parts = fit_in_parts(wild, &strict());
        assert_eq!(parts.len(), 1);
        assert_eq!(parts[0].1.rejection, Some(Rejection::Misfit));
    }

    #[test]
    fn a_part_has_the_labels_of_its_readings() {
        let (before, after) = run(|_| 0.0).broken_at(20);
        assert_eq!((before.associated.len(), after.associated.len()), (20, 40));
        assert_eq!((before.labelled.len(), after.labelled.len()), (19, 39));
    }
}
