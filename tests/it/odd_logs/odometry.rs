//! Odometry from transforms, and odometry that is none.

use std::cell::Cell;

use super::{changed, find, log, replay, says};
use crate::support::{Bench, Message};

#[test]
fn the_transforms_that_move_the_robot_serve_where_nothing_else_does() {
    let bench = Bench::new();
    let path = bench.put("log.mcap", crate::support::without(&log(), &["/odom"]));
    let said = "the transforms from `odom` to `base_link` on /tf are taken for it";
    says(&bench.tmam(&path, "replay {} --features f"), 0, &[said]);
    assert_eq!(bench.tmam(&log(), "replay {} --features g").code, 0);
    let map = |name: &str| bench.json(name)["counts"]["contact"].clone();
    assert_eq!(map("f"), map("g"));
    let info = bench.tmam(&path, "info {}");
    says(&info, 0, &[]);
    assert!(
        info.stdout.contains("ODOMETRY") && info.stdout.contains("/tf"),
        "{}",
        info.stdout
    );
}

/// The messages on /tf alone say where the robot was; from a share of them on, and for so many, they
/// name a frame otherwise, by a word as long.
fn renamed(from: u32, count: u32, frame: &[u8], other: &[u8]) -> Vec<u8> {
    let seen = Cell::new(0);
    changed(|mut message| match message.topic.as_str() {
        "/odom" => Vec::new(),
        "/tf" => {
            let place = seen.replace(seen.get() + 1);
            if (from..from + count).contains(&place) {
                let at = find(&message.data, frame).unwrap();
                message.data[at..at + other.len()].copy_from_slice(other);
            }
            vec![message]
        }
        _ => vec![message],
    })
}

#[test]
fn transforms_under_another_name_are_told_and_can_be_chosen() {
    let bench = Bench::new();
    let run = replay(&bench, &renamed(500, 1000, b"odom\0", b"odo2\0"));
    let said = [
        "in `odo2` by 501 transforms",
        "of them at times that the former lack",
    ];
    says(&run, 3, &said);
    let arguments = "replay {} --features f --set input.world_frame='odo2'";
    let half = bench.tmam(&bench.path("log.mcap"), arguments);
    says(&half, 0, &["readings have no pose"]);
}

/// Where the position of an odometry message lies: behind a header and the child's frame.
fn position(data: &[u8]) -> usize {
    let frame = u32::from_le_bytes(data[12..16].try_into().unwrap()) as usize;
    let child = (16 + frame).next_multiple_of(4);
    let length = u32::from_le_bytes(data[child..child + 4].try_into().unwrap());
    4 + (child + 4 + length as usize - 4).next_multiple_of(8)
}

#[test]
fn a_single_pose_far_from_all_others_is_left_out() {
    let seen = Cell::new(0);
    let bytes = changed(|mut message| {
        if message.topic == "/odom" && seen.replace(seen.get() + 1) == 50 {
            let x = position(&message.data);
            message.data[x..x + 8].copy_from_slice(&1e7_f64.to_le_bytes());
        }
        vec![message]
    });
    let run = replay(&Bench::new(), &bytes);
    says(
        &run,
        3,
        &["1 pose on /odom more than 1000 m from all others left out"],
    );
    assert!(!run.stderr.contains("jumps"), "{}", run.stderr);
}

#[test]
fn of_two_odometries_the_one_in_the_frame_that_is_asked_for_is_used() {
    let bytes = changed(|message| {
        if message.topic != "/odom" {
            return vec![message];
        }
        let mut other = Message {
            topic: "/odom2".into(),
            data: message.data.clone(),
            ..message
        };
        other.data[16..20].copy_from_slice(b"odo2");
        vec![message, other]
    });
    let bench = Bench::new();
    says(
        &replay(&bench, &bytes),
        2,
        &["more than one odometry topic"],
    );
    let path = bench.path("log.mcap");
    let run = bench.tmam(
        &path,
        "replay {} --features f --set input.world_frame='odom'",
    );
    says(&run, 0, &[]);
}

#[test]
fn odometry_of_which_no_message_holds_a_pose_is_told_as_that() {
    let bench = Bench::new();
    let bytes = changed(|mut message| {
        if message.topic == "/odom" {
            let x = position(&message.data);
            // NaN
            message.data[x + 24..x + 56].fill(0xff);
        }
        if message.topic == "/tf" {
            return Vec::new();
        }
        vec![message]
    });
    let said = "its messages hold no pose (NaN";
    says(&replay(&bench, &bytes), 2, &[said]);
    let info = bench.tmam(&bench.path("log.mcap"), "info {}").stdout;
    let info = info.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        info.contains("look at what publishes /odom: its messages hold no pose"),
        "{info}"
    );
}

#[test]
fn odometry_without_a_turn_is_told_with_the_key_that_makes_the_path_of_its_speeds() {
    let bytes = changed(|mut message| {
        if message.topic == "/odom" {
            let x = position(&message.data);
            message.data[x + 24..x + 56].fill(0);
        }
        vec![message]
    });
    let said = [
        "the quaternions of 1001 poses on /odom are zero",
        "no unit quaternion: it was never set, and is zero",
        "input.odometry_from_speeds = true (tried: ",
    ];
    says(&replay(&Bench::new(), &bytes), 0, &said);
}
