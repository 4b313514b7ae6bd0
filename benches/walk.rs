//! A bare walk over logs: every record is read, unpacked and held to its checksum, and nothing is decoded.
//!
//! What a replay costs at the very least: `benches/yardstick.py` times it beside replays.

#![allow(
    clippy::unwrap_used,
    reason = "a benchmark that meets something unexpected should stop on the spot"
)]

use std::path::Path;

use tmam_replay::io::log::container::{Unchecked, walk};

fn main() {
    for log in std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with('-'))
    {
        let mut messages = 0_u64;
        let losses = walk(Path::new(&log), Unchecked::LeftOut, &mut |_, _| {
            messages += 1;
        });
        let losses = losses.unwrap();
        println!("{log}: {messages} messages, {} losses", losses.len());
    }
}
