//! What is written takes the place of nothing else, and what cannot be written is no success.

use std::fs;

use super::{bench_with, path_of, tmam};
use crate::support::{Bench, sample};

#[test]
fn a_golden_file_of_a_rust_test_is_not_overwritten() {
    let bench = bench_with("rust/corridor", |_| {});
    let name = "golden/corridor.golden.json";
    let before = bench.bytes(name);
    fs::copy(sample("room_drive.mcap"), bench.path("corridor.mcap")).unwrap();
    let bless = ["check", "corridor.mcap", "--golden", "golden", "--bless"];
    for arguments in [&bless[..4], &bless] {
        let run = tmam(&bench, arguments, &[]);
        assert_eq!(run.code, 2, "{}", run.stdout);
        assert!(run.stdout.contains("of a Rust test"), "{}", run.stdout);
    }
    assert!(bench.bytes(name) == before);
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn a_report_takes_the_place_of_nothing_that_is_read_or_written() {
    let bench = bench_with("room_drive", |file| {
        file["map"]["points"][0]["x"] = 77.0.into()
    });
    let log = "room_drive.mcap";
    fs::copy(sample(log), bench.path(log)).unwrap();
    let golden = "golden/room_drive.golden.json";
    let before = [log, golden].map(|name| bench.bytes(name));
    for more in [
        ["--junit", log, "--summary", "s.md"],
        ["--junit", "j.xml", "--summary", "golden/../room_drive.mcap"],
        ["--junit", golden, "--summary", "s.md"],
        ["--junit", "same", "--summary", "./same"],
        ["--junit", "./out/room_drive.check.rrd", "--summary", "s.md"],
        [
            "--junit",
            "j.xml",
            "--summary",
            "out/room_drive.golden.json.new",
        ],
    ] {
        let mut all = vec!["check", log, "--golden", "golden", "--artifacts", "out"];
        all.extend(more);
        let run = tmam(&bench, &all, &[]);
        assert_eq!(run.code, 2, "{more:?}: {}", run.stdout);
        assert!(run.stderr.contains("named twice"), "{}", run.stderr);
        assert!(run.stdout.is_empty(), "nothing was begun: {}", run.stdout);
    }
    assert!([log, golden].map(|name| bench.bytes(name)) == before);
}

#[test]
fn machines_do_not_bless() {
    let bench = Bench::new();
    let log = path_of("room_drive.mcap");
    let bless = ["check", &log, "--golden", "golden", "--bless"];
    let run = tmam(&bench, &bless, &[("CI", "true")]);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("CI is set") && run.stderr.contains("--force"),
        "{}",
        run.stderr
    );
    assert!(!bench.path("golden").exists());
    let forced: Vec<&str> = bless.into_iter().chain(["--force"]).collect();
    assert_eq!(tmam(&bench, &forced, &[("CI", "true")]).code, 0);
    assert_eq!(tmam(&bench, &bless, &[("CI", "false")]).code, 0);
}

#[test]
fn where_nothing_can_be_written_nothing_is_begun() {
    let bench = bench_with("room_drive", |_| {});
    bench.put("a_file", b"");
    let log = path_of("room_drive.mcap");
    for arguments in [
        ["--artifacts", "a_file/out"],
        ["--junit", "a_file/dir.xml"],
        ["--summary", "golden"],
    ] {
        let mut all = vec!["check", &log, "--golden", "golden"];
        all.extend(arguments);
        let run = tmam(&bench, &all, &[]);
        assert_eq!(run.code, 2, "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.contains("cannot write"), "{}", run.stderr);
        assert!(run.stdout.is_empty());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_report_that_cannot_be_printed_is_no_success() {
    let bench = bench_with("room_step", |_| {});
    let log = path_of("room_step.mcap");
    for arguments in [
        vec!["check", &log, "--golden", "golden", "--json"],
        vec!["check", &log, "--golden", "golden"],
        vec!["diff", "golden/room_step.golden.json", &log],
    ] {
        let full = fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let status = std::process::Command::new(env!("CARGO_BIN_EXE_tmam"))
            .args(&arguments)
            .current_dir(bench.path(""))
            .stdout(full)
            .stderr(std::process::Stdio::null())
            .status()
            .unwrap();
        assert_eq!(status.code(), Some(2), "{arguments:?}");
    }
}
