//! Beam widths that lack or cannot be.

use std::cell::Cell;

use super::{changed, is_range, log, replay, says};
use crate::support::Bench;

/// Where the field of view of a Range message lies: behind a header and a byte.
fn field_of_view(data: &[u8]) -> std::ops::Range<usize> {
    let frame = u32::from_le_bytes(data[12..16].try_into().unwrap()) as usize;
    let radiation = 16 + frame;
    let start = 4 + (radiation + 1 - 4).next_multiple_of(4);
    start..start + 4
}

#[test]
fn readings_without_beam_width_take_that_of_the_others() {
    let count = Cell::new(0);
    let bytes = changed(|mut message| {
        if message.topic.ends_with("sonar_03") && count.replace(count.get() + 1) < 7 {
            let place = field_of_view(&message.data);
            message.data[place].fill(0);
        }
        vec![message]
    });
    let bench = Bench::new();
    let run = replay(&bench, &bytes);
    says(
        &run,
        0,
        &["7 readings of sonar `sonar_03` give no beam width; the 22.5 deg"],
    );
    let original = bench.put("whole.mcap", std::fs::read(log()).unwrap());
    assert_eq!(bench.tmam(&original, "replay {} --features g").code, 0);
    assert_eq!(bench.json("f")["features"], bench.json("g")["features"]);
}

#[test]
fn a_sonar_without_beam_width_is_left_out_while_others_have_one() {
    let bytes = changed(|mut message| {
        if message.topic.ends_with("sonar_03") {
            let place = field_of_view(&message.data);
            message.data[place].fill(0);
        }
        vec![message]
    });
    let bench = Bench::new();
    says(
        &replay(&bench, &bytes),
        3,
        &[
            "sonar `sonar_03`, ",
            "has no beam width",
            "[sonar.\"sonar_03\"]",
        ],
    );
    let path = bench.path("log.mcap");
    let info = bench.tmam(&path, "info {} --json");
    assert!(
        info.stdout.contains("\"possible\": \"in-part\""),
        "{}",
        info.stdout
    );
    let skeleton = bench.tmam(&path, "info {} --skeleton").stdout;
    bench.put("tmam.toml", skeleton);
    let run = bench.tmam(&path, "replay {} --features f --config tmam.toml");
    says(&run, 0, &[]);
    let all_dark = changed(|mut message| {
        if is_range(&message) {
            let place = field_of_view(&message.data);
            message.data[place].fill(0);
        }
        vec![message]
    });
    says(
        &replay(&Bench::new(), &all_dark),
        2,
        &["gives no beam width"],
    );
}

#[test]
fn a_field_of_view_in_degrees_is_told_and_overruled() {
    let bytes = changed(|mut message| {
        if is_range(&message) {
            let place = field_of_view(&message.data);
            message.data[place].copy_from_slice(&22.5_f32.to_le_bytes());
        }
        vec![message]
    });
    let bench = Bench::new();
    let run = replay(&bench, &bytes);
    let said = [
        "the beams of 16 sonars (`sonar_00`, `sonar_01`, `sonar_02` and 13 more) are 1289 deg wide",
        "(22.500 rad)",
        "sonars.beam_width = 22.5 (deg) in the configuration overrules it",
    ];
    says(&run, 0, &said);
    let path = bench.path("log.mcap");
    let run = bench.tmam(&path, "replay {} --features f --set sonars.beam_width=22.5");
    says(&run, 0, &[]);
    assert!(!run.stderr.contains("1289"), "{}", run.stderr);
    assert_eq!(bench.tmam(&log(), "replay {} --features g").code, 0);
    assert_eq!(bench.json("f")["counts"], bench.json("g")["counts"]);
    // One sonar's own key stands before a message that makes sense, too.
    let run = bench.tmam(
        &log(),
        "replay {} --trace t --set sonar.sonar_00.beam_width=40",
    );
    says(&run, 0, &[]);
    let info = bench.tmam(&log(), "info {} --json --set sonar.sonar_00.beam_width=40");
    assert!(
        info.stdout.contains("\"beam_width\": 0.698131701"),
        "{}",
        info.stdout
    );
}
