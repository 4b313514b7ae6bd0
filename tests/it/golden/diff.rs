//! `tmam diff`: what it takes, what it refuses, and what it says it did.

use serde_json::Value;

use super::{golden, path_of, tmam};
use crate::support::{Bench, Run, sample};

pub fn diff(bench: &Bench, arguments: &[&str]) -> Run {
    let all: Vec<&str> = ["diff"].iter().chain(arguments).copied().collect();
    tmam(bench, &all, &[])
}

/// A directory with the features of a sample, and its golden file's path.
pub fn with_features() -> (Bench, String) {
    let bench = Bench::new();
    let replay = "replay {} --rule paper --gamma 8 --features drive.features.json";
    assert_eq!(bench.tmam(&sample("room_drive.mcap"), replay).code, 0);
    let golden = golden().join("room_drive.golden.json");
    (bench, golden.to_str().unwrap().to_owned())
}

#[test]
fn a_log_is_replayed_as_the_other_side_was_and_that_is_said() {
    let (bench, golden) = with_features();
    let log = path_of("room_drive.mcap");
    for recorded in [golden.as_str(), "drive.features.json"] {
        for (a, b) in [(recorded, log.as_str()), (log.as_str(), recorded)] {
            let run = diff(&bench, &[a, b]);
            assert_eq!(run.code, 0, "{a} {b}: {}{}", run.stdout, run.stderr);
            let note = format!("was replayed with the configuration in {recorded}\n");
            assert!(run.stdout.contains(&note), "{}", run.stdout);
        }
    }
    // What is given stands over what is recorded, and nothing else does.
    assert_eq!(diff(&bench, &[&golden, &log, "--gamma", "8"]).code, 1);
    let run = diff(&bench, &["drive.features.json", &log, "--gamma", "8"]);
    assert_eq!(run.code, 0, "{}", run.stdout);
    assert!(run.stdout.contains("and what was given over it"));
    let run = diff(&bench, &[&golden, &log, "--set-b", "triple.gamma=8"]);
    assert_eq!(run.code, 1, "{}", run.stdout);
}

#[test]
fn what_can_have_no_effect_is_refused() {
    let (bench, golden) = with_features();
    let log = path_of("room_drive.mcap");
    for (arguments, said) in [
        (
            vec!["drive.features.json", golden.as_str(), "--gamma", "8"],
            "neither",
        ),
        (
            vec!["drive.features.json", &golden, "--rule", "paper"],
            "nothing to replay",
        ),
        (
            vec![log.as_str(), &golden, "--set-b", "triple.gamma=8"],
            "is no log",
        ),
        (
            vec!["drive.features.json", "--set-b", "triple.gamma=8"],
            "is no log",
        ),
    ] {
        let run = diff(&bench, &arguments);
        assert_eq!(run.code, 2, "{arguments:?}: {}", run.stdout);
        assert!(run.stderr.contains(said), "{arguments:?}: {}", run.stderr);
        assert!(run.stdout.is_empty());
    }
}

#[test]
fn what_holds_no_results_is_refused_by_its_schema() {
    let (bench, _) = with_features();
    let text = String::from_utf8(bench.bytes("drive.features.json")).unwrap();
    for (name, bytes, said) in [
        (
            "newer.json",
            text.replace("tmam.features/1", "tmam.features/2"),
            "Install the tmam that wrote it",
        ),
        (
            "older.json",
            text.replace("tmam.features/1", "tmam.features/0"),
            "Replay its log with this tmam",
        ),
        (
            "other.json",
            text.replace("tmam.features/1", "tmam.trace/1"),
            "its schema is `tmam.trace/1`",
        ),
        (
            "none.json",
            text.replace("\"schema\"", "\"scheme\""),
            "does not say its schema",
        ),
        ("cut.json", text[..text.len() / 2].to_owned(), "is cut off"),
        ("cut_early.json", text[..20].to_owned(), "is cut off"),
        (
            "lacking.json",
            text.replace("\"map\": {", "\"mop\": {"),
            "is no features.json as tmam writes it: missing field `map`",
        ),
        (
            "golden.json",
            text.replace("tmam.features/1", "tmam.golden/3"),
            "has the schema `tmam.golden/3`",
        ),
        (
            "old_golden.json",
            text.replace("tmam.features/1", "tmam.golden/0"),
            "bless it again",
        ),
    ] {
        bench.put(name, bytes);
        for (a, b) in [(name, "drive.features.json"), ("drive.features.json", name)] {
            let run = diff(&bench, &[a, b]);
            assert_eq!(run.code, 2, "{name}: {}", run.stdout);
            assert!(
                run.stderr.contains(said) && run.stderr.contains(name),
                "{name}: {}",
                run.stderr
            );
        }
    }
}

