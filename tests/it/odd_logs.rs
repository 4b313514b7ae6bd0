//! Logs with something odd about them, from outside: what is said of it and what is done.

mod beams;
mod clocks;
mod limits;
mod mounts;
mod names;
mod odometry;

use std::path::PathBuf;

use crate::support::{Bench, Message, Run, rewrite, sample};

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

/// That one line of notes alone has a word.
fn told_once(run: &Run, word: &str) {
    let lines = run.stderr.lines().filter(|line| line.contains(word));
    assert_eq!(lines.count(), 1, "{word}: {}", run.stderr);
}

fn find(data: &[u8], word: &[u8]) -> Option<usize> {
    data.windows(word.len()).position(|window| window == word)
}
