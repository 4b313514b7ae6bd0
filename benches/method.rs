//! Where a replay spends its time: the second opinion, fits, and a replay as a whole.
//!
//! `cargo bench` runs them.

#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that meets something unexpected should stop on the spot"
)]

use std::path::Path;

use divan::{Bencher, black_box};
use tmam_replay::core::config::{Config, Method, Poses, Rule};
use tmam_replay::core::event::SonarId;
use tmam_replay::core::geometry::{Pose2, Vec2, direction};
use tmam_replay::core::replay::Replay;
use tmam_replay::core::tmam::arc::{Arc, ArcId};
use tmam_replay::core::tmam::fit::{FitOptions, fit_line, fit_point};
use tmam_replay::core::tmam::hypothesis::{Gate, HypothesisTest};
use tmam_replay::io::log::read;

fn main() {
    divan::main();
}

/// Readings every 12 cm along x of a corner at (0.5, 2), or of the wall 2 m up, 3 mm off in turn.
fn arcs(n: u32, corner: bool) -> Vec<Arc> {
    (0..n)
        .map(|frame| {
            let sensor = Vec2::new(0.12 * f64::from(frame), 0.0);
            let towards = Vec2::new(0.5, 2.0) - sensor;
            let (range, yaw) = if corner {
                (towards.norm(), direction(towards))
            } else {
                (2.0, 1.5)
            };
            Arc {
                id: ArcId {
                    frame,
                    sonar: SonarId(0),
                },
                stamp_ns: 0,
                world_from_sensor: Pose2::new(sensor.x, sensor.y, yaw),
                range: range + if frame % 2 == 0 { 0.003 } else { -0.003 },
                beam_width: 0.4,
                variance: 9e-6,
            }
        })
        .collect()
}

/// Of a triple, and of the widest window.
#[divan::bench(args = [3, 21])]
fn opinion(bencher: Bencher<'_, '_>, readings: u32) {
    let (arcs, gate) = (arcs(readings, false), Gate::new(6.63));
    bencher.bench_local(|| HypothesisTest::of(black_box(&arcs), &gate));
}

#[divan::bench(args = [false, true])]
fn fit_of_a_run(bencher: Bencher<'_, '_>, corner: bool) {
    let arcs = arcs(12, corner);
    let demands = FitOptions {
        converge: true,
        misfits: Some(Gate::new(6.63)),
        mirrored: Some(13.0),
    };
    bencher.bench_local(|| {
        let arcs = black_box(&arcs);
        if corner {
            fit_point(arcs, &demands)
        } else {
            fit_line(arcs, &demands)
        }
    });
}

#[divan::bench(args = ["paper", "noise-aware"])]
fn replay_of_the_sample_log(bencher: Bencher<'_, '_>, rule: &str) {
    let rule = if rule == "paper" {
        Rule::Paper
    } else {
        Rule::NoiseAware
    };
    let config = Config::with_rule(rule);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_logs/room_step.mcap");
    let log = read(&path, &config).unwrap();
    let replay = Replay::new(&log, &config).unwrap();
    bencher.bench_local(|| replay.run(&mut []).unwrap());
}

/// The methods on one log; TMAM at the poses of odometry, as the others.
#[divan::bench(args = [
    Method::Tmam, Method::TwoMeasurement, Method::Tbf, Method::Atm, Method::Rcd, Method::Crowley,
])]
fn methods(bencher: Bencher<'_, '_>, method: Method) {
    let config = Config {
        method,
        poses: Poses::Odometry,
        ..Config::default()
    };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_logs/room_step.mcap");
    let log = read(&path, &config).unwrap();
    let replay = Replay::new(&log, &config).unwrap();
    bencher.bench_local(|| replay.run(&mut []).unwrap());
}
