//! Seeded changes under the noise-aware rule, the default: each must be caught, and named for what
//! it is.

use serde_json::{Value, json};

use super::{bench_with, report, tmam};
use crate::support::{Bench, Message, rewrite, sample};

const SAMPLE: &str = "noise_aware/room_drive";

/// The differences that are found after a change to the golden file's configuration.
fn reconfigured(table: &str, key: &str, value: &Value) -> Vec<Value> {
    let bench = bench_with(SAMPLE, |file| {
        file["config"][table][key] = value.clone();
    });
    let (code, said) = report(&bench, &sample("room_drive.mcap"));
    let what = format!("{table}.{key} = {value}");
    assert_eq!(code, 1, "{what} went unnoticed: {said:#}");
    assert_eq!(said["logs"][0]["verdict"], "differs", "{what}");
    said["logs"][0]["differences"].as_array().unwrap().clone()
}

fn of_kind<'a>(found: &'a [Value], kind: &str) -> Vec<&'a Value> {
    found.iter().filter(|one| one["kind"] == kind).collect()
}

#[test]
fn what_decides_labels_is_caught_in_the_labels() {
    for (table, key, value) in [
        ("noise", "sigma_pose", json!(0.01)),
        ("opinion", "gate", json!(4.0)),
        ("opinion", "decisive", json!(20.0)),
        ("opinion", "max_half_width", json!(3)),
        ("triple", "turn_tolerance", json!(0.01)),
        ("sequence", "max_baseline", json!(0.11)),
        ("noise_aware", "label_by_opinion", json!(false)),
    ] {
        let found = reconfigured(table, key, &value);
        assert!(!of_kind(&found, "labels").is_empty(), "{key}: {found:#?}");
        // The map itself is gathered from all readings, whatever their labels, and may hold.
        let features = of_kind(&found, "extracted");
        assert!(!features.is_empty(), "{key}: {found:#?}");
        assert!(of_kind(&found, "cause").is_empty(), "{key}: {found:#?}");
    }
}

#[test]
fn what_only_makes_the_map_is_caught_in_the_map_and_in_no_label() {
    for (key, value) in [("gate", json!(1.0)), ("gate", json!(4.0))] {
        let found = reconfigured("map", key, &value);
        assert!(!of_kind(&found, "map").is_empty(), "{key}: {found:#?}");
        assert!(of_kind(&found, "labels").is_empty(), "{key}: {found:#?}");
    }
    for switch in ["gather", "fuse_by_information"] {
        let found = reconfigured("noise_aware", switch, &json!(false));
        assert!(!of_kind(&found, "map").is_empty(), "{switch}: {found:#?}");
        assert!(of_kind(&found, "labels").is_empty(), "{switch}: {found:#?}");
    }
}

#[test]
fn a_mount_or_a_range_limit_of_one_sonar_is_caught_and_the_sonar_named() {
    let direction = 67.5_f64.to_radians();
    for (sensor, change, what) in [
        (
            "sonar_03",
            json!({"yaw": direction + 2_f64.to_radians()}),
            "mounts: mount of sonar_03: yaw +2.00 deg (unchanged: ",
        ),
        (
            "sonar_03",
            json!({"x": 0.2}),
            "mounts: mount of sonar_03: x +0.123 m",
        ),
        (
            "sonar_12",
            json!({"min_range": 1.0}),
            "beams: beam of sonar_12: least range 0.200 -> 1.000 m",
        ),
    ] {
        let found = reconfigured("sonar", sensor, &change);
        let text = found[0]["text"].as_str().unwrap();
        assert!(text.starts_with(what), "{text}");
        for one in of_kind(&found, "labels") {
            assert_eq!(one["sensor"], sensor, "{one:#}");
        }
    }
}

#[test]
fn a_sonar_that_measures_too_long_is_named() {
    /// Where the range lies in a `sensor_msgs/Range` in CDR: before the variance.
    const RANGE_FROM_END: usize = 8;
    let bench = bench_with(SAMPLE, |_| {});
    let longer = |mut message: Message| {
        if message.topic == "/sonar/sonar_04" {
            let at = message.data.len() - RANGE_FROM_END;
            let range = &mut message.data[at..at + 4];
            let measured = f32::from_le_bytes(range.try_into().unwrap());
            range.copy_from_slice(&(measured + 0.03).to_le_bytes());
        }
        vec![message]
    };
    let log = rewrite(
        &sample("room_drive.mcap"),
        mcap::WriteOptions::new(),
        longer,
    );
    let (code, said) = report(&bench, &bench.put("room_drive.mcap", log));
    assert_eq!(code, 1, "{said:#}");
    let found = said["logs"][0]["differences"].as_array().unwrap();
    let text = found[0]["text"].as_str().unwrap();
    assert!(
        text.starts_with("ranges: offset by +30.0 mm, of sonar_04"),
        "{text}"
    );
}

#[test]
fn a_lost_reading_is_caught_at_its_sonar() {
    let bench = bench_with(SAMPLE, |_| {});
    let seen = std::cell::Cell::new(0);
    let lost = |message: Message| {
        if message.topic == "/sonar/sonar_03" {
            seen.set(seen.get() + 1);
        }
        // An echo in the midst of the drive: the ring fires more often than frames are opened.
        let lost = message.topic == "/sonar/sonar_03" && (100..120).contains(&seen.get());
        if lost { vec![] } else { vec![message] }
    };
    let log = rewrite(&sample("room_drive.mcap"), mcap::WriteOptions::new(), lost);
    let (code, said) = report(&bench, &bench.put("room_drive.mcap", log));
    assert_eq!(code, 1, "{said:#}");
    let found = said["logs"][0]["differences"].as_array().unwrap();
    assert!(seen.get() > 120 && found.len() > 1, "{found:#?}");
    for one in found.iter().filter(|one| one["kind"] == "labels") {
        assert_eq!(one["sensor"], "sonar_03", "{one:#}");
    }
}

