//! `tmam evaluate` against logs whose truth is known.

use std::path::Path;

use crate::support::{Bench, rewrite, without};
use serde_json::{Value, json};

/// A bench with a simulated room in `room.mcap`.
fn room(how: &str) -> Bench {
    let bench = Bench::new();
    let made = bench.tmam(Path::new(""), &format!("simulate -o room.mcap {how}"));
    assert_eq!(made.code, 0, "{}", made.stderr);
    bench
}

/// What a command says in JSON.
fn evaluation(bench: &Bench, arguments: &str) -> Value {
    let run = bench.tmam(
        &bench.path("room.mcap"),
        &format!("evaluate {{}} --json {arguments}"),
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap()
}

/// The room as a world file.
const ROOM: &str = r#"{"walls": [[0,0,4,0],[4,0,4,2],[4,2,8,2],[8,2,8,5],[8,5,0,5],[0,5,0,0]]}"#;

fn count(row: &Value) -> u64 {
    ["line", "point", "other"]
        .iter()
        .map(|kind| row[*kind].as_u64().unwrap())
        .sum()
}

#[test]
fn the_matrix_counts_every_arc_of_the_replay_once() {
    let bench = room("--noise 0.003 --outliers 0.02");
    let replay = bench.tmam(
        &bench.path("room.mcap"),
        "replay {} --rule paper --features f.json",
    );
    assert_eq!(replay.code, 0, "{}", replay.stderr);
    let counts = &bench.json("f.json")["counts"];
    let scores = evaluation(&bench, "--rule paper");
    assert_eq!(scores["schema"], "tmam.evaluation/1");
    assert_eq!(scores["truth"]["origin"], "log");
    let labels = &scores["labels"];
    for label in ["contact", "intersection", "unidentified"] {
        assert_eq!(
            count(&labels[label]),
            counts[label].as_u64().unwrap(),
            "{label}"
        );
    }
    for (reason, arcs) in labels["reasons"].as_object().unwrap() {
        assert_eq!(
            count(arcs),
            counts["reasons"][reason].as_u64().unwrap(),
            "{reason}"
        );
    }
    assert!(labels["other"]["outlier"].as_u64().unwrap() > 20);

    let wrong = labels["contact"]["point"].as_u64().unwrap()
        + labels["contact"]["other"].as_u64().unwrap()
        + labels["intersection"]["line"].as_u64().unwrap()
        + labels["intersection"]["other"].as_u64().unwrap();
    assert!(wrong > 50, "{wrong}");
    assert_eq!(
        scores["wrong_labels"].as_array().unwrap().len() as u64,
        wrong
    );
    assert_eq!(scores["suspects"]["wrong"], wrong);
    assert_eq!(
        scores["suspects"]["configured"]["suspects"],
        counts["suspects"]
    );
}

#[test]
fn without_noise_every_label_is_right_and_the_map_holds_the_room() {
    let bench = room("");
    let scores = evaluation(&bench, "--rule paper");
    assert_eq!(scores["wrong_labels"], Value::Array(Vec::new()));
    assert_eq!(scores["labels"]["contact"]["precision"], 1.0);
    assert_eq!(scores["labels"]["wrong_share"], 0.0);
    for kind in ["lines", "points"] {
        let map = &scores["map"][kind];
        assert_eq!(
            (&map["visible"], &map["matched"]),
            (&6.into(), &6.into()),
            "{kind}"
        );
        assert_eq!(map["missed"], Value::Array(Vec::new()));
        assert_eq!(map["spurious"], Value::Array(Vec::new()));
    }
    // The paper's gates leave duplicates, so it is not exact.
    assert!(
        !scores["map"]["lines"]["duplicates"]
            .as_array()
            .unwrap()
            .is_empty()
    );
    assert_eq!(scores["map"]["exact"], false);
    let position = &scores["map"]["points"]["errors"]["position"];
    assert!(position["max"].as_f64().unwrap() < 1e-3, "{position}");
}

#[test]
fn a_world_file_says_the_same_of_exact_ranges_as_the_log() {
    let bench = room("");
    bench.put("room.json", ROOM);
    let (own, given) = (evaluation(&bench, ""), {
        let bare = without(&bench.path("room.mcap"), &["/truth"]);
        bench.put("room.mcap", bare);
        evaluation(&bench, "--truth room.json")
    });
    assert_eq!(given["truth"]["origin"], "echo-model");
    for part in ["labels", "suspects", "map", "extracted"] {
        assert_eq!(own[part], given[part], "{part}");
    }
}

#[test]
fn a_wall_that_is_not_in_the_world_makes_its_arcs_something_else() {
    let bench = room("--noise 0.003");
    // Without the wall y = 5, and one that is not there.
    let other = ROOM.replace("[8,5,0,5]", "[4,3,8,3]");
    bench.put("other.json", other);
    let scores = evaluation(&bench, "--truth other.json");
    let other = &scores["labels"]["other"];
    assert!(other["nothing"].as_u64().unwrap() > 50, "{other}");
    assert!(other["disagrees"].as_u64().unwrap() > 50, "{other}");
    let wide = evaluation(&bench, "--truth other.json --agree 10");
    assert_eq!(wide["labels"]["other"]["disagrees"], 0);
}

#[test]
fn without_any_truth_it_says_what_to_give() {
    let bench = room("");
    let bare = bench.put("bare.mcap", without(&bench.path("room.mcap"), &["/truth"]));
    let run = bench.tmam(&bare, "evaluate {}");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("--truth WORLD.json"), "{}", run.stderr);
    assert_eq!(run.stdout, "");
    for arguments in [
        "evaluate {} --truth nowhere.json",
        "evaluate {} --truth bare.mcap",
        "evaluate {} --agree nan",
    ] {
        let run = bench.tmam(&bench.path("room.mcap"), arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stderr);
    }
}

