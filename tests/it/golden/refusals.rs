//! What cannot be judged is never called good, and says what to do.

use std::fs;

use super::{bench_with, path_of, tmam};
use crate::support::{Bench, sample, without};

fn said(bench: &Bench, log: &str) -> (i32, String) {
    let run = tmam(bench, &["check", log, "--golden", "golden"], &[]);
    (run.code, run.stdout + &run.stderr)
}

#[test]
fn logs_that_are_not_whole_or_say_nothing_are_not_judged_and_not_blessed() {
    let whole = fs::read(sample("room_drive.mcap")).unwrap();
    let mut zeros = whole.clone();
    zeros[whole.len() / 2..].fill(0);
    for (what, bytes, code, words) in [
        (
            "cut in half",
            whole[..whole.len() / 2].to_vec(),
            3,
            "could not be read whole",
        ),
        ("half of it zeros", zeros, 3, "could not be read whole"),
        (
            "without its ranges",
            without(&sample("room_drive.mcap"), &["/sonar"]),
            2,
            "no range readings",
        ),
        ("empty", Vec::new(), 2, ""),
        ("no log at all", b"hello".to_vec(), 2, "not an MCAP file"),
    ] {
        let bench = bench_with("room_drive", |_| {});
        bench.put("room_drive.mcap", bytes);
        let (found, text) = said(&bench, "room_drive.mcap");
        assert_eq!(found, code, "{what}: {text}");
        assert!(text.contains(words), "{what}: {text}");
        let before = bench.bytes("golden/room_drive.golden.json");
        let run = tmam(
            &bench,
            &[
                "check",
                "room_drive.mcap",
                "--golden",
                "golden",
                "--bless",
                "--force",
            ],
            &[],
        );
        assert_eq!(run.code, code, "{what}: {}", run.stdout);
        assert!(
            bench.bytes("golden/room_drive.golden.json") == before,
            "{what} was blessed"
        );
    }
}

#[test]
fn a_result_without_features_is_not_blessed() {
    let bench = Bench::new();
    let log = path_of("room_drive.mcap");
    let arguments = ["check", &log, "--golden", "golden", "--bless", "--end", "1"];
    let run = tmam(&bench, &arguments, &[]);
    assert_eq!(run.code, 3, "{}", run.stdout);
    assert!(run.stdout.contains("gives no feature"), "{}", run.stdout);
    assert_eq!(fs::read_dir(bench.path("golden")).unwrap().count(), 0);
}

#[test]
fn what_is_missing_is_named() {
    let bench = bench_with("room_drive", |_| {});
    let (code, text) = said(&bench, &path_of("room_step.mcap"));
    assert_eq!(code, 3, "{text}");
    assert!(
        text.contains("no golden file golden/room_step.golden.json") && text.contains("--bless"),
        "{text}"
    );
    assert!(
        text.contains("no log was given for golden/room_drive.golden.json"),
        "{text}"
    );
    let (code, text) = said(&bench, "room_drive.mcap");
    assert_eq!(code, 2, "{text}");
    assert!(text.contains("cannot read room_drive.mcap"), "{text}");
    let empty = Bench::new();
    let (code, text) = said(&empty, &path_of("room_step.mcap"));
    assert_eq!(code, 2, "{text}");
    assert!(text.contains("no directory golden"), "{text}");
}

#[test]
fn reports_say_why_nothing_could_be_checked() {
    let bench = Bench::new();
    let log = path_of("room_step.mcap");
    let arguments = [
        "check",
        &log,
        "--golden",
        "golden",
        "--junit",
        "new/j.xml",
        "--summary",
        "new/er/s.md",
    ];
    let run = tmam(&bench, &arguments, &[]);
    assert_eq!(run.code, 2, "{}", run.stdout);
    let summary = String::from_utf8(bench.bytes("new/er/s.md")).unwrap();
    assert!(summary.contains("no directory golden"), "{summary}");
    let text = String::from_utf8(bench.bytes("new/j.xml")).unwrap();
    let xml = roxmltree::Document::parse(&text).unwrap();
    let error = xml.descendants().find(|node| node.has_tag_name("error"));
    let message = error.unwrap().attribute("message").unwrap();
    assert!(message.contains("no directory golden"), "{message}");
}

