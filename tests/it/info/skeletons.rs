//! Logs that need a configuration, and that the one which is proposed is enough.

use std::f32::consts::FRAC_PI_8;
use std::path::Path;

use serde_json::Value;

use super::{changed, codes, put, told};
use crate::support::{Bench, Message, sample, untyped, without};

/// A log that cannot be replayed for a reason, and can with the skeleton.
fn mended(bytes: Vec<u8>, blocking: &[&str], skeleton: &[&str]) {
    let bench = Bench::new();
    let log = put(&bench, bytes);
    assert_ne!(bench.tmam(&log, "replay {} --features f").code, 0);
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(info["replay"]["possible"], "with-skeleton", "{info:#}");
    assert_eq!(codes(&info, "blocking"), blocking);

    let text = bench.tmam(&log, "info {}").stdout;
    assert!(
        text.lines().all(|line| line.chars().count() <= 100),
        "{text}"
    );
    let printed = bench.tmam(&log, "info {} --skeleton");
    assert_eq!(
        (printed.code, printed.stdout.as_str()),
        (3, info["skeleton"].as_str().unwrap())
    );
    for words in skeleton {
        assert!(
            printed.stdout.contains(words),
            "no {words:?} in {}",
            printed.stdout
        );
    }
    bench.put("tmam.toml", &printed.stdout);
    let run = bench.tmam(&log, "replay {} --config tmam.toml --features f");
    assert_eq!(run.code, 0, "{}\n{}", run.stderr, printed.stdout);
    assert_eq!(
        bench.json("f")["counts"]["frames"],
        info["replay"]["counts"]["frames"]
    );
    // With what it asked for, nothing stands in the way any more.
    let (info, code) = told(&bench, &log, "--config tmam.toml");
    assert_eq!(
        (code, &info["replay"]["possible"]),
        (0, &Value::from("yes"))
    );
    assert!(codes(&info, "blocking").is_empty());
}

#[test]
fn no_mounts() {
    mended(
        without(&sample("room_step.mcap"), &["/tf"]),
        &["no-mount"],
        &[
            "[sonar.\"sonar_00\"]",
            "[sonar.\"sonar_15\"]",
            "x = 0.0",
            "measure these",
            "`base_link`",
        ],
    );
    let bench = Bench::new();
    let log = put(&bench, without(&sample("room_step.mcap"), &["/tf_static"]));
    let (info, _) = told(&bench, &log, "");
    assert_eq!(info["sonars"][0]["mount"], Value::Null);
    assert_eq!(info["sonars"][0]["readings"], 150);
    assert_eq!(codes(&info, "blocking"), ["no-mount"]);
    let finding = &info["findings"][0]["what"];
    assert!(
        finding.as_str().unwrap().contains("all 16 sonars"),
        "{finding}"
    );
}

#[test]
fn two_odometries() {
    let doubled = changed("room_step.mcap", |message| {
        let copy = Message {
            topic: "/wheel[odom]".into(),
            log_time: message.log_time,
            data: message.data.clone(),
            rank: 0,
        };
        match message.topic.as_str() {
            "/odom" if message.log_time % 2 == 0 => vec![copy, message],
            _ => vec![message],
        }
    });
    mended(
        doubled,
        &["many-odometries"],
        &["odometry_topics = [\"/odom\"]", "/wheel[odom]"],
    );
}

#[test]
fn no_beam_width_and_no_mounts_at_once() {
    let blind = changed("room_step.mcap", |mut message| {
        if message.topic.starts_with("/sonar") {
            // Behind header and radiation type: field_of_view, aligned to four bytes.
            let at = 4 + 8 + 4 + "sonar_00".len() + 1 + 3;
            let value: [u8; 4] = message.data[at..at + 4].try_into().unwrap();
            assert!((f32::from_le_bytes(value) - FRAC_PI_8).abs() < 1e-3);
            message.data[at..at + 4].copy_from_slice(&0f32.to_le_bytes());
        }
        if message.topic.starts_with("/tf") {
            Vec::new()
        } else {
            vec![message]
        }
    });
    mended(
        blind,
        &["no-mount", "no-beam-width"],
        &["[sonars]\nbeam_width = 22.5", "data sheet", "yaw = 0.0"],
    );
}