#[test]
fn a_truth_that_is_damaged_is_told() {
    let bench = room("--noise 0.003");
    let damaged = |topic: &'static str| {
        rewrite(
            &bench.path("room.mcap"),
            mcap::WriteOptions::new(),
            |mut message| {
                if message.topic == topic {
                    message.data.truncate(9);
                }
                vec![message]
            },
        )
    };
    let readings = bench.put("readings.mcap", damaged("/truth"));
    let run = bench.tmam(&readings, "evaluate {}");
    assert_eq!(run.code, 3);
    let told = "2400 of 2400 messages about the truth of readings";
    assert!(run.stderr.contains(told), "{}", run.stderr);
    assert!(run.stdout.contains("the echo model"), "{}", run.stdout);

    let world = bench.put("world.mcap", damaged("/truth/world"));
    let run = bench.tmam(&world, "evaluate {}");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("cannot be used"), "{}", run.stderr);
    bench.put("room.json", ROOM);
    let run = bench.tmam(&world, "evaluate {} --truth room.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn a_recording_takes_nothing_from_the_scores() {
    let bench = room("--noise 0.01 --drive");
    let log = bench.path("room.mcap");
    let plain = bench.tmam(&log, "evaluate {}");
    let drawn = bench.tmam(&log, "evaluate {} -o a.rrd");
    assert_eq!(drawn.code, 0, "{}", drawn.stderr);
    assert!(drawn.stdout.starts_with(&plain.stdout), "{}", drawn.stdout);
    assert!(drawn.stdout.contains("wrote      a.rrd"));
    assert!(plain.stdout.lines().all(|line| line.chars().count() <= 100));
    bench.tmam(&log, "evaluate {} -o b.rrd --json");
    assert_eq!(bench.bytes("a.rrd"), bench.bytes("b.rrd"));

    let to_stdout = bench.tmam(&log, "evaluate {} -o -");
    assert!(to_stdout.stdout.starts_with("RRF"));
    assert!(to_stdout.stderr.contains("LABELS"));
    let before = bench.bytes("room.mcap");
    for twice in ["evaluate {} -o - --json", "evaluate {} -o room.mcap"] {
        let run = bench.tmam(&log, twice);
        assert_eq!(run.code, 2, "{}", run.stderr);
    }
    assert_eq!(bench.bytes("room.mcap"), before);
}

