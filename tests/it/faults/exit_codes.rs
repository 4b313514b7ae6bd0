//! Damaged logs through the binary: exit codes, what is said, and what is left behind.

use std::fs;

use mcap::WriteOptions;

use super::damage::Fault;
use crate::support::{Bench, rewrite, sample};

fn log() -> Vec<u8> {
    let options = WriteOptions::new().chunk_size(Some(20_000));
    rewrite(&sample("room_step.mcap"), options, |message| vec![message])
}

#[test]
fn damage_is_3_and_with_strict_2() {
    let bench = Bench::new();
    let whole = log();
    let middle = whole.len() / 2;
    let path = bench.put("log.mcap", &whole);
    assert_eq!(bench.tmam(&path, "replay {} --strict --features f").code, 0);
    fs::remove_file(bench.path("f")).unwrap();
    for fault in [
        Fault::Flip(middle, 3),
        Fault::Truncate(middle),
        Fault::ZeroTail(middle),
        Fault::Delete(middle..middle + 100),
        Fault::Insert(middle, vec![7; 33]),
        Fault::Truncate(whole.len() - 1),
    ] {
        let path = bench.put("log.mcap", fault.apply(&whole));
        let strict = bench.tmam(&path, "replay {} --strict --features f --trace t -o r");
        assert_eq!(strict.code, 2, "{fault:?}: {}", strict.stderr);
        assert!(strict.stderr.starts_with("error: log.mcap could not"));
        assert!(
            strict.stderr.contains("\n  - at byte "),
            "{}",
            strict.stderr
        );
        assert_eq!(bench.files().len(), 1, "{fault:?}");

        let run = bench.tmam(&path, "replay {} --features f");
        assert_eq!(run.code, 3, "{fault:?}: {}", run.stderr);
        let features = bench.json("f");
        assert_eq!(features["source"]["complete"], false);
        let lost = features["source"]["lost"].as_array().unwrap();
        for loss in lost {
            let loss = loss.as_str().unwrap();
            assert!(run.stderr.contains(loss), "{loss}");
        }
        fs::remove_file(bench.path("f")).unwrap();
    }
}

#[test]
fn a_lost_chunk_is_described() {
    let bench = Bench::new();
    let whole = log();
    let bytes = Fault::Flip(whole.len() / 2, 3).apply(&whole);
    let path = bench.put("log.mcap", bytes);
    let run = bench.tmam(&path, "replay {} --features f");
    for said in [
        ": a chunk with messages logged from ",
        " s after the first, ",
        " s by the clock, ",
        " messages lost: it",
    ] {
        assert!(run.stderr.contains(said), "no {said:?} in {}", run.stderr);
    }
}

#[test]
fn a_log_of_which_nothing_is_left_is_2() {
    let bench = Bench::new();
    let whole = log();
    for fault in [Fault::Truncate(8), Fault::Truncate(60), Fault::ZeroTail(40)] {
        let path = bench.put("log.mcap", fault.apply(&whole));
        let run = bench.tmam(&path, "replay {}");
        assert_eq!(run.code, 2, "{fault:?}: {}", run.stderr);
        let said = "nothing of log.mcap can be used: it is damaged. Lost:\n  - at";
        assert!(run.stderr.contains(said), "{}", run.stderr);
        assert_eq!(bench.files().len(), 1);
    }
}
