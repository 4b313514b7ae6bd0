//! Logs that can be replayed, told in full.

use serde_json::Value;

use super::{changed, codes, put, quarter_turn, told};
use crate::support::{Bench, sample, untyped};

#[test]
fn a_good_log_is_told_in_full() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 0);
    assert_eq!(info["schema"], "tmam.info/1");
    assert_eq!(info["replay"]["possible"], "yes");
    assert_eq!(info["skeleton"], Value::Null);
    assert_eq!(codes(&info, "blocking"), Vec::<&str>::new());
    assert_eq!(info["channels"].as_array().unwrap().len(), 21);
    let sonar = &info["sonars"][4];
    assert_eq!(sonar["name"], "sonar_04");
    assert_eq!(sonar["mount"]["yaw"], quarter_turn());
    assert_eq!(sonar["beam_width"], 0.392699093);
    assert_eq!(sonar["readings"], 179);
    assert_eq!(sonar["resolution"]["quantised"], false);
    assert_eq!(info["odometry"]["samples"], 1001);
    assert_eq!(info["odometry"]["readings_with_pose"], 2857);
    assert!((info["odometry"]["distance"].as_f64().unwrap() - 18.0).abs() < 0.1);

    bench.tmam(&log, "replay {} --features f");
    let features = bench.json("f");
    for count in [
        "frames",
        "echoes",
        "contact",
        "intersection",
        "unidentified",
    ] {
        assert_eq!(info["replay"]["counts"][count], features["counts"][count]);
    }
    let again = bench.tmam(&log, "info {} --json");
    let json = bench.tmam(&log, "info {} --json");
    assert_eq!(again.stdout, json.stdout);
}

#[test]
fn text_keeps_within_a_hundred_columns() {
    let bench = Bench::new();
    for log in ["room_drive.mcap", "room_step.mcap"] {
        let run = bench.tmam(&sample(log), "info {}");
        assert_eq!(run.code, 0, "{}", run.stderr);
        for line in run.stdout.lines() {
            assert!(line.chars().count() <= 100, "{line}");
            assert_eq!(line, line.trim_end());
        }
        for title in [
            "CHANNELS", "SONARS", "ECHOES", "ODOMETRY", "CLOCKS", "FINDINGS",
        ] {
            assert!(
                run.stdout.contains(&format!("\n{title}\n")),
                "{}",
                run.stdout
            );
        }
    }
}

#[test]
fn ranges_in_centimetres_have_a_raster() {
    let bytes = changed("room_drive.mcap", |mut message| {
        if message.topic.starts_with("/sonar") {
            // The last but one of the fields.
            let end = message.data.len() - 4;
            let range: &mut [u8; 4] = (&mut message.data[end - 4..end]).try_into().unwrap();
            let metres = f32::from_le_bytes(*range);
            *range = ((metres * 100.0).round() / 100.0).to_le_bytes();
        }
        vec![message]
    });
    let bench = Bench::new();
    let (info, code) = told(&bench, &put(&bench, bytes), "");
    assert_eq!(code, 0);
    let sonars = info["sonars"].as_array().unwrap().iter();
    let count = |sonar: &Value, key: &str| sonar[key].as_u64().unwrap();
    let mut sonars = sonars
        .filter(|sonar| count(sonar, "echoes") - count(sonar, "repeats") > 80)
        .peekable();
    assert!(sonars.peek().is_some());
    for sonar in sonars {
        assert_eq!(sonar["resolution"]["quantised"], true, "{sonar:#}");
        let step = sonar["resolution"]["step"].as_f64().unwrap();
        assert!((step - 0.01).abs() < 1e-5, "{step}");
    }
    assert!(codes(&info, "serious").contains(&"coarse-ranges"));
}

#[test]
fn channels_that_are_not_read_are_named_with_the_reason() {
    let bench = Bench::new();
    let log = put(&bench, untyped(&sample("room_step.mcap")));
    let (info, _) = told(&bench, &log, "");
    let channels = info["channels"].as_array().unwrap();
    assert!(
        channels
            .iter()
            .any(|channel| channel["problem"].is_string()),
        "{info:#}"
    );
    for channel in channels {
        let told = channel["used"] == true || channel["problem"].is_string();
        assert!(told || channel["role"].is_null(), "{channel:#}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_reason_to_fail() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_tmam"))
        .arg("info")
        .arg(sample("room_step.mcap"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(
        output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_survey_of_a_good_log_is_what_a_replay_reads() {
    use tmam_replay::core::config::Config;
    use tmam_replay::io::log::{read, survey::survey};
    let config = Config::default();
    for name in ["room_drive.mcap", "room_step.mcap"] {
        let surveyed = survey(&sample(name), &config).unwrap();
        assert!(surveyed.obstacles.is_empty());
        assert_eq!(surveyed.config, config);
        assert_eq!(surveyed.clocks.len(), surveyed.channels.len());
        assert_eq!(surveyed.log, read(&sample(name), &config).unwrap());
    }
}
