//! Logs with something odd about them, from outside: what is said of it and what is done.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing
)]

mod support;

use std::cell::Cell;
use std::path::{Path, PathBuf};

use support::{Bench, Message, Run, rewrite, sample};

const SECOND: u64 = 1_000_000_000;

fn log() -> PathBuf {
    sample("room_drive.mcap")
}

fn changed(change: impl Fn(Message) -> Vec<Message>) -> Vec<u8> {
    rewrite(&log(), mcap::WriteOptions::new(), change)
}

fn replay(bench: &Bench, bytes: &[u8]) -> Run {
    let path = bench.put("log.mcap", bytes);
    bench.tmam(&path, "replay {} --features f")
}

fn says(run: &Run, code: i32, words: &[&str]) {
    assert_eq!(run.code, code, "{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "no {word}: {}", run.stderr);
    }
}

fn is_range(message: &Message) -> bool {
    message.topic.starts_with("/sonar")
}

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
fn a_clock_that_was_set_is_told_by_replay_and_info() {
    let start = Cell::new(0);
    let bytes = changed(|mut message| {
        start.set(if start.get() == 0 {
            message.log_time
        } else {
            start.get()
        });
        if is_range(&message) && message.log_time > start.get() + 40 * SECOND {
            message.shift_stamp(3600);
        }
        vec![message]
    });
    let bench = Bench::new();
    let run = replay(&bench, &bytes);
    let said = "messages of 16 of 16 sonars was set while they were recorded: by +36";
    says(&run, 0, &[said, "readings have no pose and are dropped"]);
    let info = bench.tmam(&bench.path("log.mcap"), "info {} --json");
    assert!(info.stdout.contains("\"clock-jump\""), "{}", info.stdout);
}

#[test]
fn clocks_that_differ_are_told() {
    let bytes = changed(|mut message| {
        if is_range(&message) {
            message.shift_stamp(-2);
        }
        vec![message]
    });
    let run = replay(&Bench::new(), &bytes);
    says(&run, 0, &["ranges take 2.000 s and odometry 0.000 s"]);
}

