//! What is kept of a log that differs, or that nobody has blessed.

use std::fs;

use super::reports::differing;
use super::{bench_with, path_of, tmam};
use crate::support::{sample, without};

#[test]
fn a_log_that_differs_leaves_a_recording_and_what_would_make_it_pass() {
    let bench = differing();
    let log = path_of("room_drive.mcap");
    let check = ["check", &log, "--golden", "golden", "--artifacts", "out"];
    let run = tmam(&bench, &check, &[]);
    assert_eq!(run.code, 1);
    assert!(
        run.stdout.contains(" of out/room_drive.check.rrd"),
        "{}",
        run.stdout
    );
    let whole = bench.bytes("out/room_drive.check.rrd");
    assert!(
        tmam(&bench, &check, &[]).code == 1 && bench.bytes("out/room_drive.check.rrd") == whole
    );

    let around: Vec<&str> = check
        .into_iter()
        .chain(["--only-around-differences=2"])
        .collect();
    assert_eq!(tmam(&bench, &around, &[]).code, 1);
    let part = bench.bytes("out/room_drive.check.rrd");
    assert!(
        part.len() * 4 < whole.len() * 3,
        "{} of {}",
        part.len(),
        whole.len()
    );

    // The new golden file passes, and then nothing is left of the failure.
    fs::copy(
        bench.path("out/room_drive.golden.json.new"),
        bench.path("golden/room_drive.golden.json"),
    )
    .unwrap();
    assert_eq!(tmam(&bench, &check, &[]).code, 0);
    assert_eq!(fs::read_dir(bench.path("out")).unwrap().count(), 0);
}

#[test]
fn a_log_that_nobody_has_blessed_leaves_what_would_be_blessed() {
    let bench = bench_with("room_drive", |_| {});
    let log = path_of("room_step.mcap");
    let check = ["check", &log, "--golden", "golden", "--artifacts", "a/b"];
    let run = tmam(&bench, &check, &[]);
    assert_eq!(run.code, 3, "{}", run.stdout);
    assert!(
        run.stdout.contains("wrote a/b/room_step.golden.json.new"),
        "{}",
        run.stdout
    );
    let new = bench.path("golden/room_step.golden.json");
    fs::copy(bench.path("a/b/room_step.golden.json.new"), new).unwrap();
    assert_eq!(tmam(&bench, &check, &[]).code, 0);
}

#[test]
fn a_log_that_nobody_has_blessed_is_nothing_to_judge_with_and_without_artefacts() {
    let bench = bench_with("room_drive", |_| {});
    let log = sample("room_step.mcap");
    bench.put("bare.mcap", without(&log, &["/tf_static"]));
    bench.put("mute.mcap", without(&log, &["/sonar"]));
    bench.put("no_log.mcap", b"hello");
    for (log, code, note) in [
        ("bare.mcap", 3, true),
        ("mute.mcap", 3, true),
        (path_of("room_step.mcap").as_str(), 3, false),
        ("no_log.mcap", 2, false),
    ] {
        let check = ["check", log, "--golden", "golden"];
        for more in [&[][..], &["--artifacts", "out"]] {
            let run = tmam(&bench, &[&check[..], more].concat(), &[]);
            assert_eq!(run.code, code, "{log} {more:?}: {}", run.stdout);
            let said = run.stdout.contains("there is no golden file");
            assert_eq!(said, code == 3, "{}", run.stdout);
            let said = run.stdout.contains("note: the default configuration");
            assert_eq!(said, note, "{log} {more:?}: {}", run.stdout);
        }
    }
}

#[test]
fn what_differs_is_told_where_artefacts_cannot_be_written() {
    let bench = differing();
    fs::create_dir_all(bench.path("out/room_drive.check.rrd/in_the_way")).unwrap();
    let log = path_of("room_drive.mcap");
    let check = [
        "check",
        &log,
        "--golden",
        "golden",
        "--artifacts",
        "out",
        "--junit",
        "j.xml",
    ];
    let run = tmam(&bench, &check, &[("GITHUB_ACTIONS", "true")]);
    assert_eq!(run.code, 2, "{}", run.stdout);
    let annotations = || {
        run.stdout
            .lines()
            .filter(|line| line.starts_with("::error"))
    };
    assert!(annotations().any(|line| line.contains("cannot write")));
    assert!(annotations().any(|line| line.contains("tolerance")));
    let text = String::from_utf8(bench.bytes("j.xml")).unwrap();
    let xml = roxmltree::Document::parse(&text).unwrap();
    let count = |name: &str| {
        let all = xml.descendants();
        all.filter(|node| node.has_tag_name(name)).count()
    };
    assert_eq!(count("error"), 1, "{text}");
    assert!(count("failure") > 1, "{text}");
}

#[test]
fn what_an_earlier_run_left_goes_first() {
    let bench = differing();
    let log = path_of("room_drive.mcap");
    let check = ["check", &log, "--golden", "golden", "--artifacts", "out"];
    let run = tmam(&bench, &check, &[]);
    assert!(run.stdout.contains("1 log: 1 differs\n"), "{}", run.stdout);
    assert_eq!(fs::read_dir(bench.path("out")).unwrap().count(), 3);
    bench.put("golden/room_drive.golden.json", b"{");
    assert_eq!(tmam(&bench, &check, &[]).code, 2);
    assert_eq!(fs::read_dir(bench.path("out")).unwrap().count(), 0);
}
