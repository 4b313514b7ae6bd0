//! Sound logs of many kinds, of which nothing serious is said, and logs with one thing wrong, of which it is said
//! with its number.

use serde_json::Value;

use super::{changed, put, told};
use crate::support::Bench;

/// A room with a wall and a post in it, and one that is long and narrow: the way through each. None turns by half a
/// circle from one stop to the next, as a heading that is reset does.
const ROOMS: [(&str, &str); 2] = [
    (
        r#"{"walls": [[0,0,6,0],[6,0,6,4],[6,4,0,4],[0,4,0,0],[2.5,1.8,3.5,1.8]], "points": [[1,3]]}"#,
        "1,1 5,1 5,3 2,3 1,1",
    ),
    (
        r#"{"walls": [[0,0,9,0],[9,0,9,2],[9,2,5,2],[5,2,5,4],[5,4,3,4],[3,4,3,2],[3,2,0,2],[0,2,0,0]]}"#,
        "1,1 8,1 8,0.8 4,0.8 4,3 4.2,3 4.2,0.8 1,0.8",
    ),
];

/// What is said of a sound log, simulated in one of the rooms or in the paper's: serious findings and causes.
fn said_of_sound(room: usize, options: &str) -> Vec<String> {
    let bench = Bench::new();
    let place = ROOMS.get(room).map(|(world, way)| {
        bench.put("world.json", world);
        format!("--world world.json --waypoints \"{way}\"")
    });
    let place = place.unwrap_or_default();
    let run = bench.sh(&format!("tmam simulate -o log.mcap {place} {options}"));
    assert_eq!(run.code, 0, "{options}: {}", run.stderr);
    let run = bench.sh("tmam info log.mcap --json");
    let info: Value = serde_json::from_str(&run.stdout).unwrap();
    let findings = info["findings"].as_array().unwrap().iter();
    // A sonar alone, or few, make few labels.
    let is_few = |code: &Value| code == "few-labels" || code == "too-far-apart";
    let serious = findings.filter(|found| found["weight"] != "notable" && !is_few(&found["code"]));
    let serious = serious.map(|found| found["what"].to_string());
    let causes = info["causes"].as_array().into_iter().flatten();
    let causes = causes.map(|cause| cause["text"].to_string());
    serious.chain(causes).collect()
}

#[test]
fn of_sound_logs_nothing_serious_is_said_and_no_cause() {
    for (room, options) in [
        (9, "--drive --sonars 16"),
        (9, "--drive --sonars 24 --noise 0.003"),
        (9, "--drive --sonars 1 --noise 0.003 --seed 2"),
        (9, "--sonars 4 --noise 0.01 --seed 3"),
        (9, "--sonars 8 --steps 60"),
        (9, "--sonars 16 --noise 0.01 --steps 120 --seed 7"),
        (0, "--drive --sonars 8 --noise 0.003 --seed 4"),
        (
            0,
            "--drive --sonars 12 --noise 0.01 --seed 5 --speed 0.4 --firing-interval 0.02",
        ),
        (0, "--sonars 16 --noise 0.003 --seed 6"),
        (0, "--sonars 2 --noise 0.005 --seed 8"),
        (1, "--drive --sonars 16 --noise 0.003 --seed 9"),
        (1, "--sonars 12 --noise 0.003 --seed 10"),
    ] {
        let said = said_of_sound(room, options);
        assert!(said.is_empty(), "{room}, {options}: {said:#?}");
    }
}

#[test]
#[ignore = "takes minutes: 250 logs"]
fn of_250_sound_logs_nothing_serious_is_said_and_no_cause() {
    let mut wrong = Vec::new();
    let mut seed = 0;
    for round in 0.. {
        for (motion, sonars) in [
            ("--drive", 16),
            ("", 16),
            ("--drive", 24),
            ("", 8),
            ("--drive", 12),
            ("", 4),
            ("--drive", 8),
            ("", 1),
            ("--drive --speed 0.4", 2),
            ("", 24),
        ] {
            seed += 1;
            if seed > 250 {
                println!("{} of 250: {wrong:#?}", wrong.len());
                assert!(wrong.is_empty());
                return;
            }
            // Without any, steps and walls at whole centimetres make ranges that come in steps, too.
            let noise = ["0.003", "0.01", "0.001", "0.005"][(seed + round) % 4];
            let options = format!("{motion} --sonars {sonars} --noise {noise} --seed {seed}");
            let said = said_of_sound(round % 3, &options);
            if !said.is_empty() {
                println!("{}, {options}: {said:#?}", round % 3);
                wrong.push((round % 3, options, said));
            }
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