#[test]
fn messages_that_come_twice_or_out_of_order_are_told_apart() {
    let twice = changed(|message| {
        let again = Message {
            data: message.data.clone(),
            topic: message.topic.clone(),
            ..message
        };
        if is_range(&message) {
            vec![message, again]
        } else {
            vec![message]
        }
    });
    let run = replay(&Bench::new(), &twice);
    says(
        &run,
        0,
        &["carry the stamp of another one of the same sonar"],
    );
    // What the log's own order of recording puts right is not worth a word.
    let disordered = changed(|message| {
        let rank = u8::from((message.log_time / SECOND).is_multiple_of(2));
        vec![Message { rank, ..message }]
    });
    let run = replay(&Bench::new(), &disordered);
    says(&run, 0, &[]);
    assert!(!run.stderr.contains("stamped earlier"), "{}", run.stderr);
}

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
fn the_transforms_that_move_the_robot_serve_where_nothing_else_does() {
    let bench = Bench::new();
    let path = bench.put("log.mcap", support::without(&log(), &["/odom"]));
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

#[test]
fn an_odometry_that_jumps_and_clocks_that_go_back_together_are_told() {
    let bench = Bench::new();
    let start = Cell::new(u64::MAX);
    let leap = changed(|mut message| {
        start.set(start.get().min(message.log_time));
        if message.topic == "/odom" && message.log_time > start.get() + 10 * SECOND {
            // Header, child frame, x.
            let frame = u32::from_le_bytes(message.data[12..16].try_into().unwrap()) as usize;
            let child = (16 + frame).next_multiple_of(4);
            let length = u32::from_le_bytes(message.data[child..child + 4].try_into().unwrap());
            let x = 4 + (child + 4 + length as usize - 4).next_multiple_of(8);
            let old = f64::from_le_bytes(message.data[x..x + 8].try_into().unwrap());
            message.data[x..x + 8].copy_from_slice(&(old + 5.0).to_le_bytes());
        }
        vec![message]
    });
    says(
        &replay(&bench, &leap),
        0,
        &["the odometry jumps once by more than 0.3 m and 3 m/s"],
    );
    let notes = bench.json("f")["source"]["notes"].to_string();
    assert!(notes.contains("the odometry jumps once"), "{notes}");

    start.set(u64::MAX);
    let back = changed(|mut message| {
        start.set(start.get().min(message.log_time));
        if message.log_time > start.get() + 10 * SECOND && !message.topic.starts_with("/tf") {
            message.shift_stamp(-4);
            message.log_time -= 4 * SECOND;
        }
        vec![message]
    });
    let run = replay(&bench, &back);
    let advice = "--end 6.0 replays what lies before these times, --start 10.0 what lies behind";
    says(
        &run,
        0,
        &[
            "the clock was set back while the log was recorded, once, by up to 3.9",
            advice,
        ],
    );
    told_once(&run, "--start");
    let path = bench.path("log.mcap");
    let info = bench.tmam(&path, "info {} --json").stdout;
    assert!(
        info.contains("\"clock-jump\"") && info.contains(advice),
        "{info}"
    );
    for code in ["odometry-jump", "backward-stamps", "out-of-order"] {
        assert!(!info.contains(code), "{code}: {info}");
    }
    // A jump that the clock does not explain is still one.
    let both = bench.tmam(&path, "replay {} --start 10.0 --features f");
    assert!(!both.stderr.contains("jumps"), "{}", both.stderr);
}

/// That one line of notes alone has a word.
fn told_once(run: &Run, word: &str) {
    let lines = run.stderr.lines().filter(|line| line.contains(word));
    assert_eq!(lines.count(), 1, "{word}: {}", run.stderr);
}

#[test]
fn stamps_set_back_alone_are_told_once_with_what_to_replay() {
    let start = Cell::new(u64::MAX);
    let back = changed(|mut message| {
        start.set(start.get().min(message.log_time));
        let is_late = message.log_time > start.get() + 50 * SECOND;
        if is_late && (is_range(&message) || message.topic == "/odom") {
            message.shift_stamp(-30);
        }
        vec![message]
    });
    let bench = Bench::new();
    let run = replay(&bench, &back);
    let said =
        "messages of 16 of 16 sonars and of the odometry was set while they were recorded: by -30.";
    says(&run, 0, &[said, "--end 20.", "--start 50."]);
    for word in ["jumps", "stamped earlier"] {
        assert!(!run.stderr.contains(word), "{word}: {}", run.stderr);
    }
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

fn find(data: &[u8], word: &[u8]) -> Option<usize> {
    data.windows(word.len()).position(|window| window == word)
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
fn damaged_names_of_the_transforms_that_move_the_robot_are_losses() {
    for (frame, other, named) in [
        (&b"odom\0"[..], &b"odo#\0"[..], "`base_link` in `odo#`"),
        (b"base_link\0", b"base_lin#\0", "`base_lin#` in `odom`"),
    ] {
        let bench = Bench::new();
        let run = replay(&bench, &renamed(500, 2, frame, other));
        says(
            &run,
            3,
            &["2 of 1001 transforms on /tf give the pose of", named],
        );
        let path = bench.path("log.mcap");
        assert_eq!(bench.tmam(&path, "replay {} --strict").code, 2);
        let info = bench.tmam(&path, "info {}");
        says(&info, 3, &[]);
        assert!(info.stdout.contains("INCOMPLETE"), "{}", info.stdout);
    }
}

#[test]
fn a_track_by_transforms_that_is_renamed_half_way_goes_on() {
    let bench = Bench::new();
    let run = replay(&bench, &renamed(500, 1000, b"odom\0", b"odo2\0"));
    says(
        &run,
        0,
        &["`base_link` in `odo2`", "all are taken for one track"],
    );
    let whole = bench.tmam(&log(), "replay {} --features g");
    assert_eq!(whole.code, 0);
    assert_eq!(bench.json("f")["counts"], bench.json("g")["counts"]);
    let arguments = "replay {} --features f --set input.world_frame='odo2'";
    let half = bench.tmam(&bench.path("log.mcap"), arguments);
    says(&half, 0, &["readings have no pose"]);
}

#[test]
fn what_was_noted_is_told_with_what_stops_a_replay() {
    let bytes = changed(|mut message| {
        if message.topic == "/tf_static" {
            let rotation = message.data.len() - 32..;
            message.data[rotation].fill(0);
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
fn more_readings_than_are_held_are_refused() {
    let bench = Bench::new();
    let arguments = "replay {} --features f --set input.max_readings=1000";
    let run = bench.tmam(&log(), arguments);
    let said = "more than 1000 readings and odometry samples";
    says(&run, 2, &[said, "raise input.max_readings"]);
    assert!(bench.files().is_empty());
    let info = bench.tmam(&log(), "info {} --set input.max_readings=1000");
    says(&info, 2, &[said]);
}

#[test]
fn an_unchunked_log_whose_checksum_fails_is_read_when_asked_for() {
    let options = mcap::WriteOptions::new().use_chunks(false);
    let mut bytes = rewrite(&log(), options, |message| vec![message]);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    let bench = Bench::new();
    says(
        &replay(&bench, &bytes),
        2,
        &["input.trust_unchecked = true"],
    );
    let path = bench.path("log.mcap");
    let run = bench.tmam(
        &path,
        "replay {} --features f --set input.trust_unchecked=true",
    );
    says(&run, 3, &["any of them may be damaged"]);
    assert_eq!(bench.json("f")["source"]["complete"], false);
    let arguments = "replay {} --strict --set input.trust_unchecked=true";
    assert_eq!(bench.tmam(&path, arguments).code, 2);
}

#[cfg(unix)]
#[test]
fn a_device_is_no_log() {
    let run = Bench::new().tmam(Path::new("/dev/null"), "replay {}");
    says(&run, 2, &["is a pipe or a device", "write it into a file"]);
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
fn odometry_of_which_no_message_holds_a_pose_is_told_as_that() {
    let bench = Bench::new();
    let bytes = changed(|mut message| {
        if message.topic == "/odom" {
            // Header, child frame, position, quaternion.
            let frame = u32::from_le_bytes(message.data[12..16].try_into().unwrap()) as usize;
            let child = (16 + frame).next_multiple_of(4);
            let length = u32::from_le_bytes(message.data[child..child + 4].try_into().unwrap());
            let x = 4 + (child + 4 + length as usize - 4).next_multiple_of(8);
            message.data[x + 24..x + 56].fill(0);
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
