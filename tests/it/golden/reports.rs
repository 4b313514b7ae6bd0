//! What other programs read, and what blessing and comparing say.

use std::fs;

use super::{bench_with, golden, path_of, tmam};
use crate::support::Bench;

/// A line of the map that has moved, one that nobody expected, and labels.
pub fn differing() -> Bench {
    bench_with("room_drive", |file| {
        file["config"]["triple"]["gamma"] = 0.15.into()
    })
}

#[test]
fn junit_is_read_by_an_xml_reader_and_adds_up() {
    let bench = differing();
    fs::copy(
        golden().join("room_step.golden.json"),
        bench.path("golden/room_step.golden.json"),
    )
    .unwrap();
    let (drive, step) = (path_of("room_drive.mcap"), path_of("room_step.mcap"));
    let arguments = [
        "check",
        &drive,
        &step,
        "nowhere.mcap",
        "--golden",
        "golden",
        "--junit",
        "j.xml",
    ];
    assert_eq!(tmam(&bench, &arguments, &[]).code, 2);
    let text = String::from_utf8(bench.bytes("j.xml")).unwrap();
    let xml = roxmltree::Document::parse(&text).unwrap();
    let suites: Vec<_> = xml
        .descendants()
        .filter(|node| node.has_tag_name("testsuite"))
        .collect();
    assert_eq!(suites.len(), 3, "one per log");
    for suite in &suites {
        let children = |name: &str| {
            suite
                .descendants()
                .filter(|node| node.has_tag_name(name))
                .count()
        };
        for (attribute, name) in [
            ("tests", "testcase"),
            ("failures", "failure"),
            ("errors", "error"),
        ] {
            assert_eq!(
                suite.attribute(attribute).unwrap(),
                children(name).to_string()
            );
        }
        let name = suite.attribute("name").unwrap();
        let (failures, errors) = (children("failure"), children("error"));
        match name {
            _ if name.ends_with("room_step.mcap") => assert_eq!((failures, errors), (0, 0)),
            _ if name.ends_with("nowhere.mcap") => assert_eq!((failures, errors), (0, 1)),
            _ => assert!(failures >= 2 && errors == 0, "{name}"),
        }
    }
    let cases: Vec<_> = suites[1]
        .children()
        .filter_map(|node| node.attribute("name"))
        .collect();
    let kinds = [
        "requirements",
        "cause",
        "range noise",
        "findings",
        "map",
        "extracted features",
        "labels",
    ];
    assert!(
        [&suites[0], &suites[1], &suites[2]]
            .iter()
            .any(|_| cases == kinds),
        "{cases:?}"
    );
    assert!(text.contains("tolerance"), "the differences are in it");
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn a_summary_has_a_verdict_for_each_log_and_what_differs() {
    let bench = differing();
    let log = path_of("room_drive.mcap");
    let arguments = [
        "check",
        &log,
        "--golden",
        "golden",
        "--summary",
        "s.md",
        "--artifacts",
        "out",
    ];
    assert_eq!(tmam(&bench, &arguments, &[]).code, 1);
    let text = String::from_utf8(bench.bytes("s.md")).unwrap();
    for said in [
        "| **differs** |",
        "tolerance",
        "room_drive.check.rrd",
        "#",
        "labels: contact",
    ] {
        assert!(text.contains(said), "no {said} in {text}");
    }
    assert_eq!(text.matches("```").count() % 2, 0, "every block is closed");
}

#[test]
fn annotations_are_for_github_alone_and_leave_json_alone() {
    let bench = differing();
    let log = path_of("room_drive.mcap");
    let check = ["check", &log, "--golden", "golden"];
    let plain = tmam(&bench, &check, &[]);
    assert!(!plain.stdout.contains("::error"));
    let github = tmam(&bench, &check, &[("GITHUB_ACTIONS", "true")]);
    assert!(
        github
            .stdout
            .contains("::error file=golden/room_drive.golden.json,line="),
        "{}",
        github.stdout
    );
    let json: Vec<&str> = check.into_iter().chain(["--json"]).collect();
    let github = tmam(&bench, &json, &[("GITHUB_ACTIONS", "true")]);
    let said: serde_json::Value = serde_json::from_str(&github.stdout).unwrap();
    assert_eq!(
        (&said["schema"], &said["exit_code"]),
        (&"tmam.check/1".into(), &1.into())
    );
    assert!(github.stderr.contains("::error"));
}

#[test]
fn golden_files_without_a_log_are_named_in_every_report_by_the_first_part() {
    let bench = bench_with("room_drive", |_| {});
    for name in ["room_step", "forgotten"] {
        let copy = format!("golden/{name}.golden.json");
        fs::copy(golden().join("room_step.golden.json"), bench.path(&copy)).unwrap();
    }
    let (drive, step) = (path_of("room_drive.mcap"), path_of("room_step.mcap"));
    let note = "no log was given for golden/forgotten.golden.json";
    for (part, tells) in [("1/1", true), ("1/2", true), ("2/2", false)] {
        let check = [
            "check",
            &drive,
            &step,
            "--golden",
            "golden",
            "--partition",
            part,
            "--junit",
            "j.xml",
            "--summary",
            "s.md",
        ];
        let run = tmam(&bench, &check, &[]);
        assert_eq!(run.code, 0, "{}", run.stdout);
        assert_eq!(run.stdout.contains(note), tells, "{part}: {}", run.stdout);
        for file in ["j.xml", "s.md"] {
            let text = String::from_utf8(bench.bytes(file)).unwrap();
            assert_eq!(text.contains(note), tells, "{part}, {file}: {text}");
        }
        let json: Vec<&str> = check.into_iter().chain(["--json"]).collect();
        let said: serde_json::Value =
            serde_json::from_str(&tmam(&bench, &json, &[]).stdout).unwrap();
        assert_eq!(said["notes"].to_string().contains(note), tells, "{part}");
    }
}

#[test]
fn diff_compares_feature_files_golden_files_and_configurations() {
    let bench = Bench::new();
    let log = path_of("room_drive.mcap");
    for (name, gamma) in [("a", "10"), ("b", "10"), ("c", "8")] {
        let features = format!("{name}.json");
        let arguments = [
            "replay",
            &log,
            "--rule",
            "paper",
            "--features",
            &features,
            "--gamma",
            gamma,
        ];
        assert_eq!(tmam(&bench, &arguments, &[]).code, 0);
    }
    let golden = golden().join("room_drive.golden.json");
    let golden = golden.to_str().unwrap();
    for (arguments, code) in [
        (vec!["a.json", "b.json"], 0),
        (vec!["a.json", "c.json"], 1),
        (vec![golden, "a.json"], 0),
        (vec![golden, log.as_str(), "--rule", "paper"], 0),
        (vec![golden, "c.json"], 1),
        (
            vec![log.as_str(), "--rule", "paper", "--set-b", "triple.gamma=8"],
            1,
        ),
        (
            vec![
                log.as_str(),
                "--rule",
                "paper",
                "--set-b",
                "triple.gamma=10",
            ],
            0,
        ),
        (
            vec![log.as_str(), "c.json", "--rule", "paper", "--gamma", "8"],
            0,
        ),
        (vec![log.as_str()], 2),
        (vec!["nowhere.json", "a.json"], 2),
    ] {
        let mut all = vec!["diff"];
        all.extend(&arguments);
        let run = tmam(&bench, &all, &[]);
        assert_eq!(
            run.code, code,
            "{arguments:?}: {}{}",
            run.stdout, run.stderr
        );
    }
}
