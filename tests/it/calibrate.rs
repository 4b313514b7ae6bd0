//! `tmam calibrate` and the causes that a replay tells: what is off is found, and what is not is not.

mod seeded;

use std::path::Path;

use crate::support::{Bench, Run};
use serde_json::Value;

fn ok(run: &Run) -> &str {
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    &run.stdout
}

/// A drive through the room with 3 mm of range noise.
fn drive(bench: &Bench) {
    let flags = "simulate -o drive.mcap --drive --noise 0.003 --seed 5";
    ok(&bench.tmam(Path::new(""), flags));
}

#[test]
fn a_sonar_that_is_turned_is_told_and_the_line_that_mends_it_does() {
    let bench = Bench::new();
    drive(&bench);
    let log = bench.path("drive.mcap");
    // The log has 135.
    let turned = "--set sonar.sonar_06.yaw=131";
    let told = bench.tmam(
        &log,
        &format!("calibrate {{}} {turned} --json --write tmam.toml"),
    );
    let told: Value = serde_json::from_str(ok(&told)).unwrap();
    let key = &told["keys"][0];
    assert_eq!(key["key"], serde_json::json!(["sonar", "sonar_06", "yaw"]));
    let yaw = key["value"].as_f64().unwrap();
    assert!((yaw - 135.0).abs() < 1.2, "{told:#}");
    assert_eq!(told["keys"].as_array().unwrap().len(), 1, "{told:#}");
    // A replay says the same, in its summary and its features.
    let run = bench.tmam(&log, &format!("replay {{}} {turned} --features f.json"));
    assert!(
        ok(&run).contains("cause 1    sonar_06 is turned by +"),
        "{}",
        run.stdout
    );
    let cause = bench.json("f.json")["causes"][0].clone();
    let setting = format!("sonar.sonar_06.yaw={yaw}");
    assert_eq!(cause["settings"], serde_json::json!([setting]));
    let info = bench.tmam(&log, &format!("info {{}} {turned}"));
    assert!(
        ok(&info).contains("sonar_06 is turned by +"),
        "{}",
        info.stdout
    );
    // And is content with what was written.
    let run = bench.tmam(&log, "replay {} --config tmam.toml --features f.json");
    assert!(
        ok(&run).contains("none found among: mounts"),
        "{}",
        run.stdout
    );
    assert_eq!(bench.json("f.json")["causes"], serde_json::json!([]));
    let run = bench.tmam(&log, "replay {} --no-causes --features f.json");
    assert!(!ok(&run).contains("cause"), "{}", run.stdout);
    assert_eq!(bench.json("f.json")["causes"], Value::Null);
}

#[test]
fn a_clock_that_is_early_is_told() {
    let bench = Bench::new();
    drive(&bench);
    let flags = "calibrate {} --set input.range_delay=0.1 --json";
    let told = bench.tmam(&bench.path("drive.mcap"), flags);
    let told: Value = serde_json::from_str(ok(&told)).unwrap();
    let keys = told["keys"].as_array().unwrap();
    assert_eq!(keys.len(), 1, "{told:#}");
    assert_eq!(keys[0]["key"], serde_json::json!(["input", "range_delay"]));
    let delay = keys[0]["value"].as_f64().unwrap();
    assert!(delay.abs() < 0.005, "{told:#}");
}

