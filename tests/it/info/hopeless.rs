//! Logs that no configuration mends: what lacks, clocks, damage, and silence.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{changed, codes, put, quarter_turn, told};
use crate::support::{Bench, rewrite, sample, without};

#[test]
fn what_no_configuration_can_mend_is_still_shown() {
    let bench = Bench::new();
    let sample_log = sample("room_step.mcap");
    let unmoved = rewrite(
        &sample_log,
        mcap::WriteOptions::new(),
        |message| match message.topic.as_str() {
            "/odom" | "/tf" => Vec::new(),
            _ => vec![message],
        },
    );
    let log = put(&bench, unmoved);
    let (info, code) = told(&bench, &log, "");
    assert_eq!((code, &info["replay"]["possible"]), (3, &Value::from("no")));
    assert_eq!(codes(&info, "blocking"), ["no-odometry"]);
    assert_eq!(info["odometry"], Value::Null);
    assert_eq!(info["sonars"][4]["mount"]["yaw"], quarter_turn());
    assert_eq!(info["sonars"].as_array().unwrap().len(), 16);

    let log = put(&bench, without(&sample("room_step.mcap"), &["/sonar"]));
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["no-ranges"]);
    assert_eq!(info["odometry"]["samples"], 150);
    assert_eq!(info["sonars"].as_array().unwrap().len(), 0);

    let log = put(&bench, without(&sample("room_step.mcap"), &["/"]));
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["no-ranges", "no-odometry"]);
    assert_eq!(bench.tmam(&log, "info {}").code, 3);
}

#[test]
fn clocks_that_do_not_meet_and_stamps_that_are_missing() {
    let bench = Bench::new();
    let shifted = changed("room_step.mcap", |mut message| {
        if message.topic == "/odom" {
            message.shift_stamp(3600);
        }
        vec![message]
    });
    let (info, code) = told(&bench, &put(&bench, shifted), "");
    assert_eq!((code, &info["replay"]["possible"]), (3, &Value::from("no")));
    assert_eq!(codes(&info, "blocking"), ["no-frames"]);
    assert!(codes(&info, "serious").contains(&"clock-skew"));

    let unstamped = changed("room_step.mcap", |mut message| {
        if message.topic.starts_with("/sonar") {
            message.data[4..12].fill(0);
        }
        vec![message]
    });
    let (info, code) = told(&bench, &put(&bench, unstamped), "");
    assert_eq!(code, 0);
    assert_eq!(codes(&info, "serious"), ["unstamped"]);
    assert_eq!(codes(&info, "notable"), Vec::<&str>::new());
}

#[test]
fn a_log_that_is_not_whole_or_not_a_log() {
    let whole = fs::read(sample("room_drive.mcap")).unwrap();
    let bench = Bench::new();
    let log = put(&bench, whole[..whole.len() * 2 / 3].to_vec());
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(info["source"]["complete"], false);
    assert_eq!(info["replay"]["possible"], "yes");
    assert!(codes(&info, "serious").contains(&"incomplete"));
    let run = bench.tmam(&log, "info {}");
    assert_eq!(run.code, 3);
    assert!(run.stdout.contains(", INCOMPLETE"), "{}", run.stdout);

    for (bytes, said) in [
        (b"no log".to_vec(), "not an MCAP file"),
        (Vec::new(), "is empty"),
    ] {
        let run = bench.tmam(&put(&bench, bytes), "info {}");
        assert_eq!((run.code, run.stdout.as_str()), (2, ""));
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
    assert_eq!(bench.tmam(Path::new("no.mcap"), "info {}").code, 2);
    assert_eq!(
        bench
            .tmam(&sample("room_step.mcap"), "info {} --alpha 7")
            .code,
        2
    );
}

#[test]
fn a_log_in_which_nothing_echoes() {
    let bench = Bench::new();
    bench.tmam(
        Path::new(""),
        "simulate -o far.mcap --max-range 0.3 --steps 20",
    );
    let (info, code) = told(&bench, &bench.path("far.mcap"), "");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["no-echo"]);
}
