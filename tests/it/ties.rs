//! A result does not hang on the last bit: poses and ranges moved by less than a nanometre give the
//! same labels, the same features under the same ids, and values that agree to a micrometre.

use std::path::{Path, PathBuf};

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use tmam_replay::core::config::{Config, Rule};
use tmam_replay::core::event::{Events, OdometrySample, RangeReading};
use tmam_replay::core::geometry::{Pose2, angle_between};
use tmam_replay::core::log::Log;
use tmam_replay::core::replay::{Outcome, Replay};
use tmam_replay::core::tmam::arc::ArcId;
use tmam_replay::core::tmam::feature::Shape;
use tmam_replay::core::tmam::label::Label;
use tmam_replay::core::tmam::step::Extraction;
use tmam_replay::io::log;

use super::support::{Bench, sample, shared};

/// Seeded runs of each log under each rule.
const RUNS: u64 = 20;

/// What values may differ by: metres and radians; covariances and chi2 by this share of them.
const TOLERANCE: f64 = 1e-6;

/// Every pose and every range moved by up to `most`, metres and radians.
fn perturbed(events: &Events, most: f64, seed: u64) -> Events {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut moved = |value: f64| {
        let share = random.next_u32() as f64 / f64::from(u32::MAX) * 2.0 - 1.0;
        value + share * most
    };
    let mut events = events.clone();
    for sample in &mut events.odometry {
        sample.world_from_robot = moved_pose(&sample.world_from_robot, &mut moved);
    }
    for sonar in &mut events.sonars {
        sonar.robot_from_sensor = moved_pose(&sonar.robot_from_sensor, &mut moved);
    }
    events.readings.change(|reading| {
        if reading.range.is_finite() {
            reading.range = moved(reading.range);
        }
    });
    events
}

fn moved_pose(pose: &Pose2, moved: &mut impl FnMut(f64) -> f64) -> Pose2 {
    Pose2::new(moved(pose.x), moved(pose.y), moved(pose.yaw))
}

/// The differences between two outcomes; empty where they agree.
fn differences(expected: &Outcome, found: &Outcome) -> Vec<String> {
    let mut told = Vec::new();
    let mut same = |what: &str, same: bool, values: String| {
        if !same {
            told.push(format!("{what}: {values}"));
        }
    };
    let labels = |of: &Outcome| -> Vec<(ArcId, Label)> {
        of.reports.iter().map(|r| (r.arc.id, r.label)).collect()
    };
    same("arcs", labels(expected) == labels(found), String::new());
    let pair = |a: &dyn std::fmt::Debug, b: &dyn std::fmt::Debug| format!("{a:?} -> {b:?}");
    same(
        "frames",
        expected.frames == found.frames,
        pair(&expected.frames, &found.frames),
    );
    same(
        "tally",
        expected.tally == found.tally,
        pair(&expected.tally, &found.tally),
    );
    same(
        "labels",
        expected.labels == found.labels,
        pair(&expected.labels, &found.labels),
    );
    same(
        "reasons",
        expected.reasons == found.reasons,
        pair(&expected.reasons, &found.reasons),
    );
    same(
        "suspects",
        expected.suspects == found.suspects,
        pair(&expected.suspects, &found.suspects),
    );
    let count = (expected.extractions.len(), found.extractions.len());
    same("extractions", count.0 == count.1, pair(&count.0, &count.1));
    for (a, b) in expected.extractions.iter().zip(&found.extractions) {
        let what = format!("extraction {}", a.id);
        let parts = |e: &Extraction| {
            (
                e.kind,
                e.labelled.clone(),
                e.associated.clone(),
                e.outliers.clone(),
                e.action,
                e.absorbed.clone(),
            )
        };
        same(&what, parts(a) == parts(b), pair(&parts(a), &parts(b)));
        same(
            &what,
            (a.residual_rms - b.residual_rms).abs() < TOLERANCE,
            pair(&a.residual_rms, &b.residual_rms),
        );
        same(
            &what,
            alike(a.shape.as_ref(), b.shape.as_ref()),
            pair(&a.shape, &b.shape),
        );
    }
    let count = (expected.map.len(), found.map.len());
    same("map", count.0 == count.1, pair(&count.0, &count.1));
    for (a, b) in expected.map.iter().zip(&found.map) {
        let what = format!("map feature {}", a.id);
        let parts =
            |f: &tmam_replay::core::tmam::feature::MapFeature| (f.id, f.readings, f.runs, f.status);
        same(&what, parts(a) == parts(b), pair(&parts(a), &parts(b)));
        same(
            &what,
            alike(Some(&a.shape), Some(&b.shape)),
            pair(&a.shape, &b.shape),
        );
    }
    told
}

