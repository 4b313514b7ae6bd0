//! The paper's room: without noise every label of the paper's rule must be right and Table I in the
//! map; with noise the noise-aware rule must have exactly its features.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

use crate::support::Bench;
use serde_json::Value;

/// (rho, theta) of the lines of Table I, metres and radians.
const LINES: [(f64, f64); 6] = [
    (0.0, FRAC_PI_2),
    (4.0, 0.0),
    (2.0, FRAC_PI_2),
    (8.0, 0.0),
    (5.0, FRAC_PI_2),
    (0.0, 0.0),
];

/// Its points, as (x, y) in metres.
const POINTS: [(f64, f64); 6] = [
    (0.0, 0.0),
    (4.0, 0.0),
    (4.0, 2.0),
    (8.0, 2.0),
    (8.0, 5.0),
    (0.0, 5.0),
];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Replays the noise-free room in a way of driving.
fn replayed(motion: &str) -> Bench {
    let bench = Bench::new();
    let made = bench.tmam(Path::new(""), &format!("simulate -o room.mcap {motion}"));
    assert_eq!(made.code, 0, "{}", made.stderr);
    let run = bench.tmam(
        &bench.path("room.mcap"),
        "replay {} --rule paper --features f --trace t",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stdout.contains("look like another one"),
        "{}",
        run.stdout
    );
    bench
}

/// What echoed, by stamp and sonar: the kind of reflector and its number.
fn truth(bench: &Bench) -> BTreeMap<(i64, String), (String, u64)> {
    let bytes = bench.bytes("room.mcap");
    mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/truth")
        .filter_map(|message| {
            let row: Value = serde_json::from_slice(&message.data).unwrap();
            let sonar = row["sonar"].as_str()?.to_owned();
            let reflector = (row["kind"].as_str()?.to_owned(), row["index"].as_u64()?);
            Some(((row["stamp_ns"].as_i64()?, sonar), reflector))
        })
        .collect()
}

/// Every label of a triple that one reflector gave is right; how many there were.
///
/// Triples with both angles up to `seen_end_on` are passed over.
fn labels_are_right(bench: &Bench, seen_end_on: f64) -> usize {
    let truth = truth(bench);
    let mut sequences: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    for row in bench.json_lines("t") {
        let sensor = row["sensor"].as_str().unwrap().to_owned();
        sequences.entry(sensor).or_default().push(row);
    }
    let mut judged = 0;
    for (sensor, rows) in &sequences {
        for triple in rows.windows(3) {
            let what = |row: &Value| {
                truth
                    .get(&(row["stamp_ns"].as_i64().unwrap(), sensor.clone()))
                    .unwrap()
            };
            let [before, middle, after] = triple else {
                unreachable!()
            };
            let label = middle["label"].as_str().unwrap();
            let one_reflector = what(before) == what(middle) && what(middle) == what(after);
            if label == "unidentified" || !one_reflector {
                continue;
            }
            if number(&middle["theta_c"]).max(number(&middle["theta_i"])) <= seen_end_on {
                continue;
            }
            let right = if what(middle).0 == "line" {
                "contact"
            } else {
                "intersection"
            };
            assert_eq!(label, right, "{middle}");
            judged += 1;
        }
    }
    judged
}

/// Table I is in the map within 1 mm and 0.1 degrees.
fn table_one_is_in_the_map(bench: &Bench) {
    let features = bench.json("f");
    let map = &features["map"];
    let points = map["points"].as_array().unwrap();
    for (x, y) in POINTS {
        let found = points
            .iter()
            .any(|p| libm::hypot(number(&p["x"]) - x, number(&p["y"]) - y) < 1e-3);
        assert!(found, "point ({x}, {y}) in {points:#?}");
    }
    let lines = map["lines"].as_array().unwrap();
    for (rho, theta) in LINES {
        let found = lines.iter().any(|line| {
            let (r, t) = (number(&line["rho"]), number(&line["theta"]));
            [(r, t), (-r, t + PI)].iter().any(|(r, t)| {
                let turn = (t - theta).rem_euclid(TAU);
                (r - rho).abs() < 1e-3 && turn.min(TAU - turn) < 0.1_f64.to_radians()
            })
        });
        assert!(found, "line ({rho}, {theta}) in {lines:#?}");
    }
}

#[test]
fn step_by_step() {
    let bench = replayed("");
    assert!(labels_are_right(&bench, 0.0) > 600);
    table_one_is_in_the_map(&bench);
}

#[test]
fn driven() {
    let bench = replayed("--drive");
    // A sonar that looks straight back at a wall has both angles at zero, and the 32-bit floats of
    // the range messages (1e-7 m) make some 5e-4 rad of noise of that.
    assert!(labels_are_right(&bench, 1e-3) > 500);
    table_one_is_in_the_map(&bench);
}

/// The noise-aware rule, with 3 mm of noise.
#[test]
fn with_noise_the_confirmed_map_is_the_room_and_nothing_else() {
    for motion in ["", "--drive"] {
        let bench = Bench::new();
        let simulate = format!("simulate -o room.mcap --noise 0.003 --seed 5 {motion}");
        assert_eq!(bench.tmam(Path::new(""), &simulate).code, 0);
        let run = bench.tmam(&bench.path("room.mcap"), "replay {} --features f");
        assert_eq!(run.code, 0, "{}", run.stderr);
        let map = &bench.json("f")["map"];
        let confirmed = |kind: &str| -> Vec<Value> {
            let features = map[kind].as_array().unwrap().iter();
            let confirmed = features.filter(|feature| feature["status"] == "confirmed");
            confirmed.cloned().collect()
        };
        let (lines, points) = (confirmed("lines"), confirmed("points"));
        assert_eq!((lines.len(), points.len()), (6, 6), "{motion}: {map}");
        for (x, y) in POINTS {
            let off = |point: &Value| {
                let (dx, dy) = (number(&point["x"]) - x, number(&point["y"]) - y);
                (dx * dx + dy * dy).sqrt()
            };
            assert!(points.iter().any(|point| off(point) < 0.01), "{x} {y}");
        }
        for (rho, theta) in LINES {
            let near = |line: &Value| {
                let turn = (number(&line["theta"]) - theta).rem_euclid(PI);
                (number(&line["rho"]) - rho).abs() < 0.02 && turn.min(PI - turn) < 0.01
            };
            assert!(lines.iter().any(near), "{rho} {theta}");
        }
    }
}