#[test]
fn features_without_their_numbers_are_refused() {
    let (bench, _) = with_features();
    let mut lines = bench.json("drive.features.json");
    lines["map"]["lines"][0]["rho"] = Value::Null;
    bench.put("lines.json", lines.to_string());
    let mut points = bench.json("drive.features.json");
    let mut rows = points["features"].as_array_mut().unwrap().iter_mut();
    let point = rows.find(|row| row["x"].is_number()).unwrap();
    point.as_object_mut().unwrap().remove("x");
    bench.put("points.json", points.to_string());
    for (name, said) in [
        ("lines.json", "lacks one of `rho`"),
        ("points.json", "lacks one of `x` and `y`"),
    ] {
        let run = diff(&bench, &[name, "drive.features.json"]);
        assert_eq!(run.code, 2, "{name}: {}", run.stdout);
        assert!(run.stderr.contains(said), "{name}: {}", run.stderr);
    }
}

#[test]
fn what_one_side_does_not_say_is_said() {
    let (bench, golden) = with_features();
    let mut file = bench.json("drive.features.json");
    let triple = file["config"]["triple"].as_object_mut().unwrap();
    triple.remove("alpha").unwrap();
    bench.put("old.json", file.to_string());
    let run = diff(&bench, &["old.json", &path_of("room_drive.mcap")]);
    assert!(
        run.stdout.contains("old.json does not record triple.alpha"),
        "{}",
        run.stdout
    );
    let corridor = super::golden().join("rust/corridor.golden.json");
    let corridor = corridor.to_str().unwrap();
    let run = diff(&bench, &[corridor, &golden]);
    let note = format!("labels are not compared: {corridor} holds none");
    assert!(run.stdout.contains(&note), "{}", run.stdout);
    let run = diff(&bench, &[corridor, "drive.features.json"]);
    assert!(run.stdout.contains("neither side holds"), "{}", run.stdout);
}

#[test]
fn json_says_what_was_compared_and_on_what_terms() {
    let (bench, golden) = with_features();
    let log = path_of("room_drive.mcap");
    let run = diff(&bench, &[&golden, &log, "--gamma", "8", "--json"]);
    let said: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((run.code, &said["exit_code"]), (1, &1.into()));
    assert_eq!(
        (&said["a"]["kind"], &said["b"]["kind"]),
        (&"golden".into(), &"log".into())
    );
    assert_eq!(said["a"]["events_sha256"], said["b"]["events_sha256"]);
    assert_eq!(said["labels_compared"], true);
    assert_eq!(said["tolerances"]["rho"], 0.01);
    assert!(said["first_frame"].is_u64() && said["borderline"].is_array());
    assert_eq!(said["notes"].as_array().unwrap().len(), 1);
    assert!(!said["differences"].as_array().unwrap().is_empty());
}

#[test]
fn features_of_a_damaged_log_are_no_ground_to_call_anything_good() {
    let (bench, _) = with_features();
    let mut file = bench.json("drive.features.json");
    file["source"]["complete"] = false.into();
    bench.put("damaged.json", file.to_string());
    let run = diff(&bench, &["damaged.json", "drive.features.json"]);
    assert_eq!(run.code, 3, "{}", run.stdout);
    assert!(run.stdout.contains("INCOMPLETE"), "{}", run.stdout);
}

#[test]
fn folders_are_compared_by_the_names_of_their_files() {
    let (bench, _) = with_features();
    let bytes = bench.bytes("drive.features.json");
    for file in ["one/drive.features.json", "two/drive.json", "two/readme.md"] {
        std::fs::create_dir_all(bench.path(file).parent().unwrap()).unwrap();
        bench.put(file, &bytes);
    }
    let run = diff(&bench, &["one", "two"]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("nothing differs"), "{}", run.stdout);
    bench.put("two/other.features.json", &bytes);
    let run = diff(&bench, &["one", "two"]);
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    let alone = "two/other.features.json has nothing of its name or its drive beside it";
    assert!(run.stdout.contains(alone), "{}", run.stdout);
    let said: Value =
        serde_json::from_str(&diff(&bench, &["one", "two", "--json"]).stdout).unwrap();
    assert_eq!(said["pairs"].as_array().unwrap().len(), 1);
}