fn alike(a: Option<&Shape>, b: Option<&Shape>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(Shape::Line(a)), Some(Shape::Line(b))) => {
            (a.rho - b.rho).abs() < TOLERANCE
                && angle_between(a.theta, b.theta) < TOLERANCE
                && (a.mid - b.mid).norm() < TOLERANCE
                && (a.half_length - b.half_length).abs() < TOLERANCE
                && (a.covariance - b.covariance).norm() < TOLERANCE * a.covariance.norm().max(1.0)
        }
        (Some(Shape::Point(a)), Some(Shape::Point(b))) => {
            (a.position - b.position).norm() < TOLERANCE
                && (a.covariance - b.covariance).norm() < TOLERANCE * a.covariance.norm().max(1.0)
        }
        _ => false,
    }
}

/// Replays a log as it is and perturbed.
fn hold(path: Option<PathBuf>, rule: Rule) {
    let Some(path) = path else { return };
    let config = Config::with_rule(rule);
    let log = log::read(&path, &config).unwrap();
    let outcome = |events: Events| {
        let log = Log {
            events,
            ..log.clone()
        };
        Replay::new(&log, &config).unwrap().run(&mut []).unwrap()
    };
    let expected = outcome(log.events.clone());
    let mut failed = Vec::new();
    for seed in 0..RUNS {
        // From 1e-12 to 1e-9.
        let most = 1e-12 * libm::pow(10.0, 3.0 * seed as f64 / (RUNS - 1) as f64);
        let found = outcome(perturbed(&log.events, most, seed));
        let told = differences(&expected, &found);
        if !told.is_empty() {
            failed.push(format!(
                "seed {seed}, moved by up to {most:.1e}:\n  {}",
                told.join("\n  ")
            ));
        }
    }
    assert!(
        failed.is_empty(),
        "{} of {RUNS} differ under {rule:?}\n{}",
        failed.len(),
        failed.join("\n")
    );
}

#[test]
fn room_step() {
    hold(Some(sample("room_step.mcap")), Rule::NoiseAware);
}

#[test]
fn room_step_by_the_paper() {
    hold(Some(sample("room_step.mcap")), Rule::Paper);
}

#[test]
fn room_drive() {
    hold(Some(sample("room_drive.mcap")), Rule::NoiseAware);
}

#[test]
fn room_drive_by_the_paper() {
    hold(Some(sample("room_drive.mcap")), Rule::Paper);
}

#[test]
fn house_run1() {
    hold(shared("house_run1.mcap"), Rule::NoiseAware);
}

#[test]
fn house_run1_by_the_paper() {
    hold(shared("house_run1.mcap"), Rule::Paper);
}

/// Poses are estimated with the features there.
#[test]
fn a_drive_with_odometry_that_drifts() {
    let bench = Bench::new();
    let made = bench.tmam(
        Path::new(""),
        "simulate -o room.mcap --drive --noise 0.003 --odometry-noise 0.01 --heading-noise 0.2 --turn-noise 0.5",
    );
    assert_eq!(made.code, 0, "{}", made.stderr);
    hold(Some(bench.path("room.mcap")), Rule::NoiseAware);
}

#[test]
fn the_order_of_messages_of_one_stamp_does_not_matter() {
    let config = Config::default();
    let mut log = log::read(&sample("room_step.mcap"), &config).unwrap();
    // Some sonars fire twice at a stamp, and some poses come twice.
    let again = log
        .events
        .readings
        .iter()
        .step_by(50)
        .map(|r| RangeReading {
            range: r.range + 0.01,
            ..r
        });
    let again: Vec<RangeReading> = again.collect();
    log.events.readings.extend(again);
    let again: Vec<OdometrySample> = log.events.odometry.iter().step_by(20).copied().collect();
    log.events
        .odometry
        .extend(again.iter().map(|s| OdometrySample {
            world_from_robot: Pose2 {
                x: s.world_from_robot.x + 0.001,
                ..s.world_from_robot
            },
            ..*s
        }));
    let outcome = |events: Events| {
        let log = Log {
            events,
            ..log.clone()
        };
        Replay::new(&log, &config).unwrap().run(&mut []).unwrap()
    };
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut orders = (0..4).map(|_| {
        let mut events = log.events.clone();
        let mut readings: Vec<RangeReading> = events.readings.iter().collect();
        for k in (1..readings.len()).rev() {
            readings.swap(k, random.next_u32() as usize % (k + 1));
        }
        events.readings = readings.into_iter().collect();
        for k in (1..events.odometry.len()).rev() {
            events
                .odometry
                .swap(k, random.next_u32() as usize % (k + 1));
        }
        events.sort();
        outcome(events)
    });
    let first = orders.next().unwrap();
    assert!(orders.all(|other| other == first));
}
