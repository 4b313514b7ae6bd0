//! The sample logs are what the commands in their README make.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

fn sample_logs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("sample_logs")
}

#[test]
fn the_readme_commands_make_the_sample_logs_byte_for_byte() {
    let readme = fs::read_to_string(sample_logs().join("README.md")).unwrap();
    let commands: Vec<_> = readme
        .lines()
        .filter_map(|line| line.strip_prefix("tmam "))
        .collect();

    let fresh = tempfile::tempdir().unwrap();
    for command in commands {
        let mut tmam = Command::cargo_bin("tmam").unwrap();
        tmam.args(command.split_whitespace())
            .current_dir(&fresh)
            .assert()
            .success();
    }

    let kept = logs(&sample_logs());
    assert_eq!(
        kept,
        logs(fresh.path()),
        "a log without a command, or the reverse"
    );
    assert!(!kept.is_empty());
    for name in kept {
        let made = fs::read(fresh.path().join(&name)).unwrap();
        let expected = fs::read(sample_logs().join(&name)).unwrap();
        assert!(
            made == expected,
            "{name} differs from what its command makes"
        );
        assert!(expected.len() < 300_000, "{name} is no longer small");
    }
}

fn logs(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut logs: Vec<_> = names.filter(|name| name.ends_with(".mcap")).collect();
    logs.sort();
    logs
}

#[test]
fn standard_output_gets_the_same_log() {
    let mut tmam = Command::cargo_bin("tmam").unwrap();
    let run = tmam.args(["simulate", "-o", "-", "--noise", "0.003"]);
    let expected = fs::read(sample_logs().join("room_step.mcap")).unwrap();
    assert!(run.assert().success().get_output().stdout == expected);
}

#[test]
fn a_refused_simulation_exits_with_2_and_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    for (options, said) in [
        ("--noise -1", "0 or more"),
        ("--beam-width 181", "at most 180"),
        ("--drive --speed 0", "above 0"),
        ("--drive --steps 5", "cannot be used with"),
        ("--step 0.1 --waypoints 0,0", "at least 2"),
        ("--world missing.json --waypoints 0,0", "missing.json"),
        ("--sonars 1 --step 1e-9", "more than"),
        ("--step-interval 1e300", "2038"),
    ] {
        let mut tmam = Command::cargo_bin("tmam").unwrap();
        let run = tmam.args(["simulate", "-o", "out.mcap"]);
        let refused = run
            .args(options.split_whitespace())
            .current_dir(&directory)
            .assert()
            .code(2);
        let message = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(message.contains(said), "{options}: {message}");
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 0, "{options}");
    }
}
