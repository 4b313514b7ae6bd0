//! Names that are damaged, or that would steer a terminal.

use std::cell::Cell;

use super::{changed, replay, says};
use crate::support::{Bench, Message};

/// The message with another character in the place of the last one of its header's frame.
fn garbled(mut message: Message) -> Message {
    let length = u32::from_le_bytes(message.data[12..16].try_into().unwrap()) as usize;
    message.data[16 + length - 2] = b'#';
    message
}

#[test]
fn a_frame_that_one_reading_names_costs_it_and_is_told() {
    let (ranges, poses) = (Cell::new(0), Cell::new(0));
    let bytes = changed(|message| {
        let is_first = |count: &Cell<u32>| count.replace(count.get() + 1) == 0;
        let damaged = (message.topic.ends_with("sonar_03") && is_first(&ranges))
            || (message.topic == "/odom" && is_first(&poses));
        vec![if damaged { garbled(message) } else { message }]
    });
    let bench = Bench::new();
    let said = [
        "1 message on /sonar/sonar_03 left out: its frame (`sonar_0#`)",
        "1 pose on /odom of `base_link` in `odo#`, unlike all others, left out",
    ];
    let run = replay(&bench, &bytes);
    says(&run, 3, &said);
    let path = bench.path("log.mcap");
    assert_eq!(bench.tmam(&path, "replay {} --strict").code, 2);
}

#[test]
fn a_reading_that_names_another_sonars_frame_renames_none() {
    let seen = Cell::new(0);
    let bytes = changed(|mut message| {
        if message.topic.ends_with("sonar_03") && seen.replace(seen.get() + 1) == 20 {
            message.data[16..24].copy_from_slice(b"sonar_04");
        }
        vec![message]
    });
    let bench = Bench::new();
    let said = "1 message on /sonar/sonar_03 left out: its frame (`sonar_04`)";
    says(&replay(&bench, &bytes), 3, &[said]);
    let features = bench.json("f")["features"].to_string();
    assert!(features.contains("\"sonar_04\"") && !features.contains("/sonar/"));
}

#[test]
fn a_name_does_not_steer_the_terminal() {
    let bytes = changed(|mut message| {
        if message.topic.ends_with("sonar_03") {
            message.data[16..20].copy_from_slice(b"\x1b[2J");
        }
        vec![message]
    });
    let bench = Bench::new();
    let path = bench.put("log.mcap", &bytes);
    let run = bench.tmam(&path, "replay {} --features f");
    says(&run, 3, &["sonar `\\u001b[2Jr_03`"]);
    assert!(!run.stderr.contains('\x1b'));
    let info = bench.tmam(&path, "info {}");
    assert!(info.stdout.contains("\\u001b[2J") && !info.stdout.contains('\x1b'));
}

#[test]
fn an_odometry_that_exchanges_the_names_of_its_frames_is_read_the_other_way_round() {
    let bytes = changed(|mut message| {
        if message.topic == "/odom" {
            // The frame and the one that moves in it, each with its length and zeros up to the next field.
            let names = b"\x0a\0\0\0base_link\0\0\0\x05\0\0\0odom\0\0\0\0";
            message.data[12..12 + names.len()].copy_from_slice(names);
        }
        (message.topic != "/tf")
            .then_some(message)
            .into_iter()
            .collect()
    });
    let bench = Bench::new();
    let run = replay(&bench, &bytes);
    says(&run, 0, &["names `odom` as what moves in `base_link`"]);
    let lines = bench.json("f")["map"]["lines"].clone();
    assert_eq!(lines.as_array().unwrap().len(), 6);
}
