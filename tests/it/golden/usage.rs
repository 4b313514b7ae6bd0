//! What is wrong with the command line is said where somebody, or some program, looks.

use std::fs;

use serde_json::Value;

use super::{bench_with, golden, path_of, tmam};
use crate::support::{Bench, sample};

#[test]
fn what_is_wrong_with_a_value_stands_in_every_report() {
    let bench = bench_with("room_drive", |_| {});
    bench.put("suite.toml", "[require.room_drvie]\nwalls = '>= 6'\n");
    bench.put("pointer", super::LFS_POINTER);
    let log = path_of("room_drive.mcap");
    for (more, said) in [
        (["--partition", "3/2"], "`3/2` is no part of a suite"),
        (["--gamma", "8"], "--bless"),
        (["--config", "nowhere.toml"], "cannot read nowhere.toml"),
        (
            ["--suite", "suite.toml"],
            "[require.room_drvie] asks something of a log",
        ),
        (
            ["--suite", "pointer"],
            "cannot read pointer: it is what Git LFS",
        ),
        (
            ["--config", "pointer"],
            "cannot read pointer: it is what Git LFS",
        ),
    ] {
        let check = ["check", &log, "--golden", "golden", "--json"];
        let files = ["--junit", "j.xml", "--summary", "s.md"];
        let run = tmam(&bench, &[&check[..], &files, &more].concat(), &[]);
        assert_eq!(run.code, 2, "{more:?}: {}", run.stdout);
        assert!(run.stderr.contains(said), "{}", run.stderr);
        let json: Value = serde_json::from_str(&run.stdout).unwrap();
        assert_eq!(
            (&json["exit_code"], &json["logs"]),
            (&2.into(), &Value::Array(vec![]))
        );
        assert!(json["reason"].as_str().unwrap().contains(said), "{json:#}");
        for name in ["j.xml", "s.md"] {
            let text = String::from_utf8(bench.bytes(name)).unwrap();
            assert!(text.contains(said), "{name}: {text}");
            fs::remove_file(bench.path(name)).unwrap();
        }
    }
}

#[test]
fn a_run_that_judges_nothing_is_annotated() {
    let bench = bench_with("room_drive", |_| {});
    let log = path_of("room_drive.mcap");
    for (more, code, said) in [
        (["--partition", "3/2"], 2, "`3/2` is no part of a suite"),
        (["--junit", &log], 2, "room_drive.mcap"),
        (["--partition", "2/2"], 3, "no log falls into this part"),
    ] {
        let check = ["check", &log, "--golden", "golden"];
        let arguments = [&check[..], &more].concat();
        let run = tmam(&bench, &arguments, &[("GITHUB_ACTIONS", "true")]);
        assert_eq!(run.code, code, "{more:?}: {}{}", run.stdout, run.stderr);
        let all = format!("{}{}", run.stdout, run.stderr);
        let errors: Vec<_> = all
            .lines()
            .filter(|line| line.starts_with("::error"))
            .collect();
        assert_eq!(errors.len(), 1, "{all}");
        assert!(errors[0].contains(said), "{all}");
        let run = tmam(&bench, &arguments, &[]);
        assert!(!run.stderr.contains("::error"), "{}", run.stderr);
    }
}

#[test]
fn a_report_on_standard_output_stands_alone() {
    let bench = bench_with("room_step", |_| {});
    let log = path_of("room_step.mcap");
    let check = ["check", &log, "--golden", "golden"];
    let junit = [&check[..], &["--junit", "-"]].concat();
    let run = tmam(&bench, &junit, &[("GITHUB_ACTIONS", "true")]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        roxmltree::Document::parse(&run.stdout).is_ok(),
        "{}",
        run.stdout
    );
    assert!(run.stderr.contains("1 log: 1 ok"), "{}", run.stderr);
    for more in [["--junit", "-", "--json"], ["--summary", "-", "--json"]] {
        let run = tmam(&bench, &[&check[..], &more].concat(), &[]);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{more:?}");
        assert!(
            run.stderr.contains("standard output is named twice"),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn one_log_given_twice_is_said_to_be() {
    let bench = bench_with("room_step", |_| {});
    fs::copy(sample("room_step.mcap"), bench.path("room_step.mcap")).unwrap();
    let check = [
        "check",
        "room_step.mcap",
        "./room_step.mcap",
        "--golden",
        "golden",
    ];
    let run = tmam(&bench, &check, &[]);
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert!(
        run.stderr.contains("./room_step.mcap is given twice"),
        "{}",
        run.stderr
    );
}

#[test]
fn what_says_no_is_not_set() {
    let log = path_of("room_step.mcap");
    for (value, code) in [("False", 0), ("0", 0), ("", 0), ("True", 2)] {
        let bench = Bench::new();
        let bless = ["check", &log, "--golden", "golden", "--bless"];
        let run = tmam(&bench, &bless, &[("CI", value)]);
        assert_eq!(run.code, code, "CI={value}: {}{}", run.stdout, run.stderr);
    }
}

#[test]
fn a_golden_file_without_a_log_is_skipped_and_warned_of() {
    let bench = bench_with("room_step", |_| {});
    let forgotten = "golden/room_drive.golden.json";
    fs::copy(
        golden().join("room_drive.golden.json"),
        bench.path(forgotten),
    )
    .unwrap();
    let log = path_of("room_step.mcap");
    let check = ["check", &log, "--golden", "golden", "--junit", "j.xml"];
    let run = tmam(&bench, &check, &[("GITHUB_ACTIONS", "true")]);
    assert_eq!(run.code, 0, "{}", run.stdout);
    let warning = format!("::warning title=tmam check::no log was given for {forgotten}\n");
    assert!(run.stdout.contains(&warning), "{}", run.stdout);
    let text = String::from_utf8(bench.bytes("j.xml")).unwrap();
    let xml = roxmltree::Document::parse(&text).unwrap();
    let skipped: Vec<_> = xml
        .descendants()
        .filter(|node| node.has_tag_name("skipped"))
        .collect();
    assert_eq!(skipped.len(), 1, "{text}");
    assert!(
        skipped[0].attribute("message").unwrap().contains(forgotten),
        "{text}"
    );
    let suite = skipped[0].parent().and_then(|case| case.parent()).unwrap();
    assert_eq!(suite.attribute("skipped"), Some("1"));
}

#[test]
fn an_error_is_a_paragraph_whatever_a_file_is_called() {
    let bench = bench_with("room_step", |_| {});
    let name = "no\nlog\n::error::.mcap";
    for arguments in [
        &["info", name][..],
        &["replay", name],
        &["diff", name, "golden/room_step.golden.json"],
        &["check", name, name, "--golden", "golden"],
        &["check", name, "--golden", "golden", "--junit", name],
    ] {
        bench.put(name, "hello");
        let run = tmam(&bench, arguments, &[]);
        assert_eq!(run.code, 2, "{arguments:?}: {}", run.stdout);
        assert_eq!(
            run.stderr.lines().count(),
            1,
            "{arguments:?}: {}",
            run.stderr
        );
        assert!(
            run.stderr.contains("no\\nlog"),
            "{arguments:?}: {}",
            run.stderr
        );
    }
}
