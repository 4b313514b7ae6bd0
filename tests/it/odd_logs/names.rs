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
fn a_damaged_name_costs_the_messages_that_have_it() {
    let (ranges, poses) = (Cell::new(0), Cell::new(0));
    let bytes = changed(|message| {
        let is_first = |count: &Cell<u32>| count.replace(count.get() + 1) == 0;
        let damaged = (message.topic.ends_with("sonar_03") && is_first(&ranges))
            || (message.topic == "/odom" && is_first(&poses));
        vec![if damaged { garbled(message) } else { message }]
    });
    let bench = Bench::new();
    let said = [
        "1 of 178 readings on /sonar/sonar_03 names the frame `sonar_0#`",
        "1 of 1001 messages on /odom gives the pose of `base_link` in `odo#`",
    ];
    let run = replay(&bench, &bytes);
    says(&run, 3, &said);
    let path = bench.path("log.mcap");
    says(&bench.tmam(&path, "replay {} --strict"), 2, &said);
    // Nobody needs a configuration for what is damaged.
    let info = bench.tmam(&path, "info {} --json");
    assert_eq!(info.code, 3, "{}", info.stderr);
    assert!(
        info.stdout.contains("\"possible\": \"yes\""),
        "{}",
        info.stdout
    );
    assert_eq!(bench.tmam(&path, "info {} --skeleton").stdout, "");
}

#[test]
fn a_damaged_name_that_is_another_sonars_costs_one_reading_and_renames_nothing() {
    let seen = Cell::new(0);
    let bytes = changed(|mut message| {
        if message.topic.ends_with("sonar_03") && seen.replace(seen.get() + 1) == 19 {
            let at = super::find(&message.data, b"sonar_03").unwrap();
            message.data[at..at + 8].copy_from_slice(b"sonar_04");
        }
        vec![message]
    });
    let bench = Bench::new();
    bench.put("tmam.toml", "[sonar.\"sonar_04\"]\nbeam_width = 20\n");
    let path = bench.put("log.mcap", &bytes);
    let run = bench.tmam(&path, "replay {} --features f --config tmam.toml");
    let said =
        "1 of 178 readings on /sonar/sonar_03 names the frame `sonar_04`, which is another topic's";
    says(&run, 3, &[said]);
    assert!(!run.stderr.contains("does not have"), "{}", run.stderr);
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
