//! Odometry that drifts: poses and features estimated together give the map that exact poses give, and
//! odometry stays where nothing is gained.

use std::path::Path;

use serde_json::Value;

use crate::support::Bench;

const MUCH: &str = "--odometry-noise 0.01 --heading-noise 0.2 --turn-noise 0.5";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// A drive round the room.
fn driven(options: &str) -> Bench {
    let bench = Bench::new();
    let made = bench.tmam(
        Path::new(""),
        &format!("simulate -o room.mcap --drive {options}"),
    );
    assert_eq!(made.code, 0, "{}", made.stderr);
    bench
}

fn evaluated(bench: &Bench, options: &str) -> Value {
    let run = bench.tmam(
        &bench.path("room.mcap"),
        &format!("evaluate {{}} --json {options}"),
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap()
}

fn replayed(bench: &Bench, options: &str) -> Value {
    let run = bench.tmam(
        &bench.path("room.mcap"),
        &format!("replay {{}} --features f.json --trace t.jsonl {options}"),
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_slice(&bench.bytes("f.json")).unwrap()
}

#[test]
fn a_drifting_drive_has_the_map_of_the_room() {
    for (noise, seed, farthest) in [(0.003, 2, 0.010), (0.01, 1, 0.015)] {
        let bench = driven(&format!("--noise {noise} {MUCH} --seed {seed}"));
        let scores = evaluated(&bench, "");
        assert_eq!(scores["confirmed"]["exact"], true, "{scores}");
        let path = &scores["path"];
        assert!(number(&path["from_first"]["rms"]) < farthest, "{path}");
        assert!((0.05..3.0).contains(&number(&path["nees"])), "{path}");
        for kind in ["lines", "points"] {
            let nees = number(&scores["confirmed"][kind]["errors"]["nees"]["mean"]);
            assert!((0.05..3.0).contains(&nees), "{kind}: {nees}");
        }
        let by_odometry = evaluated(&bench, "--set poses=\"odometry\"");
        assert_eq!(by_odometry["confirmed"]["exact"], false);
        assert!(number(&by_odometry["path"]["from_first"]["rms"]) > 0.03);
    }
}

#[test]
fn what_odometry_drifts_between_key_poses_makes_no_wall_twice() {
    // By 5 mm half-way, where ranges are right to 3 mm.
    let bench = driven(
        "--noise 0.003 --laps 3 --odometry-noise 0.03 --heading-noise 0.6 --turn-noise 1.5 --seed 4",
    );
    let scores = evaluated(&bench, "");
    assert_eq!(scores["confirmed"]["exact"], true, "{scores}");
    // Map and path are of one estimate.
    let features = replayed(&bench, "--no-causes");
    let suspects = number(&features["counts"]["suspects"]);
    assert!(suspects < 10.0, "{suspects}");
}

#[test]
fn the_files_say_what_was_corrected() {
    let bench = driven(&format!("--noise 0.003 {MUCH} --seed 2"));
    let features = replayed(&bench, "");
    let poses = &features["poses"];
    assert_eq!(poses["from"], "joint");
    assert!(number(&poses["end_correction"]) > 0.02, "{poses}");
    assert!(number(&poses["explained"]) > number(&poses["explained_before"]));
    let found = number(&poses["odometry_noise"]["distance"]);
    assert!(
        (0.005..0.02).contains(&found),
        "a centimetre, found {found}"
    );
    let closures = poses["closures"].as_array().unwrap();
    assert!(!closures.is_empty());
    for closure in closures {
        // The round is 18 m long, a frame every 0.1 m or 10 deg.
        let [a, b] = [&closure["frames"][0], &closure["frames"][1]].map(number);
        assert!((a - b).abs() > 20.0, "it was elsewhere between: {closure}");
    }
    let trace = String::from_utf8(bench.bytes("t.jsonl")).unwrap();
    let last: Value = serde_json::from_str(trace.lines().last().unwrap()).unwrap();
    let [x, y] = [&last["odometry"][0], &last["odometry"][1]].map(number);
    let moved = libm::hypot(x - number(&last["x"]), y - number(&last["y"]));
    assert!((0.01..0.5).contains(&moved), "{last}");
    let again = replayed(&bench, "");
    assert_eq!(features, again);
}

#[test]
fn poses_that_are_exact_stay() {
    let bench = driven("--noise 0.003");
    let joint = replayed(&bench, "");
    assert_eq!(joint["poses"]["from"], "odometry");
    let reason = joint["poses"]["reason"].as_str().unwrap();
    assert!(reason.contains("fit no better at other poses"), "{reason}");
    let odometry = replayed(&bench, "--set poses=\"odometry\"");
    for part in ["counts", "features", "map"] {
        assert_eq!(joint[part], odometry[part], "{part}");
    }
    assert_eq!(odometry.get("poses"), None);
}

#[test]
fn what_is_told_of_odometry_is_believed() {
    // The ranges of this drive are likelier without any drift.
    let bench = driven(
        "--noise 0.01 --odometry-noise 0.002 --heading-noise 0.05 --turn-noise 0.1 --seed 3",
    );
    let features = replayed(&bench, "--no-causes");
    assert_eq!(features["poses"]["from"], "odometry");
    let scores = evaluated(
        &bench,
        "--set noise.odometry_distance=0.002 --set noise.odometry_heading=0.05 --set noise.odometry_turn=0.1",
    );
    for kind in ["lines", "points"] {
        let nees = number(&scores["confirmed"][kind]["errors"]["nees"]["mean"]);
        assert!((0.05..3.0).contains(&nees), "{kind}: {nees}");
    }
}

#[test]
fn the_papers_rule_stays_with_odometry() {
    let bench = driven(&format!("--noise 0.003 {MUCH}"));
    assert_eq!(replayed(&bench, "--rule paper").get("poses"), None);
}
