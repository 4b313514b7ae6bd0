//! Clocks that were set or differ, and odometry that jumps.

use std::cell::Cell;

use super::{SECOND, changed, is_range, replay, says, told_once};
use crate::support::{Bench, Message};

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
        &["the odometry jumps once, at 10.0 s, by 4.98 m"],
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
fn a_single_damaged_stamp_is_no_clock_that_was_set() {
    for topic in ["/odom", "/sonar/sonar_03"] {
        for by in [-1_000_000, 1_000_000] {
            let seen = Cell::new(0);
            let bytes = changed(|mut message| {
                if message.topic == topic && seen.replace(seen.get() + 1) == 49 {
                    message.shift_stamp(by);
                }
                vec![message]
            });
            let run = replay(&Bench::new(), &bytes);
            says(
                &run,
                3,
                &["with a stamp more than an hour from all others left out"],
            );
            for word in ["was set", "jumps", "stamped earlier"] {
                assert!(!run.stderr.contains(word), "{word}: {}", run.stderr);
            }
        }
    }
}
