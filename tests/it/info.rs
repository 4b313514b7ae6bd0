//! `tmam info`: what it tells of sample logs, hopeless logs and damaged ones, and that the
//! configuration it proposes is enough to replay them.

mod hopeless;
mod numbers;
mod skeletons;
mod sound;
mod whole;

use std::f64::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};

use crate::support::{Bench, Message, rewrite, sample};
use serde_json::Value;

/// What `--json` says, and the exit code.
fn told(bench: &Bench, log: &Path, arguments: &str) -> (Value, i32) {
    let run = bench.tmam(log, &format!("info {{}} --json --no-causes {arguments}"));
    assert_eq!(run.stderr, "");
    (serde_json::from_str(&run.stdout).unwrap(), run.code)
}

/// As files have it.
fn quarter_turn() -> f64 {
    (FRAC_PI_2 * 1e9).round() / 1e9
}

fn codes<'a>(info: &'a Value, weight: &str) -> Vec<&'a str> {
    let findings = info["findings"].as_array().unwrap();
    let of_weight = findings.iter().filter(|f| f["weight"] == weight);
    of_weight.map(|f| f["code"].as_str().unwrap()).collect()
}

fn put(bench: &Bench, bytes: Vec<u8>) -> PathBuf {
    bench.put("log.mcap", bytes)
}

fn changed(log: &str, change: impl Fn(Message) -> Vec<Message>) -> Vec<u8> {
    rewrite(&sample(log), mcap::WriteOptions::new(), change)
}
