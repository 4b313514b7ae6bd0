//! Files that are no log, and logs that lack what a replay needs.

use std::path::Path;

use super::{refused, refuses};
use crate::support::{Bench, rewrite, sample, without};

#[test]
fn a_file_that_is_not_there_or_not_a_log() {
    let bench = Bench::new();
    refused(
        &bench,
        Path::new("no.mcap"),
        "replay {}",
        2,
        &["no.mcap", "No such file"],
    );
    refused(
        &bench,
        Path::new("."),
        "replay {}",
        2,
        &["is a folder without a .mcap file"],
    );
    refuses(
        b"hello, world".to_vec(),
        2,
        &["not an MCAP file", "convert"],
    );
    refuses(
        b"a longer text that is no log either\n".repeat(99),
        2,
        &["not an MCAP file"],
    );
    refuses(Vec::new(), 2, &["is empty"]);
}

#[test]
fn a_log_without_ranges_or_odometry_names_what_it_has() {
    let log = sample("room_step.mcap");
    let no_ranges = without(&log, &["/sonar"]);
    refuses(
        no_ranges,
        2,
        &[
            "no range readings",
            "/odom (nav_msgs/msg/Odometry, cdr, 150 messages)",
        ],
    );
    let no_odometry = without(&log, &["/odom", "/tf"]);
    refuses(
        no_odometry,
        2,
        &["no odometry", "/sonar/sonar_00 (sensor_msgs/msg/Range"],
    );
}

#[test]
fn two_odometries_and_no_choice() {
    let bench = Bench::new();
    let doubled = rewrite(
        &sample("room_step.mcap"),
        mcap::WriteOptions::new(),
        |message| {
            let copy = crate::support::Message {
                topic: "/wheel_odom".into(),
                log_time: message.log_time,
                data: message.data.clone(),
                rank: 0,
            };
            if message.topic == "/odom" {
                vec![message, copy]
            } else {
                vec![message]
            }
        },
    );
    let log = bench.put("log.mcap", doubled);
    let said = [
        "more than one odometry topic",
        "/odom, /wheel_odom",
        "--odom-topic",
    ];
    refused(&bench, &log, "replay {}", 2, &said);
    assert_eq!(
        bench
            .tmam(&log, "replay {} --odom-topic /odom --features f")
            .code,
        0
    );
}

#[test]
fn a_sonar_whose_frame_is_unknown_is_no_identity() {
    let bench = Bench::new();
    let log = bench.put("log.mcap", without(&sample("room_step.mcap"), &["/tf"]));
    let said = [
        "`sonar_00`",
        "no transform joins it to `base_link`",
        "[sonar.\"sonar_00\"]",
        "yaw",
    ];
    refused(&bench, &log, "replay {}", 2, &said);
    let mounts: String = (0..16)
        .map(|k| {
            format!(
                "[sonar.sonar_{k:02}]\nx = 0.2\ny = 0\nyaw = {}\n",
                22.5 * f64::from(k)
            )
        })
        .collect();
    bench.put("tmam.toml", mounts);
    assert_eq!(
        bench
            .tmam(&log, "replay {} --config tmam.toml --features f")
            .code,
        0
    );
}

#[test]
fn clocks_that_do_not_meet() {
    let shifted = rewrite(
        &sample("room_step.mcap"),
        mcap::WriteOptions::new(),
        |mut message| {
            if message.topic == "/odom" {
                message.shift_stamp(3600);
            }
            vec![message]
        },
    );
    let said = [
        "2400 range readings",
        "150 odometry samples",
        "do not overlap in time",
    ];
    refuses(shifted, 3, &said);
}

#[test]
fn a_log_in_which_nothing_echoes_has_nothing_to_judge() {
    let bench = Bench::new();
    let made = bench.tmam(
        Path::new(""),
        "simulate -o far.mcap --max-range 0.3 --steps 20",
    );
    assert_eq!(made.code, 0, "{}", made.stderr);
    let run = bench.tmam(&bench.path("far.mcap"), "replay {} --features f");
    assert_eq!(run.code, 3);
    assert!(
        run.stderr.contains("not one reading is an echo"),
        "{}",
        run.stderr
    );
    assert_eq!(bench.json("f")["counts"]["echoes"], 0);
}