#[test]
fn odometry_that_is_too_slow() {
    let slow = changed("room_step.mcap", |message| {
        let second = message.log_time / 1_000_000_000;
        let keep = message.topic != "/odom" || second % 8 == 0;
        if keep { vec![message] } else { Vec::new() }
    });
    let bench = Bench::new();
    let log = put(&bench, slow);
    let (info, _) = told(&bench, &log, "");
    assert_eq!(
        codes(&info, "serious").first(),
        Some(&"no-pose"),
        "{info:#}"
    );
    let skeleton = info["skeleton"].as_str().unwrap();
    assert!(
        skeleton.contains("[frames]\nmax_odometry_gap = "),
        "{skeleton}"
    );
    bench.put("tmam.toml", skeleton);
    let before = bench.tmam(&log, "replay {} --features f --trace t");
    let dropped = bench.json("f")["counts"]["dropped"]["odometry-gap"].as_u64();
    assert!(dropped.unwrap() > 1000, "{}", before.stderr);
    bench.tmam(&log, "replay {} --config tmam.toml --features f");
    assert_eq!(
        bench.json("f")["counts"]["dropped"]["odometry-gap"],
        Value::Null
    );
}

#[test]
fn a_gate_wider_than_the_beam() {
    let bench = Bench::new();
    let made = bench.tmam(Path::new(""), "simulate -o narrow.mcap --beam-width 8");
    assert_eq!(made.code, 0, "{}", made.stderr);
    let log = bench.path("narrow.mcap");
    // Where angles do not decide, the gate is nothing to fail over.
    assert_eq!(bench.tmam(&log, "replay {} --features f").code, 0);
    assert_eq!(
        bench.tmam(&log, "replay {} --rule paper --features f").code,
        2
    );
    let (info, code) = told(&bench, &log, "--rule paper");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["gamma-beyond-beam"]);
    let skeleton = info["skeleton"].as_str().unwrap();
    assert!(skeleton.contains("[triple]\ngamma = "), "{skeleton}");
    bench.put("tmam.toml", skeleton);
    let (info, code) = told(&bench, &log, "--rule paper --config tmam.toml");
    assert_eq!(
        (code, &info["replay"]["possible"]),
        (0, &Value::from("yes"))
    );
}

#[test]
fn channels_without_types_are_given_one_each() {
    let bench = Bench::new();
    let log = put(&bench, untyped(&sample("room_drive.mcap")));
    let printed = bench.tmam(&log, "info {} --skeleton");
    for said in [
        "[channel.\"/odom\"]\ntype = \"nav_msgs/msg/Odometry\"",
        "[channel.\"/sonar/sonar_03\"]\ntype = \"sensor_msgs/msg/Range\"",
        "[channel.\"/tf_static\"]\ntype = \"tf2_msgs/msg/TFMessage\"",
    ] {
        assert!(
            printed.stdout.contains(said),
            "no {said}: {}",
            printed.stdout
        );
    }
    bench.put("tmam.toml", &printed.stdout);
    let run = bench.tmam(&log, "replay {} --config tmam.toml --features f");
    assert_eq!(run.code, 0, "{}\n{}", run.stderr, printed.stdout);
    // A word that is misspelt is told first.
    let transforms = "[channel.\"/tf\"]\ntype = \"tf2_msgs/msg/TFMessage\"";
    let misspelt = printed.stdout.replace("Odometry", "Odometri");
    bench.put("tmam.toml", misspelt.replace(transforms, ""));
    let run = bench.tmam(&log, "replay {} --config tmam.toml --features f");
    assert_eq!(run.code, 2, "{}", run.stderr);
    let said = "The log holds:\n  - /odom (nav_msgs/msg/Odometri, cdr, 1001 messages: `nav_msgs/msg/Odometri`, \
                which the configuration says";
    assert!(run.stderr.contains(said), "{}", run.stderr);
}