#[test]
fn a_flip_has_a_margin_and_is_borderline_below_the_tolerance_for_it() {
    let changed = |borderline: f64| {
        let bench = bench_with(SAMPLE, |file| {
            file["config"]["opinion"]["decisive"] = json!(20.0);
            file["tolerances"]["borderline_chi2"] = borderline.into();
        });
        let (_, said) = report(&bench, &sample("room_drive.mcap"));
        let log = &said["logs"][0];
        let arcs = |runs: Vec<Value>| -> Vec<Value> {
            let arcs = |run: &Value| run["arcs"].as_array().unwrap().clone();
            runs.iter().flat_map(arcs).collect()
        };
        let all = |key: &str| log[key].as_array().unwrap().clone();
        let labels = |runs: Vec<Value>| -> Vec<Value> {
            let is_flip = |run: &Value| run["kind"] == "labels" && run["state"] == "changed";
            runs.into_iter().filter(is_flip).collect()
        };
        (arcs(labels(all("differences"))), arcs(all("borderline")))
    };
    let margin = |arc: &Value| arc["margin"].as_f64().unwrap();
    let (flipped, near) = changed(0.0);
    assert!(flipped.len() > 10 && near.is_empty());
    for arc in &flipped {
        assert_eq!(arc["margin_unit"], "chi2");
        assert!(margin(arc) >= 0.0);
    }
    let mut margins: Vec<f64> = flipped.iter().map(margin).collect();
    margins.sort_by(f64::total_cmp);
    // Between two margins: they are rounded.
    let half = margins.len() / 2;
    let middle = (margins[half - 1] + margins[half]) / 2.0;
    assert!(margins[half] - margins[half - 1] > 1e-6);
    let (clear, near) = changed(middle);
    assert_eq!(clear.len() + near.len(), flipped.len());
    assert!(!clear.is_empty() && !near.is_empty());
    assert!(clear.iter().all(|arc| margin(arc) >= middle));
    assert!(near.iter().all(|arc| margin(arc) < middle));
}

/// What the keys matter for that nothing in the samples hangs on: a drive with odometry that drifts,
/// outliers and features that hardly anything speaks for, at the poses of odometry: corrected ones leave
/// nothing of that.
#[test]
fn what_matters_only_where_a_drive_is_bad_is_caught_on_a_bad_one() {
    const STEADY: &str = "--noise 0.01 --seed 81 --sonars 12 --odometry-noise 0.02 --heading-noise 3 --outliers 0.05 \
                          --step 0.08";
    const MIRRORED: &str = "--noise 0.01 --seed 52 --sonars 12 --odometry-noise 0.02 --heading-noise 3 \
                            --outliers 0.05 --step 0.08";
    const DRIFTING: &str =
        "--noise 0.02 --seed 22 --sonars 16 --odometry-noise 0.05 --outliers 0.05 --step 0.12";
    const COARSE: &str = "--noise 0.02 --seed 20 --sonars 16 --odometry-noise 0.05 --heading-noise 3 --outliers 0.05 \
                          --step 0.12";
    for (drive, changes) in [
        (
            STEADY,
            &[
                ("map", "confirm_runs", json!(1)),
                ("map", "confirm_readings", json!(40)),
                ("map", "confirm_readings", json!(3)),
                ("noise_aware", "confirm", json!(false)),
                ("noise_aware", "break_runs", json!(false)),
            ][..],
        ),
        (
            MIRRORED,
            &[("noise_aware", "reject_mirrored", json!(false))],
        ),
        (DRIFTING, &[("noise_aware", "merge", json!(false))]),
        (COARSE, &[("noise_aware", "converge", json!(false))]),
    ] {
        let bench = Bench::new();
        let log = bench.path("bad.mcap");
        let simulated = bench.tmam(&log, &format!("simulate -o {{}} {drive}"));
        assert_eq!(simulated.code, 0, "{}", simulated.stderr);
        let odometry = "poses=\"odometry\"";
        let bless = [
            "check", "bad.mcap", "--golden", "golden", "--bless", "--set", odometry,
        ];
        assert_eq!(tmam(&bench, &bless, &[]).code, 0);
        assert_eq!(report(&bench, &log).0, 0);
        let blessed = bench.json("golden/bad.golden.json");
        for (table, key, value) in changes {
            let mut file = blessed.clone();
            file["config"][table][key] = value.clone();
            bench.put("golden/bad.golden.json", file.to_string());
            let (code, said) = report(&bench, &log);
            assert_eq!(code, 1, "{table}.{key} = {value} went unnoticed");
            let found = said["logs"][0]["differences"].as_array().unwrap();
            let of_features = |one: &&Value| one["kind"] == "map" || one["kind"] == "extracted";
            assert!(
                found.iter().any(|one| of_features(&one)),
                "{key}: {found:#?}"
            );
            assert!(of_kind(found, "labels").is_empty(), "{key}: {found:#?}");
        }
    }
}
