//! The samples against their golden files: under the paper's rule those here, under the noise-aware
//! one those in `noise_aware/`. After a change that is meant to alter what comes of a log: `tmam check
//! sample_logs/*.mcap --golden tests/golden --bless`, the same for the other folder, and review the
//! difference.

use super::{golden, path_of, tmam};
use crate::support::{Bench, sample};

const SAMPLES: [&str; 3] = ["room_drive", "room_step", "room_trouble"];

#[test]
fn the_samples_are_what_their_golden_files_say() {
    let bench = Bench::new();
    let golden = golden();
    let logs = SAMPLES.map(|name| path_of(&format!("{name}.mcap")));
    let run = tmam(
        &bench,
        &[
            "check",
            &logs[0],
            &logs[1],
            &logs[2],
            "--golden",
            golden.to_str().unwrap(),
            "--strict",
        ],
        &[],
    );
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.ends_with("3 logs: 3 ok\n"), "{}", run.stdout);
}

#[test]
fn the_samples_are_what_their_golden_files_say_under_the_noise_aware_rule() {
    let bench = Bench::new();
    let golden = golden().join("noise_aware");
    let logs = SAMPLES.map(|name| path_of(&format!("{name}.mcap")));
    let golden = golden.to_str().unwrap();
    let [drive, step, trouble] = &logs;
    let arguments = [
        "check", drive, step, trouble, "--golden", golden, "--strict",
    ];
    let run = tmam(&bench, &arguments, &[]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
}

#[test]
fn blessing_gives_the_files_that_are_kept_and_twice_the_same_bytes() {
    let bench = Bench::new();
    for name in SAMPLES {
        let log = path_of(&format!("{name}.mcap"));
        for directory in ["one", "two"] {
            let run = tmam(
                &bench,
                &[
                    "check", &log, "--rule", "paper", "--golden", directory, "--bless",
                ],
                &[],
            );
            assert_eq!(run.code, 0, "{}", run.stderr);
        }
        let file = format!("{name}.golden.json");
        let one = bench.bytes(&format!("one/{file}"));
        assert!(one == bench.bytes(&format!("two/{file}")));
        assert!(
            one == std::fs::read(golden().join(&file)).unwrap(),
            "{file}"
        );
        assert!(one.ends_with(b"}\n") && !one.ends_with(b"\n\n"));
        assert!(
            one.len() < 80_000,
            "{file} is too long to review: {}",
            one.len()
        );
        let again = tmam(&bench, &["check", &log, "--golden", "one", "--bless"], &[]);
        assert!(again.stdout.starts_with("unchanged"), "{}", again.stdout);
    }
}

#[test]
fn a_golden_file_says_what_features_json_and_the_trace_say() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    assert_eq!(
        bench
            .tmam(&log, "replay {} --rule paper --features f --trace t")
            .code,
        0
    );
    let (features, trace) = (bench.json("f"), bench.json_lines("t"));
    let file = std::fs::read(golden().join("room_drive.golden.json")).unwrap();
    let golden: serde_json::Value = serde_json::from_slice(&file).unwrap();
    assert_eq!(golden["config"], serde_json::json!({"rule": "paper"}));
    for kind in ["lines", "points"] {
        let [ours, theirs] = [&golden, &features].map(|f| f["map"][kind].as_array().unwrap());
        assert_eq!(ours.len(), theirs.len());
        let key = if kind == "lines" { "half_length" } else { "x" };
        let sorted = |rows: &[serde_json::Value]| -> Vec<f64> {
            let number = |row: &serde_json::Value| row[key].as_f64().unwrap();
            let mut numbers: Vec<f64> = rows.iter().map(number).collect();
            numbers.sort_by(f64::total_cmp);
            numbers
        };
        for (ours, theirs) in sorted(ours).into_iter().zip(sorted(theirs)) {
            assert!((ours - theirs).abs() < 1e-6);
        }
    }
    // The label string of a sonar, written out, is the column of the trace.
    for (sonar, row) in golden["labels"]["sonars"].as_object().unwrap() {
        let written: String = row["labels"]
            .as_str()
            .unwrap()
            .split(' ')
            .map(|run| {
                let (count, letter) = run.split_at(run.len() - 1);
                letter.repeat(count.parse().unwrap())
            })
            .collect();
        let traced: String = trace
            .iter()
            .filter(|row| row["sensor"] == **sonar)
            .map(|row| match row["label"].as_str().unwrap() {
                "contact" => 'C',
                "intersection" => 'I',
                _ => 'u',
            })
            .collect();
        assert_eq!(written, traced, "{sonar}");
    }
}
