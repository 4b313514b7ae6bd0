//! `tmam explain`, from outside: one arc's story, and the list of suspects.

use crate::support::{Bench, Run, sample};
use serde_json::Value;

const PAPER: &str = "--rule paper";

fn json(run: &Run) -> Value {
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap()
}

/// The lines of the trace of a log.
fn trace(bench: &Bench, arguments: &str) -> Vec<Value> {
    let log = sample("room_step.mcap");
    let run = bench.tmam(&log, &format!("replay {{}} -q --trace t.jsonl {arguments}"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    bench.json_lines("t.jsonl")
}

fn explained(bench: &Bench, row: &Value, arguments: &str) -> Value {
    let (sensor, frame) = (row["sensor"].as_str().unwrap(), &row["frame"]);
    let arguments = format!("explain {{}} --json --sensor {sensor} --frame {frame} {arguments}");
    json(&bench.tmam(&sample("room_step.mcap"), &arguments))
}

#[test]
fn the_story_agrees_with_the_trace_and_the_suggested_flag_changes_the_label() {
    let bench = Bench::new();
    let rows = trace(&bench, PAPER);
    for (label, reason) in [
        ("contact", None),
        ("intersection", None),
        ("unidentified", Some("ambiguous")),
    ] {
        let row = rows
            .iter()
            .find(|row| row["label"] == label && row["reason"].as_str() == reason)
            .unwrap();
        let told = explained(&bench, row, PAPER);
        assert_eq!(told["schema"], "tmam.explanation/1");
        for key in ["label", "reason", "suspect"] {
            assert_eq!(told[key], row[key], "{key}");
        }
        for key in ["theta_c", "theta_i", "margin"] {
            assert_eq!(told["angles"][key], row[key], "{key}");
        }
        assert_eq!(told["arc"]["range"], row["range"]);
        assert_eq!(told["windows"][0]["chi2_line"], row["chi2_line"]);
        assert_eq!(told["windows"][0]["support"], row["opinion"]);
        assert!(told["truth"]["echoed"]["what"].is_string());
        for (pair, held) in told["pairs"].as_array().unwrap().iter().zip(0..) {
            for (kind, points) in [
                ("contact", "contact_points"),
                ("intersection", "intersection_points"),
            ] {
                let sides = pair[kind]["sides"].as_array().unwrap();
                let counted = sides.iter().filter(|side| side["counts"] == true).count();
                assert_eq!(row[points][held], counted, "{kind}");
            }
        }
        let change = told["changes"].as_array().unwrap().iter();
        let change = change.clone().find(|c| c["impossible"].is_null()).unwrap();
        let flags: Vec<&str> = change["needs"]
            .as_array()
            .unwrap()
            .iter()
            .map(|need| need["flag"].as_str().unwrap())
            .collect();
        let again = explained(&bench, row, &format!("{PAPER} {}", flags.join(" ")));
        assert_eq!(again["label"], change["label"], "with {flags:?}");
    }
}

#[test]
fn under_the_noise_aware_rule_the_windows_and_their_changes_hold() {
    let bench = Bench::new();
    let rows = trace(&bench, "--rule noise-aware");
    let row = rows.iter().find(|row| row["label"] == "contact").unwrap();
    let told = explained(&bench, row, "--rule noise-aware");
    assert_eq!(told["label"], "contact");
    let widest = told["windows"].as_array().unwrap().last().unwrap();
    assert_eq!(widest["decides"], "line");
    assert_eq!(told["windows_end"], "decided");
    let changes = told["changes"].as_array().unwrap();
    let change = changes.iter().find(|c| c["impossible"].is_null()).unwrap();
    let flag = change["needs"][0]["flag"].as_str().unwrap();
    let again = explained(&bench, row, &format!("--rule noise-aware {flag}"));
    assert_eq!(again["label"], change["label"], "with {flag}");
}

#[test]
fn an_arc_that_is_no_triple_names_the_bound_that_would_make_it_one() {
    let bench = Bench::new();
    let tight = "--rule paper --set sequence.max_baseline=0.05";
    let rows = trace(&bench, tight);
    let row = rows.iter().find(|row| row["reason"] == "gap").unwrap();
    let told = explained(&bench, row, tight);
    let obstacle = &told["situation"]["obstacles"][0];
    assert_eq!(obstacle["key"], "sequence.max_baseline");
    assert!(obstacle["found"].as_f64().unwrap() > 0.05);
    let flags: Vec<&str> = told["changes"][0]["needs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|need| need["flag"].as_str().unwrap())
        .collect();
    let again = explained(&bench, row, &format!("--rule paper {}", flags.join(" ")));
    let reason = again["reason"].as_str();
    assert!(
        !matches!(reason, Some("gap" | "missing" | "turning")),
        "{reason:?}"
    );

    let log = sample("room_step.mcap");
    let (sensor, frame) = (row["sensor"].as_str().unwrap(), &row["frame"]);
    let run = bench.tmam(
        &log,
        &format!("explain {{}} --sensor {sensor} --frame {frame} {tight}"),
    );
    assert!(
        run.stdout.contains("sequence.max_baseline is 0.050"),
        "{}",
        run.stdout
    );
}

#[test]
fn the_text_tells_everything_in_short_lines() {
    let bench = Bench::new();
    let rows = trace(&bench, PAPER);
    let log = sample("room_step.mcap");
    for label in ["contact", "intersection", "unidentified"] {
        for row in rows.iter().filter(|row| row["label"] == label).step_by(97) {
            let (sensor, frame) = (row["sensor"].as_str().unwrap(), &row["frame"]);
            let run = bench.tmam(
                &log,
                &format!("explain {{}} --verbose --sensor {sensor} --frame {frame} {PAPER}"),
            );
            assert_eq!(run.code, 0, "{}", run.stderr);
            for said in [
                "READINGS",
                "RUN AND FEATURE",
                "TRUTH",
                &label.to_uppercase(),
            ] {
                assert!(run.stdout.contains(said), "no {said} in {}", run.stdout);
            }
            let long = run.stdout.lines().find(|line| line.chars().count() > 100);
            assert_eq!(long, None);
        }
    }
}

#[test]
fn a_time_and_a_place_name_an_arc() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let rows = trace(&bench, PAPER);
    let row = rows.iter().find(|row| row["label"] == "contact").unwrap();
    let told = explained(&bench, row, PAPER);
    let sensor = row["sensor"].as_str().unwrap();
    let seconds = &told["arc"]["seconds"];
    let by_time = format!("explain {{}} --json --sensor {sensor} --time {seconds} {PAPER}");
    let by_time = json(&bench.tmam(&log, &by_time));
    assert_eq!(by_time["arc"], told["arc"]);

    // The middle of the arc itself.
    let [x, y, yaw, range] =
        ["x", "y", "yaw", "range"].map(|key| told["arc"][key].as_f64().unwrap());
    let (x, y) = (x + range * libm::cos(yaw), y + range * libm::sin(yaw));
    let by_place = format!("explain {{}} --json --at {x},{y} --sensor {sensor} {PAPER}");
    let by_place = json(&bench.tmam(&log, &by_place));
    assert_eq!(by_place["arc"], told["arc"]);
    assert!(by_place["distance"].as_f64().unwrap() < 1e-6);
    assert!(!by_place["also_near"].as_array().unwrap().is_empty());

    // Where the sonar itself was, nothing echoed.
    let [x, y] = ["x", "y"].map(|key| told["arc"][key].as_f64().unwrap());
    let nowhere = bench.tmam(&log, &format!("explain {{}} --at {x},{y}"));
    assert!(
        nowhere
            .stdout
            .contains("No arc passes near the place asked for"),
        "{}",
        nowhere.stdout
    );
}

#[test]
fn suspects_come_worst_first_and_each_row_leads_to_its_story() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let list = json(&bench.tmam(&log, &format!("explain {{}} --suspects=5 --json {PAPER}")));
    assert_eq!(list["schema"], "tmam.suspects/1");
    let worst = list["worst"].as_array().unwrap();
    assert_eq!(worst.len(), 5);
    let rows = trace(&bench, PAPER);
    let suspects = rows.iter().filter(|row| row["suspect"] == true).count();
    assert_eq!(list["suspects"], suspects);
    for suspect in worst {
        let flags = suspect["explain"].as_str().unwrap();
        let told = json(&bench.tmam(&log, &format!("explain {{}} --json {flags} {PAPER}")));
        assert_eq!(told["suspect"], true);
        assert_eq!(told["label"], suspect["label"]);
        assert_eq!(told["doubts"], suspect["doubts"]);
    }
    // The log may stand behind the flag.
    let text = bench.tmam(&log, &format!("explain --suspects=5 {PAPER} {{}}"));
    let text = text.stdout;
    let bare = bench.tmam(&log, &format!("explain {PAPER} --suspects {{}}"));
    assert_eq!(bare.code, 0, "{}", bare.stderr);
    // One pattern, and a row that fills it in for each.
    let pattern = text.lines().filter(|line| line.contains("tmam explain"));
    assert_eq!(pattern.count(), 1, "{text}");
    for suspect in worst {
        let begins = format!("  {} ", suspect["sensor"].as_str().unwrap());
        let frame = format!(" {} ", suspect["frame"]);
        let row = text
            .lines()
            .find(|line| line.starts_with(&begins) && line.contains(&frame));
        let row = row.unwrap_or_else(|| panic!("{suspect} {text}"));
        if let Some(id) = suspect["doubts"][0]["feature"].as_u64() {
            let by_map = format!(" {} {id}", suspect["map"].as_str().unwrap());
            assert!(row.ends_with(&by_map), "{by_map}: {row}");
        }
    }
}

#[test]
fn what_is_not_there_is_said_with_what_is() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    for (arguments, said) in [
        (
            "--sensor nobody --frame 3",
            "no sonar matches nobody; the log has sonar_00",
        ),
        ("--frame 3", "--sensor NAME"),
        (
            "--sensor sonar_00 --frame 99999",
            "the replay has frames 0 to",
        ),
        ("--at here", "two numbers"),
        (
            "--at 500,-3",
            "no arc passes near 500,-3: the nearest, of sonar_",
        ),
        (
            "--sensor sonar_00 --time 1e4",
            "--time 10000 s is outside the replay, which lasts from 0.000 s to ",
        ),
        (
            "--sensor sonar_00 --time 1 --start 5 --end 9",
            "from 5.200 s to 8.800 s",
        ),
        ("--suspects=0", "0 is not in 1.."),
        ("", "required"),
    ] {
        let run = bench.tmam(&log, &format!("explain {{}} {arguments}"));
        assert_eq!(run.code, 2, "{arguments}: {}", run.stdout);
        assert!(run.stderr.contains(said), "no {said} in {}", run.stderr);
        assert!(run.stdout.is_empty());
    }
    // A frame in which some sonar has no arc.
    let rows = trace(&bench, PAPER);
    let has = |sensor: &str, frame: u64| {
        rows.iter()
            .any(|row| row["sensor"] == sensor && row["frame"] == frame)
    };
    let all = (0..16).flat_map(|n| (0..150).map(move |frame| (format!("sonar_{n:02}"), frame)));
    let (sensor, frame) = all
        .into_iter()
        .find(|(sensor, frame)| !has(sensor, *frame))
        .unwrap();
    let arguments = format!("explain {{}} --sensor {sensor} --frame {frame}");
    let run = bench.tmam(&log, &arguments);
    assert_eq!(run.code, 2);
    assert!(
        run.stderr.contains("nothing echoed; its nearest arc"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_time_between_readings_is_told_from_that_of_the_arc() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let told = |time: f64, how: &str| {
        let arguments = format!("explain {{}} --sensor sonar_00 --time {time} {how}");
        bench.tmam(&log, &arguments)
    };
    let exact = json(&told(0.0, "--json"));
    let second = exact["arc"]["seconds"].as_f64().unwrap();
    let off = json(&told(second + 0.2, "--json"));
    assert_eq!(off["arc"]["frame"], exact["arc"]["frame"]);
    assert!((off["late"].as_f64().unwrap() + 0.2).abs() < 1e-6);
    let text = told(second + 0.2, "").stdout;
    assert!(text.contains("measured 0.200 s before the time"), "{text}");
    let text = told(second, "").stdout;
    assert!(!text.contains("the time asked for"), "{text}");
}

#[test]
fn without_a_label_no_suspect_can_be_named() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let run = bench.tmam(&log, "explain {} --suspects --end 0.5");
    assert_eq!(run.code, 3, "{}", run.stdout);
}

#[test]
fn a_mount_that_is_off_is_not_blamed_on_the_noise() {
    let bench = Bench::new();
    let log = sample("room_trouble.mcap");
    let run = bench.tmam(&log, "explain {} --sensor sonar_02 --frame 198");
    assert_eq!(run.code, 0, "{}", run.stderr);
    for said in ["so the label is WRONG", "outside of the beam", "a mount"] {
        assert!(run.stdout.contains(said), "no {said} in {}", run.stdout);
    }
    assert!(!run.stdout.contains("misled"), "{}", run.stdout);
}
