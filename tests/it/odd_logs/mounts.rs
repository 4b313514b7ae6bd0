//! Transforms to the sonars that are none, that move, or that could not be read.

use super::{SECOND, changed, find, is_range, replay, says, told_once};
use crate::support::{Bench, Message};

#[test]
fn transforms_that_are_none_are_counted() {
    let bytes = changed(|mut message| {
        if message.topic == "/tf_static" {
            let rotation = message.data.len() - 32..;
            message.data[rotation].fill(0);
        }
        vec![message]
    });
    let bench = Bench::new();
    let run = replay(&bench, &bytes);
    says(
        &run,
        3,
        &[
            "sonar `sonar_15`, ",
            "the transform of `sonar_15` holds no pose",
            "give x, y and yaw under [sonar.\"sonar_15\"]",
        ],
    );
    let source = &bench.json("f")["source"];
    assert_eq!(source["complete"], false);
    assert!(source["lost"][0].as_str().unwrap().contains("sonar_15"));
    let notes = source["notes"].to_string();
    assert!(notes.contains("hold no pose"), "{notes}");
    bench.put("tmam.toml", "[sonar.sonar_15]\nx = 0\ny = 0\nyaw = 0\n");
    let path = bench.path("log.mcap");
    let run = bench.tmam(&path, "replay {} --features f --config tmam.toml");
    says(
        &run,
        0,
        &["transforms that hold no pose", "1, of `sonar_15`"],
    );
}

#[test]
fn mounts_that_move_are_told_once_for_all_sonars() {
    // What was fixed comes a second time on /tf alone, a little farther to the left.
    let bytes = changed(|mut message| {
        if message.topic != "/tf_static" {
            return vec![message];
        }
        message.topic = "/tf".into();
        let mut moved = Message {
            topic: "/tf".into(),
            log_time: message.log_time + SECOND,
            data: message.data.clone(),
            rank: 0,
        };
        let mut last = 4;
        while let Some(at) = find(&moved.data[last..], b"base_link\0") {
            last += at + 10;
            let child = (last - 4).next_multiple_of(4) + 4;
            let length = u32::from_le_bytes(moved.data[child..child + 4].try_into().unwrap());
            let x = (child + 4 + length as usize - 4).next_multiple_of(8) + 4;
            let old = f64::from_le_bytes(moved.data[x..x + 8].try_into().unwrap());
            moved.data[x..x + 8].copy_from_slice(&(old + 0.1).to_le_bytes());
        }
        vec![message, moved]
    });
    let run = replay(&Bench::new(), &bytes);
    let said =
        "the mounts of 16 sonars (`sonar_00`, `sonar_01`, `sonar_02` and 13 more) move on /tf";
    says(&run, 0, &[said]);
    told_once(&run, "move");
}

#[test]
fn what_was_noted_is_told_with_what_stops_a_replay() {
    let bytes = changed(|mut message| {
        if message.topic == "/tf_static" {
            let rotation = message.data.len() - 32..;
            // NaN
            message.data[rotation].fill(0xff);
        }
        if is_range(&message) && !message.topic.ends_with("sonar_15") {
            return Vec::new();
        }
        vec![message]
    });
    says(
        &replay(&Bench::new(), &bytes),
        2,
        &[
            "no mounting pose for sonar frame `sonar_15`",
            "Also:\n  - transforms that hold no pose",
        ],
    );
}

#[test]
fn messages_that_could_not_be_read_are_told_with_the_mounts_they_may_have_held() {
    let bytes = changed(|mut message| {
        if message.topic == "/tf_static" {
            message.data.truncate(message.data.len() - 9);
        }
        vec![message]
    });
    let words = [
        "no mounting pose for sonar frame `sonar_00`",
        "Also:\n  - 1 of 1 message on /tf_static: ",
    ];
    says(&replay(&Bench::new(), &bytes), 2, &words);
}

#[test]
fn quaternions_of_zero_of_all_mounts_are_no_turn_and_told_with_the_key_that_mends_them() {
    let bytes = changed(|mut message| {
        if message.topic == "/tf_static" {
            // Each transform ends in its quaternion, and the next one begins with its stamp.
            let mut last = 4;
            while let Some(at) = find(&message.data[last..], b"base_link\0") {
                last += at + 10;
                let child = (last - 4).next_multiple_of(4) + 4;
                let length = u32::from_le_bytes(message.data[child..child + 4].try_into().unwrap());
                let x = (child + 4 + length as usize - 4).next_multiple_of(8) + 4;
                message.data[x + 24..x + 56].fill(0);
            }
        }
        vec![message]
    });
    let said = [
        "the quaternions of the transforms of `sonar_00`, `sonar_01`, `sonar_02` and 13 more are zero",
        "for this log sonars.mounts = \"outward\" (tried: its map explains 100 % of the arcs",
    ];
    let run = replay(&Bench::new(), &bytes);
    says(&run, 0, &said);
    assert!(!run.stderr.contains("hold no pose"), "{}", run.stderr);
}

#[test]
fn two_publishers_of_one_mount_are_told_and_the_other_place_is_tried() {
    // What was said first comes again in turn with the same, half a radian farther round.
    let bytes = changed(|message| {
        if message.topic != "/tf_static" {
            return vec![message];
        }
        let said = |turn: u64| {
            let mut said = Message {
                topic: message.topic.clone(),
                log_time: message.log_time + turn * SECOND,
                data: message.data.clone(),
                rank: 0,
            };
            // The last transform ends in z and w of its quaternion.
            let z = said.data.len() - 16;
            let part = |at: usize| f64::from_le_bytes(said.data[at..at + 8].try_into().unwrap());
            let yaw = 2.0 * libm::atan2(part(z), part(z + 8)) + 0.5 * (turn % 2) as f64;
            said.data[z..z + 8].copy_from_slice(&libm::sin(yaw / 2.0).to_le_bytes());
            said.data[z + 8..].copy_from_slice(&libm::cos(yaw / 2.0).to_le_bytes());
            said
        };
        (0..4).map(said).collect()
    });
    let bench = Bench::new();
    let run = replay(&bench, &bytes);
    let said = [
        "transforms of `sonar_15` say two things, going from one to the other 3 times",
        "sonar.sonar_15.yaw = -22.5 (tried: ",
    ];
    says(&run, 0, &said);
    let cause = bench.json("f")["causes"][0]["settings"].to_string();
    assert!(cause.contains("sonar.sonar_15.yaw=-22.5"), "{cause}");
}

#[test]
fn what_a_configuration_says_of_nothing_is_told() {
    let bench = Bench::new();
    let flags = "replay {} --no-causes --features f --sensor sonar_00 --sensor nobody --set sonar.sonar_04.yaw=90 \
                 --range-topic /sonar/* --range-topic /us/*";
    let run = bench.tmam(&super::log(), flags);
    let said = [
        "the configuration describes sonar `sonar_04`, which --sensor (input.sonars) leaves out: it changes no arc",
        "input.sonars: `nobody` matches no sonar of the log",
        "input.range_topics: `/us/*` matches no topic of the log",
    ];
    says(&run, 0, &said);
}