#[test]
fn a_sonar_that_is_taken_for_another_or_stamped_by_a_clock_of_its_own_is_told() {
    let bench = Bench::new();
    drive(&bench);
    let exchanged = "sonar_03 and sonar_11 are exchanged";
    let of_place = |sonar: u32, yaw: f64| {
        let at = |part: fn(f64) -> f64| 0.2 * part(yaw.to_radians());
        let (x, y) = (at(libm::cos), at(libm::sin));
        format!("[sonar.sonar_{sonar:02}]\nx = {x}\ny = {y}\nyaw = {yaw}\n")
    };
    for (keys, said) in [
        (of_place(3, -112.5) + &of_place(11, 67.5), exchanged),
        // These draw most of the map, which does not contradict them.
        (
            of_place(4, -90.0) + &of_place(12, 90.0),
            "sonar_04 and sonar_12 are exchanged",
        ),
        // Of a sonar that looks ahead no wall tells y.
        (
            "sonar.sonar_00.x = 0.28".to_owned(),
            "sonar_00 is mounted elsewhere: x by -",
        ),
        // As if the robot's frame were at another place.
        (
            (0..16)
                .map(|sonar| {
                    let x = 0.1 + 0.2 * libm::cos((22.5 * f64::from(sonar)).to_radians());
                    format!("sonar.sonar_{sonar:02}.x = {x}\n")
                })
                .collect(),
            "all sonars are mounted elsewhere: x by -",
        ),
        (
            "sonars.range_offset = 0.1".to_owned(),
            "ranges of all sonars are ",
        ),
        (
            "sonar.sonar_03.yaw = -112.5".to_owned(),
            "sonar_03 looks the other way: ",
        ),
        (
            "sonar.sonar_03.x = 0\nsonar.sonar_03.y = 0".to_owned(),
            "sonar_03 is mounted elsewhere: x by +7.7 cm",
        ),
        (
            "sonar.sonar_03.range_scale = 0.5".to_owned(),
            "ranges of sonar_03 are 0.50 times what",
        ),
        (
            (0..8)
                .map(|sonar| format!("sonar.sonar_{sonar:02}.range_delay = -0.15\n"))
                .collect(),
            "ranges of sonar_00, sonar_01, sonar_02 and ",
        ),
    ] {
        bench.put("tmam.toml", &keys);
        let run = bench.tmam(
            &bench.path("drive.mcap"),
            "replay {} --config tmam.toml --features f.json",
        );
        let told = ok(&run);
        assert!(
            told.contains(&format!("cause 1    {said}")),
            "{keys}: {told}"
        );
    }
    // What the last one needs is what it was off by, as far as so short a log tells.
    let cause = &bench.json("f.json")["causes"][0];
    assert!(
        cause["text"]
            .as_str()
            .unwrap()
            .contains("those of the others are not")
    );
    let setting = cause["settings"][0].as_str().unwrap();
    let delay = setting.strip_prefix("sonar.sonar_00.range_delay=").unwrap();
    assert!(delay.parse::<f64>().unwrap().abs() < 0.03, "{setting}");
}

#[test]
fn the_keys_of_a_configuration_are_what_a_calibration_changes() {
    let bench = Bench::new();
    drive(&bench);
    let log = bench.path("drive.mcap");
    let features = |flags: &str| {
        ok(&bench.tmam(
            &log,
            &format!("replay {{}} --no-causes --features f.json {flags}"),
        ));
        let found = bench.json("f.json");
        (found["map"].clone(), found["counts"].clone())
    };
    let plain = features("");
    // What is changed and changed back, but for rounding, is a log as it was.
    for nothing in [
        "--set input.odometry_scale=1 --set input.odometry_turn_scale=1",
        "--set sonars.range_scale=1 --set sonars.range_offset=0 --set input.range_clock_rate=0",
    ] {
        assert_eq!(plain, features(nothing), "{nothing}");
    }
    for other in [
        "--set input.odometry_scale=1.02",
        "--set input.odometry_turn_scale=1.02",
        "--set sonars.range_scale=1.02",
        "--set sonar.sonar_03.range_offset=0.03",
        "--set input.range_clock_rate=0.003",
    ] {
        assert_ne!(plain, features(other), "{other}");
    }
}

#[test]
fn a_sweep_takes_values_around_what_is_configured() {
    let bench = Bench::new();
    drive(&bench);
    let log = bench.path("drive.mcap");
    let run = bench.tmam(&log, "sweep {} --set sonar.sonar_03.yaw=+-5:2.5 --json");
    let sweep: Value = serde_json::from_str(ok(&run)).unwrap();
    let values = serde_json::json!([62.5, 65.0, 67.5, 70.0, 72.5]);
    assert_eq!(sweep["axes"][0]["values"], values);
    // The log has the truth, and mounts are ranked by the ranges all the same.
    assert_eq!(sweep["truth"], true);
    assert_eq!(sweep["ranked_by"][0], "bits");
    assert_eq!(sweep["cells"][0]["values"][0], 67.5);
    let run = bench.tmam(&log, "sweep {} --set sonar.*.yaw=+-5:5 --json");
    let sweep: Value = serde_json::from_str(ok(&run)).unwrap();
    assert_eq!(
        sweep["axes"][0]["values"],
        serde_json::json!([-5.0, 0.0, 5.0])
    );
    assert_eq!(sweep["cells"][0]["values"][0], 0.0);
    for (flags, said) in [
        (
            "--set sonar.front*.yaw=+-5:5",
            "the log has no sonar `front*`",
        ),
        ("--set sonar.sonar_03.yaw=+-5", "has no step"),
        (
            "--set sonar.sonar_03.min_range=+-0.1:0.1",
            "has no one value",
        ),
    ] {
        let run = bench.tmam(&log, &format!("sweep {{}} {flags}"));
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
}
