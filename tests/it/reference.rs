//! Every row of the trace against an independent implementation of the paper's rule.
//!
//! `reference/room_drive.jsonl` holds what a second program, written from the specification alone
//! and in another language, gives for the first sixty frames of the driven sample log.

use crate::support::{Bench, sample};
use serde_json::Value;

fn rows(text: &str) -> Vec<Value> {
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn every_row_of_the_trace_is_what_the_rule_gives() {
    let expected = rows(include_str!("../reference/room_drive.jsonl"));
    let bench = Bench::new();
    let run = bench.tmam(
        &sample("room_drive.mcap"),
        "replay {} --rule paper --trace t",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    let found = bench.json_lines("t");
    assert!(expected.len() > 400 && found.len() > expected.len());
    for (expected, found) in expected.iter().zip(&found) {
        for same in [
            "frame",
            "sensor",
            "stamp_ns",
            "label",
            "reason",
            "contact_points",
            "intersection_points",
        ] {
            assert_eq!(expected[same], found[same], "{same}: {expected} {found}");
        }
        for close in ["x", "y", "yaw", "range", "theta_c", "theta_i"] {
            match (expected[close].as_f64(), found[close].as_f64()) {
                (Some(e), Some(f)) => assert!((e - f).abs() < 1e-6, "{close}: {expected} {found}"),
                (e, f) => assert_eq!(e, f, "{close}: {expected} {found}"),
            }
        }
    }
}
