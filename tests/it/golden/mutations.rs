//! Seeded changes: each must be caught, and what it did must be named. Mistakes in the code itself
//! are seeded by `.ci/mutations`, since each of them costs a build.

use serde_json::{Value, json};

use super::{bench_with, report};
use crate::support::{Message, rewrite, sample};

/// What is said of a log: its differences, after checking that the report is sound.
fn differences(what: &str, code: i32, said: &Value) -> Vec<Value> {
    assert_eq!(code, 1, "{what} went unnoticed: {said:#}");
    let log = &said["logs"][0];
    assert_eq!(log["verdict"], "differs", "{what}");
    let differences = log["differences"].as_array().unwrap().clone();
    assert!(!differences.is_empty(), "{what}");
    differences
}

#[test]
fn a_changed_parameter_is_caught_unless_the_log_overrules_it() {
    for (path, value) in [
        ("/triple/alpha", json!(0.4)),
        ("/triple/beta", json!(2.3)),
        ("/triple/gamma", json!(0.15)),
        ("/triple/turn_tolerance", json!(0.01)),
        ("/triple/bend_tolerance", json!(0.01)),
        ("/frames/step", json!(0.12)),
        ("/frames/step_angle", json!(0.1)),
        ("/sequence/max_gap", json!(0.5)),
        ("/sequence/max_baseline", json!(0.11)),
        ("/noise/sigma_abs", json!(0.005)),
        ("/noise/sigma_rel", json!(0.01)),
        ("/map/match_distance", json!(0.1)),
        ("/input/end", json!(60.0)),
        ("/input/start", json!(1.0)),
        ("/input/sonars", json!(["sonar_0?"])),
        ("/sonars/beam_width", json!(0.3)),
        ("/sonar/sonar_04", json!({"max_range": 1.5})),
        ("/sonar/sonar_12", json!({"min_range": 1.0})),
    ] {
        let what = format!("{path} = {value}");
        let bench = bench_with("room_drive", |file| {
            let (table, key) = path.rsplit_once('/').unwrap();
            let parts = table.split('/').skip(1);
            let table = parts.fold(&mut file["config"], |table, part| &mut table[part]);
            table[key] = value;
        });
        let (code, said) = report(&bench, &sample("room_drive.mcap"));
        if ["/sonars/beam_width", "/noise/sigma_abs", "/noise/sigma_rel"].contains(&path) {
            // The beam width and the variance that the log gives stand before the configuration's.
            assert_eq!(code, 0, "{said:#}");
            continue;
        }
        differences(&what, code, &said);
    }
}

/// Checks a log that was made from the sample, message by message.
fn altered(what: &str, change: impl Fn(Message) -> Vec<Message>) -> Vec<Value> {
    let log = sample("room_drive.mcap");
    let bench = bench_with("room_drive", |_| {});
    let other = rewrite(&log, mcap::WriteOptions::new(), change);
    let other = bench.put("room_drive.mcap", other);
    let (code, said) = report(&bench, &other);
    let found = differences(what, code, &said);
    assert_eq!(found[0]["kind"], "cause", "{what}: the log is not the same");
    found
}

fn f32_at(message: &Message, from_end: usize) -> f32 {
    let at = message.data.len() - from_end;
    f32::from_le_bytes(message.data[at..at + 4].try_into().unwrap())
}

fn set_f32(message: &mut Message, from_end: usize, value: f32) {
    let at = message.data.len() - from_end;
    message.data[at..at + 4].copy_from_slice(&value.to_le_bytes());
}

/// Where the range lies in a `sensor_msgs/Range` in CDR: before the variance.
const RANGE: usize = 8;

#[test]
fn a_lost_reading_is_caught_at_its_sonar_and_stamp() {
    // A contact arc in the midst of a run.
    let (sensor, stamp, frame) = a_contact_arc();
    let found = altered("a lost reading", |message| {
        let lost = message.topic.ends_with(&sensor) && stamp_of(&message) == stamp;
        if lost { vec![] } else { vec![message] }
    });
    let gone = found
        .iter()
        .find(|one| one["kind"] == "labels" && one["state"] == "missing")
        .unwrap_or_else(|| panic!("{found:#?}"));
    assert_eq!(gone["sensor"], *sensor);
    assert_eq!(gone["arcs"][0]["stamp_ns"], stamp);
    assert_eq!(gone["arcs"][0]["frame"], frame);
    // Nothing but what that reading took part in is named.
    for one in &found[1..] {
        let near = one["frames"][0].as_i64().unwrap() <= frame + 10
            && one["frames"][1].as_i64().unwrap() >= frame - 10;
        let of_sensor = one["sensor"] == *sensor || one["kind"] == "map";
        assert!(near && of_sensor, "{one:#}");
    }
}

