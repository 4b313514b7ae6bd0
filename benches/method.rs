//! Where a replay spends its time: decoding, the step of the machine, the test in a window, fits, the encoding of a
//! recording, and a replay as a whole.
//!
//! `cargo bench` runs them; `benches/yardstick.py` times whole processes.

#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that meets something unexpected should stop on the spot"
)]

use std::path::{Path, PathBuf};

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use tmam_replay::core::config::{Config, Method, Poses, Rule};
use tmam_replay::core::event::SonarId;
use tmam_replay::core::geometry::{Pose2, Vec2, direction};
#[cfg(feature = "viewer")]
use tmam_replay::core::observer::Kept;
use tmam_replay::core::replay::Replay;
use tmam_replay::core::tmam::Tmam;
use tmam_replay::core::tmam::arc::{Arc, ArcId};
use tmam_replay::core::tmam::fit::{FitOptions, fit_line, fit_point};
use tmam_replay::core::tmam::hypothesis::{Gate, HypothesisTest};
use tmam_replay::io::log::{Gathered, read};
#[cfg(feature = "viewer")]
use tmam_replay::observe::drawing::Overlay;
#[cfg(feature = "viewer")]
use tmam_replay::observe::recording::Recording;

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

/// Of a triple, of a window as it decides most often, and of the widest.
#[divan::bench(args = [3, 7, 21])]
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

/// From the bytes of a log to readings and odometry: every message read and decoded.
#[divan::bench]
fn decode_of_the_sample_log(bencher: Bencher<'_, '_>) {
    let (log, config) = (sample(), Config::default());
    let messages = read(&log, &config).unwrap().messages;
    let messages = ItemsCount::new(messages);
    let bencher = bencher.counter(messages);
    bencher.bench_local(|| Gathered::read(&log, &config).unwrap());
}

/// Every frame through the machine: by arc.
#[divan::bench(args = ["paper", "noise-aware"])]
fn step_of_the_sample_log(bencher: Bencher<'_, '_>, rule: &str) {
    let config = config(rule);
    let log = read(&sample(), &config).unwrap();
    let replay = Replay::new(&log, &config).unwrap();
    let bencher = bencher.counter(echoes(&replay));
    bencher.bench_local(|| {
        let mut tmam = Tmam::new(replay.config());
        for frame in replay.frames() {
            black_box(tmam.step(frame));
        }
        tmam.finish()
    });
}

/// What a replay brought about, as a recording: by frame.
#[cfg(feature = "viewer")]
#[divan::bench]
fn encode_of_the_sample_log(bencher: Bencher<'_, '_>) {
    let config = Config::default();
    let log = read(&sample(), &config).unwrap();
    let replay = Replay::new(&log, &config).unwrap();
    let mut kept = Kept::default();
    replay.run(&mut [&mut kept]).unwrap();
    let bencher = bencher.counter(ItemsCount::new(replay.frames().len()));
    bencher.bench_local(|| {
        let mut out = Vec::new();
        let overlay = Overlay::default();
        let mut recording =
            Recording::new(Some(&mut out), None, replay.setting(), overlay).unwrap();
        kept.show(&mut recording).unwrap();
        recording.close(None).unwrap();
        out
    });
}

/// With poses estimated under the noise-aware rule: by arc.
#[divan::bench(args = ["paper", "noise-aware"])]
fn replay_of_the_sample_log(bencher: Bencher<'_, '_>, rule: &str) {
    let config = config(rule);
    let log = read(&sample(), &config).unwrap();
    let replay = Replay::new(&log, &config).unwrap();
    let bencher = bencher.counter(echoes(&replay));
    bencher.bench_local(|| replay.run(&mut []).unwrap());
}

/// The methods on one log, by arc; TMAM at the poses of odometry, as the others.
#[divan::bench(args = [
    Method::Tmam, Method::TwoMeasurement, Method::Tbf, Method::Atm, Method::Rcd, Method::Crowley,
])]
fn methods(bencher: Bencher<'_, '_>, method: Method) {
    let config = Config {
        method,
        poses: Poses::Odometry,
        ..Config::default()
    };
    let log = read(&sample(), &config).unwrap();
    let replay = Replay::new(&log, &config).unwrap();
    let bencher = bencher.counter(echoes(&replay));
    bencher.bench_local(|| replay.run(&mut []).unwrap());
}

/// The arcs of a log.
fn echoes(replay: &Replay<'_>) -> ItemsCount {
    let entries = replay.frames().iter().flat_map(|frame| &frame.entries);
    ItemsCount::new(entries.filter(|entry| entry.echo.is_some()).count())
}

fn config(rule: &str) -> Config {
    Config::with_rule(match rule {
        "paper" => Rule::Paper,
        _ => Rule::NoiseAware,
    })
}

fn sample() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_logs/room_step.mcap")
}
