//! Sound logs of many kinds, of which nothing serious is said, and logs with one thing wrong, of which it is said
//! with its number.

use serde_json::Value;

use super::{changed, put, told};
use crate::support::Bench;

/// Ranges, and way-points of another room.
const WORLD: &str =
    r#"{"walls": [[0,0,6,0],[6,0,6,4],[6,4,0,4],[0,4,0,0],[2.5,1.8,3.5,1.8]], "points": [[1,3]]}"#;

#[test]
fn of_sound_logs_nothing_serious_is_said() {
    let bench = Bench::new();
    bench.put("world.json", WORLD);
    let room = "--world world.json --waypoints \"1,1 5,1 5,3 2,3 1,1\"";
    for options in [
        "--drive --sonars 16".to_owned(),
        "--drive --sonars 24 --noise 0.003 --laps 2".to_owned(),
        "--drive --sonars 1 --noise 0.003 --seed 2".to_owned(),
        "--sonars 4 --noise 0.01 --seed 3".to_owned(),
        "--sonars 8 --steps 60".to_owned(),
        format!("{room} --drive --sonars 8 --noise 0.003 --seed 4"),
        format!(
            "{room} --drive --sonars 12 --noise 0.01 --seed 5 --speed 0.4 --firing-interval 0.02"
        ),
        format!("{room} --sonars 16 --noise 0.003 --seed 6"),
    ] {
        let run = bench.sh(&format!("tmam simulate -o log.mcap {options}"));
        assert_eq!(run.code, 0, "{options}: {}", run.stderr);
        let (info, _) = told(&bench, &bench.path("log.mcap"), "");
        for finding in info["findings"].as_array().unwrap() {
            // A sonar alone, or few, make few labels.
            let is_few = finding["code"] == "few-labels" || finding["code"] == "too-far-apart";
            assert!(
                is_few || finding["weight"] == "notable",
                "{options}: {finding:#}"
            );
        }
    }
}

/// What a finding says of a log of which the messages were changed.
fn said(
    code: &str,
    change: impl Fn(crate::support::Message) -> Vec<crate::support::Message>,
) -> Value {
    let bench = Bench::new();
    let log = put(&bench, changed("room_drive.mcap", change));
    let (info, _) = told(&bench, &log, "");
    let findings = info["findings"].as_array().unwrap();
    let found = findings.iter().find(|finding| finding["code"] == code);
    found
        .cloned()
        .unwrap_or_else(|| panic!("{code}: {:#}", info["findings"]))
}

#[test]
fn a_clock_that_is_behind_is_told_with_the_number_that_mends_it() {
    let finding = said("clock-skew", |mut message| {
        if message.topic.starts_with("/sonar") {
            message.shift_stamp(-2);
        }
        vec![message]
    });
    let mend = finding["mend"].as_str().unwrap();
    assert!(
        mend.contains("input.range_delay = -2.000 (tried: "),
        "{mend}"
    );
    assert!(
        finding["what"]
            .as_str()
            .unwrap()
            .contains("ranges take 2.000 s and odometry 0.000 s")
    );
}

#[test]
fn stamps_in_whole_seconds_are_no_clock_that_is_behind() {
    let finding = said("coarse-stamps", |mut message| {
        if message.topic.starts_with("/sonar") {
            message.data[8..12].fill(0);
        }
        vec![message]
    });
    let mend = finding["mend"].as_str().unwrap();
    assert!(
        mend.contains("input.range_stamps = \"recording\" (tried: "),
        "{mend}"
    );
    assert!(
        finding["what"]
            .as_str()
            .unwrap()
            .contains("whole steps of 1 s")
    );
}

#[test]
fn zeros_for_no_echo_are_told_with_the_key_that_mends_them() {
    let finding = said("stand-in", |mut message| {
        if message.topic.starts_with("/sonar") {
            // Of the last five fields the second, third and fourth are min_range, max_range and range.
            let end = message.data.len();
            let range = f32::from_le_bytes(message.data[end - 8..end - 4].try_into().unwrap());
            message.data[end - 16..end - 12].copy_from_slice(&0_f32.to_le_bytes());
            if !range.is_finite() || range >= 4.0 {
                message.data[end - 8..end - 4].copy_from_slice(&0_f32.to_le_bytes());
            }
        }
        vec![message]
    });
    let mend = finding["mend"].as_str().unwrap();
    assert!(mend.contains("sonars.min_range = 0.01 (tried: "), "{mend}");
}

#[test]
fn a_folder_of_parts_is_one_log() {
    let bench = Bench::new();
    let log = crate::support::sample("room_drive.mcap");
    std::fs::create_dir(bench.path("bag")).unwrap();
    let middle = std::cell::Cell::new(0);
    let part = |first: bool| {
        changed("room_drive.mcap", |message| {
            if middle.get() == 0 {
                middle.set(message.log_time + 50_000_000_000);
            }
            let is_in = (message.log_time < middle.get()) == first;
            is_in.then_some(message).into_iter().collect()
        })
    };
    bench.put("bag/bag_0.mcap", part(true));
    bench.put("bag/bag_1.mcap", part(false));
    let whole = bench.tmam(&log, "replay {} --trace whole");
    let parts = bench.tmam(&bench.path("bag"), "replay {} --trace parts");
    assert_eq!((whole.code, parts.code), (0, 0), "{}", parts.stderr);
    assert_eq!(bench.bytes("whole"), bench.bytes("parts"));
}