fn stamp_of(message: &Message) -> i64 {
    let word = |at: usize| message.data[at..at + 4].try_into().unwrap();
    i64::from(i32::from_le_bytes(word(4))) * 1_000_000_000 + i64::from(u32::from_le_bytes(word(8)))
}

fn a_contact_arc() -> (String, i64, i64) {
    let bench = crate::support::Bench::new();
    assert_eq!(
        bench
            .tmam(
                &sample("room_drive.mcap"),
                "replay {} --rule paper --trace t"
            )
            .code,
        0
    );
    let rows = bench.json_lines("t");
    let sonars: std::collections::BTreeSet<&str> = rows
        .iter()
        .map(|row| row["sensor"].as_str().unwrap())
        .collect();
    for sonar in sonars {
        let arcs: Vec<&Value> = rows.iter().filter(|row| row["sensor"] == sonar).collect();
        let run = arcs
            .windows(3)
            .find(|run| run.iter().all(|row| row["label"] == "contact"));
        if let Some(run) = run {
            let number = |key: &str| run[1][key].as_i64().unwrap();
            return (sonar.to_owned(), number("stamp_ns"), number("frame"));
        }
    }
    panic!("no run of three contact arcs");
}

#[test]
fn a_changed_reading_is_caught() {
    let (sensor, stamp, _) = a_contact_arc();
    let found = altered("a reading 3 cm too long", |mut message| {
        if message.topic.ends_with(&sensor) && stamp_of(&message) == stamp {
            let range = f32_at(&message, RANGE);
            assert!((0.1..5.0).contains(&range), "{range} is no range");
            set_f32(&mut message, RANGE, range + 0.03);
        }
        vec![message]
    });
    assert!(
        found[1..]
            .iter()
            .all(|one| one["sensor"] == *sensor || one["kind"] == "map")
    );
    assert!(found.len() > 1);
}

#[test]
fn ranges_with_an_offset_are_caught() {
    let found = altered("2 cm more on every range", |mut message| {
        if message.topic.starts_with("/sonar") {
            let range = f32_at(&message, RANGE);
            set_f32(&mut message, RANGE, range + 0.02);
        }
        vec![message]
    });
    assert!(
        found
            .iter()
            .any(|one| one["kind"] == "map" && one["state"] == "changed")
    );
}

#[test]
fn sonars_that_are_late_are_caught() {
    altered("one sonar a second late", |mut message| {
        if message.topic == "/sonar/sonar_04" {
            message.shift_stamp(1);
        }
        vec![message]
    });
}

#[test]
fn odometry_that_lacks_samples_is_caught() {
    altered("half the odometry", |message| {
        let lost = message.topic == "/odom" && (message.log_time / 100_000_000) % 2 == 1;
        if lost { vec![] } else { vec![message] }
    });
}

#[test]
fn a_mount_that_is_off_by_two_degrees_is_caught_and_its_sonar_named() {
    // Sonar 3 of 16 on a ring of 0.2 m.
    let direction = 67.5_f64.to_radians();
    let bench = bench_with("room_drive", |file| {
        file["config"]["sonar"]["sonar_03"] = json!({
            "x": 0.2 * libm::cos(direction),
            "y": 0.2 * libm::sin(direction),
            "yaw": direction + 2_f64.to_radians(),
        });
    });
    let (code, said) = report(&bench, &sample("room_drive.mcap"));
    let found = differences("a mount off by 2 deg", code, &said);
    for kind in ["extracted", "labels"] {
        let mut of_kind = found.iter().filter(|one| one["kind"] == kind).peekable();
        assert!(of_kind.peek().is_some(), "{kind}: {found:#?}");
        assert!(
            of_kind.all(|one| one["sensor"] == "sonar_03"),
            "{kind}: {found:#?}"
        );
    }
}

#[test]
fn every_number_of_the_golden_file_is_held() {
    for (list, kind, key, by) in [
        ("map", "lines", "rho", 0.02),
        ("map", "lines", "theta", 0.02),
        ("map", "lines", "half_length", 0.1),
        ("map", "points", "x", 0.02),
        ("map", "points", "y", -0.02),
        ("features", "lines", "rho", 0.02),
        ("features", "points", "x", 0.02),
        ("map", "lines", "readings", 2.0),
    ] {
        let bench = bench_with("room_drive", |file| {
            let value = &mut file[list][kind][3][key];
            *value = match value.as_u64() {
                Some(n) => (n + by as u64).into(),
                None => (value.as_f64().unwrap() + by).into(),
            };
        });
        let (code, said) = report(&bench, &sample("room_drive.mcap"));
        let found = differences(&format!("{list} {kind} {key}"), code, &said);
        assert_eq!(found.len(), 1, "{list} {kind} {key}: {found:#?}");
        assert_eq!(found[0]["changes"][0]["what"], key.replace('_', " "));
    }
}
