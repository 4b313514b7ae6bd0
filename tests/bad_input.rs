//! Bad input: a clear message that says what was found and what to do, the right exit code, and no
//! output file left behind.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test that meets something unexpected should fail on the spot"
)]

mod support;

use std::fs;
use std::path::Path;

use support::{Bench, rewrite, sample, without};

/// Replays, and expects a refusal that says all of `said`.
fn refused(bench: &Bench, log: &Path, arguments: &str, code: i32, said: &[&str]) {
    let before = bench.files();
    let run = bench.tmam(log, arguments);
    assert_eq!(run.code, code, "{arguments}: {}", run.stderr);
    assert!(run.stdout.is_empty(), "{}", run.stdout);
    assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    for words in said {
        assert!(
            run.stderr.contains(words),
            "no {words:?} in: {}",
            run.stderr
        );
    }
    assert_eq!(bench.files(), before, "{arguments}");
}

fn refuses(bytes: Vec<u8>, code: i32, said: &[&str]) {
    let bench = Bench::new();
    let log = bench.put("log.mcap", bytes);
    refused(&bench, &log, "replay {}", code, said);
}

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
        &["cannot read", "directory"],
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
    refuses(Vec::new(), 2, &["not an MCAP file"]);
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
fn topics_that_match_nothing_are_named() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    refused(
        &bench,
        &log,
        "replay {} --range-topic /us/*",
        2,
        &["/us/*", "/sonar/sonar_00"],
    );
    refused(
        &bench,
        &log,
        "replay {} --odom-topic /wheel",
        2,
        &["/wheel", "/odom"],
    );
    refused(
        &bench,
        &log,
        "replay {} --sensor front*",
        2,
        &["front*", "sonar_00"],
    );
}

#[test]
fn two_odometries_and_no_choice() {
    let bench = Bench::new();
    let doubled = rewrite(
        &sample("room_step.mcap"),
        mcap::WriteOptions::new(),
        |message| {
            let copy = support::Message {
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
fn parameters_out_of_bounds() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    for (flags, said) in [
        (
            "--alpha 1",
            "triple.alpha is 1; it must be above 0 and below 1",
        ),
        ("--alpha nan", "triple.alpha is NaN"),
        ("--beta 0.9", "triple.beta is 0.9; it must be above 1"),
        (
            "--gamma 22.6",
            "must be below the beam width, which is 22.500001 deg for sonar `sonar_00`",
        ),
        ("--gamma 0", "triple.gamma is 0"),
        ("--step=-1", "frames.step is -1; it must be at least 0"),
        ("--start 5 --end 4", "ends at 4 s, before its start at 5 s"),
        ("--start 1e9", "Widen the window"),
        ("--sensor [", "is not a glob"),
        ("--set triple.gama=4", "did you mean `triple.gamma`?"),
        ("--set triple.gamma", "KEY=VALUE"),
    ] {
        let code = if flags == "--start 1e9" { 3 } else { 2 };
        refused(&bench, &log, &format!("replay {{}} {flags}"), code, &[said]);
    }
    assert_eq!(bench.tmam(&log, "replay {} --alpha").code, 2);
    assert_eq!(bench.tmam(&log, "replay {} --no-such-flag").code, 2);
}

#[test]
fn a_configuration_with_an_unknown_key() {
    let bench = Bench::new();
    bench.put("tmam.toml", "[triple]\nalhpa = 0.3\n");
    let said = [
        "tmam.toml: unknown key `triple.alhpa`",
        "did you mean `triple.alpha`?",
    ];
    refused(
        &bench,
        &sample("room_step.mcap"),
        "replay {} --config tmam.toml",
        2,
        &said,
    );
    refused(
        &bench,
        &sample("room_step.mcap"),
        "replay {} --config no.toml",
        2,
        &["no.toml"],
    );
    bench.put("tmam.toml", "[triple\n");
    refused(
        &bench,
        &sample("room_step.mcap"),
        "config --config tmam.toml",
        2,
        &["tmam.toml"],
    );
}

#[test]
fn an_output_that_cannot_be_written_or_would_destroy_the_log() {
    let bench = Bench::new();
    let log = bench.put("log.mcap", fs::read(sample("room_step.mcap")).unwrap());
    refused(
        &bench,
        &log,
        "replay {} -o no/such/place.rrd",
        2,
        &["cannot write no/such/place.rrd"],
    );
    refused(
        &bench,
        &log,
        "replay {} --features log.mcap",
        2,
        &["log.mcap is named twice"],
    );
    assert_eq!(
        fs::read(&log).unwrap(),
        fs::read(sample("room_step.mcap")).unwrap()
    );
}

#[test]
fn a_log_that_breaks_off_is_used_as_far_as_it_goes() {
    let whole = fs::read(sample("room_drive.mcap")).unwrap();
    let bench = Bench::new();
    let log = bench.put("log.mcap", &whole[..whole.len() * 2 / 3]);
    let run = bench.tmam(&log, "replay {} --features f --trace t");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(
        run.stderr.contains("could not be read whole"),
        "{}",
        run.stderr
    );
    let features = bench.json("f");
    assert_eq!(features["source"]["complete"], false);
    assert!(features["counts"]["echoes"].as_u64().unwrap() > 100);
}

#[test]
fn a_chunk_with_a_flipped_bit_is_left_out_and_said_so() {
    let bench = Bench::new();
    let options = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(20_000));
    let mut bytes = rewrite(&sample("room_step.mcap"), options, |message| vec![message]);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    let log = bench.put("log.mcap", bytes);
    let run = bench.tmam(&log, "replay {} --features f");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(
        run.stderr.contains("a chunk with messages logged from"),
        "{}",
        run.stderr
    );
    assert_eq!(bench.json("f")["source"]["complete"], false);
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
