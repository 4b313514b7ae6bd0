//! Which verdict a run comes to.

use std::fs;

use super::{bench_with, golden, path_of, report, tmam};
use crate::support::{Bench, sample};

#[test]
fn the_gravest_verdict_decides_and_every_log_is_checked() {
    let bench = bench_with("room_drive", |file| {
        file["map"]["points"][0]["x"] = 77.0.into()
    });
    fs::copy(
        golden().join("room_step.golden.json"),
        bench.path("golden/room_step.golden.json"),
    )
    .unwrap();
    fs::copy(sample("room_step.mcap"), bench.path("unknown.mcap")).unwrap();
    let (drive, step) = (path_of("room_drive.mcap"), path_of("room_step.mcap"));
    for (logs, code) in [
        (vec!["nowhere.mcap", "unknown.mcap", &drive, &step], 2),
        (vec!["unknown.mcap", &drive, &step], 1),
        (vec!["unknown.mcap", &step], 3),
        (vec![&step], 0),
    ] {
        let mut arguments = vec!["check"];
        arguments.extend(&logs);
        arguments.extend(["--golden", "golden"]);
        let run = tmam(&bench, &arguments, &[]);
        assert_eq!(run.code, code, "{}", run.stdout);
        assert!(
            run.stdout.contains(&format!("{} log", logs.len())),
            "{}",
            run.stdout
        );
        assert!(run.stdout.contains("1 ok"), "{}", run.stdout);
    }
}

#[test]
fn a_part_without_logs_is_not_good() {
    let bench = bench_with("room_drive", |_| {});
    let log = path_of("room_drive.mcap");
    let part = |part: &str| {
        tmam(
            &bench,
            &["check", &log, "--golden", "golden", "--partition", part],
            &[],
        )
    };
    assert_eq!(part("1/2").code, 0);
    let run = part("2/2");
    assert_eq!(run.code, 3, "{}", run.stdout);
    assert!(run.stdout.contains("nothing to judge"), "{}", run.stdout);
    assert_eq!(part("3/2").code, 2);
}

#[test]
fn a_borderline_flip_fails_only_when_strict() {
    // One arc whose label has next to nothing to spare gets another label in the golden file.
    let bench = Bench::new();
    assert_eq!(
        bench
            .tmam(
                &sample("room_step.mcap"),
                "replay {} --rule paper --trace t"
            )
            .code,
        0
    );
    let rows = bench.json_lines("t");
    let near = rows
        .iter()
        .filter(|row| row["label"] == "unidentified" && row["margin"].is_number())
        .min_by(|a, b| {
            a["margin"]
                .as_f64()
                .unwrap()
                .total_cmp(&b["margin"].as_f64().unwrap())
        })
        .unwrap();
    let margin = near["margin"].as_f64().unwrap();
    let sensor = near["sensor"].as_str().unwrap();
    let place = rows
        .iter()
        .filter(|row| row["sensor"] == sensor)
        .position(|row| row["frame"] == near["frame"])
        .unwrap();
    for (borderline, code) in [(margin * 2.0, 0), (margin / 2.0, 1)] {
        let bench = bench_with("room_step", |file| {
            file["tolerances"]["borderline"] = borderline.into();
            let labels = &mut file["labels"];
            let row = &mut labels["sonars"][sensor]["labels"];
            let mut marks: Vec<char> = row
                .as_str()
                .unwrap()
                .split(' ')
                .flat_map(|run| {
                    let (count, letter) = run.split_at(run.len() - 1);
                    letter
                        .repeat(count.parse().unwrap())
                        .chars()
                        .collect::<Vec<_>>()
                })
                .collect();
            marks[place] = 'C';
            *row = marks
                .iter()
                .map(|mark| format!("1{mark}"))
                .collect::<Vec<_>>()
                .join(" ")
                .into();
            for (label, by) in [("contact", 1), ("unidentified", -1)] {
                labels[label] = (labels[label].as_i64().unwrap() + by).into();
            }
        });
        let (found, said) = report(&bench, &sample("room_step.mcap"));
        assert_eq!(found, code, "{said:#}");
        let log = &said["logs"][0];
        let [flips, near_ones] =
            ["differences", "borderline"].map(|key| log[key].as_array().unwrap().len());
        assert_eq!((flips, near_ones), if code == 0 { (0, 1) } else { (1, 0) });
        let path = path_of("room_step.mcap");
        let run = tmam(
            &bench,
            &["check", &path, "--golden", "golden", "--strict"],
            &[],
        );
        assert_eq!(run.code, 1, "{}", run.stdout);
        assert!(
            run.stdout.contains("contact -> unidentified"),
            "{}",
            run.stdout
        );
    }
}