#[test]
fn a_golden_file_that_makes_no_sense_is_refused() {
    type Change = fn(&mut serde_json::Value);
    let changes: [(Change, &str); 12] = [
        (|f| f["schema"] = "tmam.golden/3".into(), "tmam.golden/3"),
        (|f| f["schema"] = "tmam.features/1".into(), "no golden file"),
        (|f| f["tolerances"]["rho"] = (-1.0).into(), "at least 0"),
        (|f| f["tolerances"]["rho"] = 0.9.into(), "pair_distance"),
        (
            |f| f["tolerances"]["loose"] = 1.into(),
            "unknown field `loose`",
        ),
        (
            |f| {
                f["tolerances"].as_object_mut().unwrap().remove("theta");
            },
            "missing field `theta`",
        ),
        (|f| f["labels"]["contact"] = 1.into(), "are counted"),
        (
            |f| {
                f.as_object_mut().unwrap().remove("labels");
            },
            "holds no `labels`",
        ),
        (
            |f| {
                f.as_object_mut().unwrap().remove("features");
            },
            "holds no `features`",
        ),
        (
            |f| f["labels"]["sonars"]["sonar_04"]["labels"] = "9999999999C".into(),
            "more than",
        ),
        (
            |f| f["config"]["triple"]["gamma"] = (-1.0).into(),
            "triple.gamma",
        ),
        (
            |f| f["map"]["lines"][0]["rho"] = "far".into(),
            "lacks one of `rho`",
        ),
    ];
    for (change, words) in changes {
        let bench = bench_with("room_drive", change);
        let before = bench.bytes("golden/room_drive.golden.json");
        let (code, text) = said(&bench, &path_of("room_drive.mcap"));
        assert_eq!(code, 2, "{words}: {text}");
        assert!(
            text.contains(words) && text.contains("room_drive.golden.json"),
            "{words}: {text}"
        );
        let log = path_of("room_drive.mcap");
        let run = tmam(
            &bench,
            &["check", &log, "--golden", "golden", "--bless"],
            &[],
        );
        assert_eq!(
            run.code, 2,
            "{words}: blessing overwrites nothing that it cannot read"
        );
        assert!(bench.bytes("golden/room_drive.golden.json") == before);
    }
    let bench = bench_with("room_drive", |_| {});
    let name = "golden/room_drive.golden.json";
    let text = String::from_utf8(bench.bytes(name)).unwrap();
    let twice = text.replace("\"sonar_05\":", "\"sonar_04\":");
    assert!(twice != text);
    bench.put(name, twice);
    let (code, text) = said(&bench, &path_of("room_drive.mcap"));
    assert_eq!(code, 2, "{text}");
    assert!(text.contains("sonar `sonar_04` is there twice"), "{text}");
    let bench = bench_with("room_drive", |_| {});
    bench.put("golden/room_drive.golden.json", b"{\"schema\": \"tmam.gol");
    assert_eq!(said(&bench, &path_of("room_drive.mcap")).0, 2);
    bench.put(name, super::LFS_POINTER);
    let (code, text) = said(&bench, &path_of("room_drive.mcap"));
    assert!(code == 2 && text.contains("`git lfs pull`"), "{text}");
}

#[test]
fn a_golden_file_of_the_version_before_is_held_and_what_it_does_not_know_is_said() {
    let bench = bench_with("before/room_step", |_| {});
    let log = path_of("room_step.mcap");
    let (code, text) = said(&bench, &log);
    assert_eq!(code, 0, "{text}");
    for words in ["what the log holds, part by part", "Bless again"] {
        assert!(text.contains(words), "no {words} in {text}");
    }
    let name = "golden/room_step.golden.json";
    let changed = |from: &str, to: &str| {
        let text = String::from_utf8(bench.bytes(name)).unwrap();
        assert!(text.contains(from), "{from}");
        bench.put(name, text.replacen(from, to, 1));
        said(&bench, &log)
    };
    let digest = bench.json(name)["log"]["events_sha256"].clone();
    let (code, text) = changed(digest.as_str().unwrap(), "0123");
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("cause: the log holds other events"), "{text}");
    let bless = ["check", &log, "--golden", "golden", "--bless"];
    assert_eq!(tmam(&bench, &bless, &[]).code, 0);
    assert_eq!(bench.json(name)["schema"], "tmam.golden/2");
    let (code, text) = said(&bench, &log);
    assert!(code == 0 && !text.contains("Bless again"), "{text}");
}

#[test]
fn logs_of_one_name_are_told_apart_by_their_folders() {
    let bench = Bench::new();
    for folder in ["r1", "r2"] {
        fs::create_dir(bench.path(folder)).unwrap();
        let log = format!("{folder}/drive.mcap");
        fs::copy(sample("room_step.mcap"), bench.path(&log)).unwrap();
    }
    let check = ["check", "--golden", "golden", "r2/drive.mcap"];
    let run = tmam(&bench, &[&check[..], &["r1", "--bless"]].concat(), &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    for name in ["r1_drive", "r2_drive"] {
        assert!(bench.path(&format!("golden/{name}.golden.json")).exists());
    }
    let run = tmam(&bench, &check, &[]);
    assert_eq!(run.code, 0, "by itself as in the suite: {}", run.stdout);
    assert!(
        !run.stdout.contains("was made from this drive"),
        "{}",
        run.stdout
    );
}

#[test]
fn parameters_have_no_place_in_a_check() {
    let bench = bench_with("room_drive", |_| {});
    let log = path_of("room_drive.mcap");
    let run = tmam(
        &bench,
        &["check", &log, "--golden", "golden", "--gamma", "8"],
        &[],
    );
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("--bless"), "{}", run.stderr);
}