#[test]
fn folders_that_hold_nothing_and_a_folder_against_a_file_are_refused() {
    let (bench, golden) = with_features();
    for folder in ["empty", "full", "notes"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    bench.put("notes/readme.md", b"");
    bench.put("full/drive.golden.json", std::fs::read(&golden).unwrap());
    for (a, b, said) in [
        ("empty", "notes", "empty holds no results"),
        ("full", "empty", "empty holds no results"),
        ("full", golden.as_str(), "full is a folder of several files"),
        (&golden, "full", "Give two folders"),
    ] {
        let run = diff(&bench, &[a, b]);
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{a} {b}");
        assert!(run.stderr.contains(said), "{a} {b}: {}", run.stderr);
    }
}

#[test]
fn a_file_that_was_renamed_is_found_in_the_other_folder_by_its_drive() {
    let (bench, golden) = with_features();
    for folder in ["one", "two"] {
        std::fs::create_dir(bench.path(folder)).unwrap();
    }
    bench.put("one/monday.golden.json", std::fs::read(&golden).unwrap());
    std::fs::copy(sample("room_drive.mcap"), bench.path("two/drive.mcap")).unwrap();
    std::fs::copy(sample("room_step.mcap"), bench.path("two/step.mcap")).unwrap();
    let run = diff(&bench, &["one", "two"]);
    assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
    for said in [
        "two/drive.mcap was replayed with the configuration in one/monday.golden.json",
        "nothing differs beyond the tolerances",
        "two/step.mcap has nothing of its name or its drive beside it",
    ] {
        assert!(run.stdout.contains(said), "{said}: {}", run.stdout);
    }
}

#[test]
#[cfg(feature = "viewer")]
fn what_differs_is_recorded_over_the_run_of_b_or_as_two_maps() {
    let (bench, golden) = with_features();
    let log = path_of("room_drive.mcap");
    let gamma = ["--gamma", "6"];
    let over_the_run = [&[golden.as_str(), log.as_str()][..], &gamma].concat();
    std::fs::create_dir(bench.path("one")).unwrap();
    bench.put("one/drive.golden.json", std::fs::read(&golden).unwrap());
    std::fs::create_dir(bench.path("two")).unwrap();
    bench.put("two/drive.json", bench.bytes("drive.features.json"));
    let over_a = [&[log.as_str(), golden.as_str()][..], &gamma].concat();
    for arguments in [
        over_the_run.clone(),
        over_a.clone(),
        vec![&golden, "drive.features.json"],
        vec!["one", "two"],
    ] {
        let with = |out| [&arguments[..], &["-o", out]].concat();
        let (first, second) = (diff(&bench, &with("a.rrd")), diff(&bench, &with("b.rrd")));
        assert!(first.code < 2, "{arguments:?}: {}", first.stderr);
        assert_eq!(first.code, second.code);
        assert!(
            first.stdout.contains("wrote      a.rrd"),
            "{}",
            first.stdout
        );
        assert_eq!(bench.bytes("a.rrd"), bench.bytes("b.rrd"), "{arguments:?}");
        assert!(bench.bytes("a.rrd").starts_with(b"RRF"));
    }
    // That of a run carries its results, and says so; that of two maps shows no run.
    let run = diff(&bench, &["a.rrd", &golden]);
    assert!(
        run.stderr.contains("a sweep or a comparison"),
        "{}",
        run.stderr
    );
    assert_eq!(
        diff(&bench, &[&over_the_run[..], &["-o", "run.rrd"]].concat()).code,
        1
    );
    let again = diff(&bench, &[&[golden.as_str(), "run.rrd"][..]].concat());
    assert_eq!(again.code, 1, "{}", again.stderr);
    // Where A alone is a log, its run is drawn, with the arcs whose label differs.
    assert_eq!(
        diff(&bench, &[&over_a[..], &["-o", "run.rrd"]].concat()).code,
        1
    );
    let drawn = bench.bytes("run.rrd");
    let path = b"/world/differences/labels";
    assert!(drawn.windows(path.len()).any(|bytes| bytes == path));
    // None takes the place of what is compared.
    for (arguments, out) in [
        (vec!["drive.features.json", "a.rrd"], "a.rrd"),
        (vec!["one", "two"], "two/drive.json"),
    ] {
        let before = bench.bytes(out);
        let run = diff(&bench, &[&arguments[..], &["-o", out]].concat());
        assert_eq!(run.code, 2, "{}", run.stdout);
        assert_eq!(bench.bytes(out), before);
    }
}

#[test]
fn a_cause_is_named_where_results_differ_and_of_what_bears_on_them() {
    let bench = Bench::new();
    let log = path_of("room_step.mcap");
    let run = diff(&bench, &[&log, "--set-b", "triple.gamma=8"]);
    assert_eq!(run.code, 0, "{}", run.stdout);
    assert!(!run.stdout.contains("cause:"), "{}", run.stdout);
    let note = "note: without effect under the rule that ran: triple.gamma 10.0 -> 8.0 deg\n";
    assert!(run.stdout.contains(note), "{}", run.stdout);
    let paper = [
        "--rule",
        "paper",
        "--set-b",
        "opinion.gate=1",
        "--set-b",
        "triple.gamma=8",
    ];
    let run = diff(&bench, &[&[log.as_str()], &paper[..]].concat());
    assert_eq!(run.code, 1, "{}", run.stdout);
    let cause = "cause: configuration: opinion.gate 6.63 -> 1.0; triple.gamma 10.0 -> 8.0 deg\n";
    assert!(
        run.stdout.contains(cause),
        "suspects differ, too: {}",
        run.stdout
    );
}
