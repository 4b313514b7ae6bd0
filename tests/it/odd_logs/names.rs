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
        "sonar `sonar_0#`, 1 reading: left out",
        "give the pose of `base_link` in `odom` and of `base_link` in `odo#`; all are taken",
    ];
    let run = replay(&bench, &bytes);
    says(&run, 3, &said);
    let path = bench.path("log.mcap");
    assert_eq!(bench.tmam(&path, "replay {} --strict").code, 2);
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
