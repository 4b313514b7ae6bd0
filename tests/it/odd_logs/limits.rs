//! More than is held, what no checksum covers, and what is no file.

use std::path::Path;

use super::{log, replay, says};
use crate::support::{Bench, rewrite};

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
