//! Damaged logs are used as far as they go.

use std::fs;

use crate::support::{Bench, rewrite, sample};

#[test]
fn a_log_that_breaks_off_is_used_as_far_as_it_goes() {
    let whole = fs::read(sample("room_drive.mcap")).unwrap();
    let bench = Bench::new();
    let log = bench.put("log.mcap", &whole[..whole.len() * 2 / 3]);
    let run = bench.tmam(&log, "replay {} --features f --trace t");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(
        run.stderr.contains("could not be read whole"),
        "{}",
        run.stderr
    );
    let features = bench.json("f");
    assert_eq!(features["source"]["complete"], false);
    assert!(features["counts"]["echoes"].as_u64().unwrap() > 100);
}

#[test]
fn a_chunk_with_a_flipped_bit_is_left_out_and_said_so() {
    let bench = Bench::new();
    let options = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(20_000));
    let mut bytes = rewrite(&sample("room_step.mcap"), options, |message| vec![message]);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    let log = bench.put("log.mcap", bytes);
    let run = bench.tmam(&log, "replay {} --features f");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(
        run.stderr.contains("a chunk with messages logged from"),
        "{}",
        run.stderr
    );
    assert_eq!(bench.json("f")["source"]["complete"], false);
}