#[test]
fn nothing_to_judge_and_half_a_log_end_in_3() {
    let bench = room("--noise 0.003");
    let log = bench.path("room.mcap");
    assert_eq!(bench.tmam(&log, "evaluate {} --start 1000").code, 3);
    let mut half = bench.bytes("room.mcap");
    half.truncate(half.len() / 2);
    let half = bench.put("half.mcap", half);
    let run = bench.tmam(&half, "evaluate {}");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(
        run.stdout.starts_with("half.mcap (INCOMPLETE)"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_log_is_held_against_walls_that_are_given_and_are_elsewhere() {
    let bench = Bench::new();
    bench.put(
        "hall.json",
        r#"{"walls": [[20,20,26,20],[26,20,26,24],[26,24,20,24],[20,24,20,20]]}"#,
    );
    let simulate = "tmam simulate -o hall.mcap --world hall.json --noise 0.003";
    let made = bench.sh(&format!("{simulate} --waypoints '21,21 25,21 25,23'"));
    assert_eq!(made.code, 0, "{}", made.stderr);
    bench.put("walls.json", ROOM);
    let log = bench.path("hall.mcap");
    let run = bench.tmam(&log, "evaluate {} --truth walls.json --agree 0.1");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(
        run.stderr.contains("hardly a range agrees"),
        "{}",
        run.stderr
    );
    assert!(run.stdout.contains("disagrees"), "{}", run.stdout);
}

#[test]
fn a_log_without_a_label_ends_in_3() {
    let bench = room("--noise 0.003");
    let run = bench.tmam(&bench.path("room.mcap"), "evaluate {} --json --end 0.5");
    assert_eq!(run.code, 3, "{}", run.stderr);
    let scores: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(scores["labels"]["coverage"], 0.0);
}

#[test]
fn walls_in_pieces_and_short_of_their_corners_are_the_same_room() {
    let bench = room("--noise 0.003");
    // The paper's room as a laser might give it: no points, walls cut in two, 4 cm short at corners.
    let corners = [(0., 0.), (4., 0.), (4., 2.), (8., 2.), (8., 5.), (0., 5.)];
    let mut walls: Vec<[f64; 4]> = Vec::new();
    for (k, (x1, y1)) in corners.iter().enumerate() {
        let (x2, y2) = corners[(k + 1) % corners.len()];
        let length = libm::hypot(x2 - x1, y2 - y1);
        let at = |way: f64| (x1 + (x2 - x1) * way / length, y1 + (y2 - y1) * way / length);
        for (from, to) in [(0.04, 0.6 * length), (0.6 * length + 0.05, length - 0.04)] {
            let ((a, b), (c, d)) = (at(from), at(to));
            walls.push([a, b, c, d]);
        }
    }
    bench.put("laser.json", json!({ "walls": walls }).to_string());
    let scores = evaluation(&bench, "--truth laser.json");
    let lines = &scores["confirmed"]["lines"];
    assert_eq!(lines["features"], 6, "{lines}");
    assert_eq!(lines["matched"], 6);
    for none in ["missed", "spurious", "duplicates"] {
        assert_eq!(lines[none], json!([]), "{none} of {lines}");
    }
    let points = &scores["confirmed"]["points"];
    assert_eq!(points["features"], 6);
    for none in ["missed", "spurious", "duplicates"] {
        assert_eq!(points[none], json!([]), "{none} of {points}");
    }
    let wrong = &scores["labels"]["wrong_share_known"];
    assert!(wrong.as_f64().unwrap() < 0.01, "{wrong}");
}

#[test]
fn a_log_with_noisy_odometry_is_held_against_the_true_path() {
    let bench = room("--noise 0.003");
    assert_eq!(evaluation(&bench, "")["path"], Value::Null);

    let bench = room("--noise 0.003 --odometry-noise 0.01 --heading-noise 0.2 --turn-noise 0.5");
    let path = &evaluation(&bench, "")["path"];
    assert_eq!(path["poses"], 150);
    let [first, aligned] = ["from_first", "aligned"].map(|of| path[of]["rms"].as_f64().unwrap());
    assert!(aligned <= first && (0.0005..0.2).contains(&first), "{path}");
    // Whatever is said of the walls, the path is the robot's.
    bench.put("other.json", r#"{"walls": [[0,-9,9,-9]]}"#);
    let run = bench.tmam(
        &bench.path("room.mcap"),
        "evaluate {} --json --truth other.json --agree 9",
    );
    let other: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(other["path"], *path);
    // And no reader takes the truth for odometry.
    let info = bench.tmam(&bench.path("room.mcap"), "info {} --json");
    let info: Value = serde_json::from_str(&info.stdout).unwrap();
    let channels = info["channels"].as_array().unwrap();
    let truth = channels.iter().find(|c| c["topic"] == "/truth/pose");
    assert_eq!(truth.unwrap()["role"], Value::Null, "{channels:?}");
}

#[test]
fn rough_walls_and_false_echoes_are_neither_wall_nor_point() {
    let bench =
        room("--noise 0.003 --drive --diffuse 1 --cross-talk 0.05 --double-reflections 0.05");
    let scores = evaluation(&bench, "");
    let other = &scores["labels"]["other"];
    for (what, least) in [
        ("oblique", 500),
        ("cross-talk", 50),
        ("double-reflection", 5),
    ] {
        assert!(other[what].as_u64().unwrap() >= least, "{what} of {other}");
    }
    // The echo model knows rough walls, too, by a world file.
    let rough = ROOM.replace("]]}", r#"]], "diffuse": [0, 1, 2, 3, 4, 5]}"#);
    bench.put("rough.json", rough);
    bench.put("room.mcap", without(&bench.path("room.mcap"), &["/truth"]));
    let modelled = evaluation(&bench, "--truth rough.json");
    let oblique = modelled["labels"]["other"]["oblique"].as_u64().unwrap();
    assert!(oblique >= 500, "{}", modelled["labels"]["other"]);
}

#[test]
fn the_office_is_driven_round_as_often_as_asked() {
    let bench = Bench::new();
    for (from, to) in [
        ("office.world.json", "world.json"),
        ("office.waypoints", "way"),
    ] {
        bench.put(to, std::fs::read(crate::support::sample(from)).unwrap());
    }
    for (laps, length) in [(1, 78.8), (2, 157.6)] {
        let run = bench.sh(&format!(
            "tmam simulate -o o.mcap --world world.json --waypoints \"$(cat way)\" --laps {laps} \
             --sonars 2 --step 0.4 --turn-noise 0.5 && tmam evaluate o.mcap --json > o.json"
        ));
        assert!(run.code == 0 || run.code == 3, "{}", run.stderr);
        let driven = bench.json("o.json")["path"]["length"].as_f64().unwrap();
        assert!((length - 5.0..length).contains(&driven), "{driven}");
    }
}

#[test]
fn rough_walls_at_an_angle_are_told_as_such_and_give_no_false_line() {
    for (how, least) in [
        ("--diffuse 0.3", 300),
        ("--diffuse 1", 800),
        ("--cross-talk 0.05", 0),
    ] {
        let bench = room(&format!("--noise 0.003 --drive {how}"));
        let scores = evaluation(&bench, "");
        let oblique = &scores["labels"]["oblique"];
        let [arcs, right] = ["arcs", "right"].map(|of| oblique[of].as_f64().unwrap());
        assert!(
            arcs >= f64::from(least) && right >= 0.9 * arcs,
            "{how}: {oblique}"
        );
        let lines = &scores["confirmed"]["lines"];
        assert_eq!(lines["spurious"], json!([]), "{how}");
        assert_eq!(lines["matched"], 6, "{how}");
    }
    let bench = room("--noise 0.003 --drive --diffuse 1");
    let log = bench.path("room.mcap");
    let run = bench.tmam(&log, "replay {} --trace t.jsonl");
    assert!(
        run.stdout
            .contains("heard from rough walls at an angle: sonar_01 "),
        "{}",
        run.stdout
    );
    assert!(
        run.stdout.contains("explains few triples: sonar_01 "),
        "{}",
        run.stdout
    );
    let trace = String::from_utf8(bench.bytes("t.jsonl")).unwrap();
    let row = trace
        .lines()
        .find(|row| row.contains("\"incidence\""))
        .unwrap();
    let row: Value = serde_json::from_str(row).unwrap();
    assert_eq!(row["reason"], "oblique");
    let run = bench.tmam(
        &log,
        &format!(
            "explain {{}} --sensor {} --frame {}",
            row["sensor"].as_str().unwrap(),
            row["frame"]
        ),
    );
    assert!(
        run.stdout.contains("A rough wall seen at "),
        "{}{}",
        run.stdout,
        run.stderr
    );
    assert!(
        run.stdout.contains("a rough wall, beside the foot"),
        "{}",
        run.stdout
    );
    // The paper's rule knows no such walls.
    let run = bench.tmam(&log, "replay {} --rule paper");
    assert!(!run.stdout.contains("oblique"), "{}", run.stdout);
}
