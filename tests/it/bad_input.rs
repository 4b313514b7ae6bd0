//! Bad input: a clear message that says what was found and what to do, the right exit code, and no
//! output file left behind.

mod damage;
mod logs;
mod usage;

use std::path::Path;

use crate::support::Bench;

/// Replays, and expects a refusal that says all of `said`.
fn refused(bench: &Bench, log: &Path, arguments: &str, code: i32, said: &[&str]) {
    let before = bench.files();
    let run = bench.tmam(log, arguments);
    assert_eq!(run.code, code, "{arguments}: {}", run.stderr);
    assert!(run.stdout.is_empty(), "{}", run.stdout);
    assert!(run.stderr.starts_with("error: "), "{}", run.stderr);
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    for words in said {
        assert!(
            run.stderr.contains(words),
            "no {words:?} in: {}",
            run.stderr
        );
    }
    assert_eq!(bench.files(), before, "{arguments}");
}

fn refuses(bytes: Vec<u8>, code: i32, said: &[&str]) {
    let bench = Bench::new();
    let log = bench.put("log.mcap", bytes);
    refused(&bench, &log, "replay {}", code, said);
}
