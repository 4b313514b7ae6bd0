//! Golden files: the project's samples are held by them, what should be caught is caught, and what
//! should not matter does not.

#[cfg(feature = "viewer")]
mod artefacts;
mod blessing;
mod diff;
mod harmless;
mod mutations;
mod names;
mod noise;
mod noise_aware_mutations;
mod overwriting;
mod pictures;
#[cfg(feature = "viewer")]
mod recordings;
mod refusals;
mod renamed;
mod reports;
mod rust;
mod samples;
mod suite;
mod usage;
mod verdicts;

use std::path::{Path, PathBuf};

use crate::support::{Bench, Run, sample};
use assert_cmd::Command;
use serde_json::Value;

/// Runs `tmam` as a person does, whatever the machine that runs the tests is.
fn tmam(bench: &Bench, arguments: &[&str], variables: &[(&str, &str)]) -> Run {
    let output = Command::cargo_bin("tmam")
        .unwrap()
        .args(arguments)
        .env_remove("CI")
        .env_remove("GITHUB_ACTIONS")
        .envs(variables.iter().copied())
        .current_dir(bench.path(""))
        .output()
        .unwrap();
    Run {
        code: output.status.code().expect("ended by itself"),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// What stands in the place of a file that was not fetched.
const LFS_POINTER: &str = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n";

/// Where the golden files of the samples are.
fn golden() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Checks a log, with its golden file in `golden` there; the report in JSON.
fn report(bench: &Bench, log: &Path) -> (i32, Value) {
    let log = log.to_str().unwrap();
    let run = tmam(bench, &["check", log, "--golden", "golden", "--json"], &[]);
    let json = serde_json::from_str(&run.stdout);
    (
        run.code,
        json.unwrap_or_else(|error| panic!("{error}: {} {}", run.stdout, run.stderr)),
    )
}

/// A directory with a copy of a sample's golden file, changed; `noise_aware/room_drive` is the one
/// under the noise-aware rule.
fn bench_with(sample: &str, change: impl FnOnce(&mut Value)) -> Bench {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("golden")).unwrap();
    let name = format!("{sample}.golden.json");
    let text = std::fs::read(golden().join(&name)).unwrap();
    let name = name.rsplit('/').next().unwrap();
    let mut file: Value = serde_json::from_slice(&text).unwrap();
    change(&mut file);
    bench.put(&format!("golden/{name}"), file.to_string());
    bench
}

fn path_of(log: &str) -> String {
    sample(log).to_str().unwrap().to_owned()
}
