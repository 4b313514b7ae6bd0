//! `tmam diff` of recordings: by the results that they carry.

use serde_json::Value;
use tmam_replay::observe::recording::read_carried;

use super::diff::{diff, with_features};
use super::{bench_with, path_of, tmam};
use crate::support::{Bench, sample};

/// A directory with the features and the recording of a sample, and its golden file's path.
fn with_recording() -> (Bench, String) {
    let (bench, golden) = with_features();
    let replay = "replay {} --rule paper --gamma 8 -o drive.rrd";
    assert_eq!(bench.tmam(&sample("room_drive.mcap"), replay).code, 0);
    (bench, golden)
}

#[test]
fn recordings_are_compared_by_the_results_that_they_carry() {
    let (bench, golden) = with_recording();
    let log = path_of("room_drive.mcap");
    let carried = read_carried(&bench.path("drive.rrd")).unwrap();
    assert_eq!(
        carried.features.as_bytes(),
        bench.bytes("drive.features.json")
    );
    let other = "replay {} --rule paper -o other.rrd";
    assert_eq!(bench.tmam(&sample("room_drive.mcap"), other).code, 0);

    let run = diff(&bench, &["drive.rrd", "other.rrd"]);
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stdout.contains("labels: contact "), "{}", run.stdout);
    assert!(!run.stdout.contains("are not compared"), "{}", run.stdout);
    // The same differences as between replays, at the same frames.
    let found = |arguments: &[&str]| -> Vec<[Value; 3]> {
        let run = diff(&bench, &[arguments, &["--json"]].concat());
        let said: Value = serde_json::from_str(&run.stdout).unwrap();
        let all = said["differences"].as_array().unwrap().iter();
        all.map(|one| ["kind", "state", "frames"].map(|key| one[key].clone()))
            .collect()
    };
    let replays = [
        "--rule",
        "paper",
        "--gamma",
        "8",
        "--set-b",
        "triple.gamma=10",
    ];
    let of_logs = found(
        &[
            &[log.as_str()],
            &replays[..],
            &["--tolerance", "borderline=0"],
        ]
        .concat(),
    );
    assert!(of_logs.len() > 10, "{of_logs:?}");
    assert_eq!(found(&["drive.rrd", "other.rrd"]), of_logs);

    let evaluate = "evaluate {} --rule paper --gamma 8 -o evaluated.rrd";
    assert_eq!(bench.tmam(&sample("room_drive.mcap"), evaluate).code, 0);

    for (a, b, code) in [
        ("drive.rrd", "drive.rrd", 0),
        ("drive.rrd", "evaluated.rrd", 0),
        ("drive.rrd", "drive.features.json", 0),
        ("drive.rrd", log.as_str(), 0),
        (&log, "drive.rrd", 0),
        ("other.rrd", &golden, 0),
        ("drive.rrd", &golden, 1),
    ] {
        let run = diff(&bench, &[a, b]);
        assert_eq!(run.code, code, "{a} {b}: {}{}", run.stdout, run.stderr);
    }
}

#[test]
fn the_recording_of_a_check_carries_what_the_log_gives_now() {
    let bench = bench_with("room_drive", |file| {
        file["config"]["triple"]["gamma"] = 8_f64.to_radians().into();
    });
    let log = path_of("room_drive.mcap");
    for around in ["--strict", "--only-around-differences=2"] {
        let check = [
            "check",
            &log,
            "--golden",
            "golden",
            "--artifacts",
            "out",
            around,
        ];
        assert_eq!(tmam(&bench, &check, &[]).code, 1);
        let run = diff(
            &bench,
            &["out/room_drive.check.rrd", "out/room_drive.golden.json.new"],
        );
        assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
        let run = diff(
            &bench,
            &["golden/room_drive.golden.json", "out/room_drive.check.rrd"],
        );
        assert_eq!(run.code, 1, "{}{}", run.stdout, run.stderr);
        assert!(run.stdout.contains("labels: contact "), "{}", run.stdout);
    }
}

#[test]
fn recordings_without_results_are_refused_with_what_to_do() {
    let (bench, golden) = with_recording();
    let sweep = "sweep {} --rule paper --gamma 8,10 -o sweep.rrd";
    assert_eq!(bench.tmam(&sample("room_drive.mcap"), sweep).code, 0);
    let whole = bench.bytes("drive.rrd");
    bench.put("cut.rrd", &whole[..whole.len() * 2 / 3]);
    bench.put("twice.rrd", [&whole[..], &whole[..]].concat());
    bench.put("old.rrd", b"RRF1 and so on");
    for (name, said) in [
        ("sweep.rrd", "it shows a sweep or a comparison. "),
        ("cut.rrd", "it is cut off"),
        ("twice.rrd", "more than one recording"),
        ("old.rrd", "cannot be decoded at byte 0"),
    ] {
        for (a, b) in [(name, golden.as_str()), (golden.as_str(), name)] {
            let run = diff(&bench, &[a, b]);
            assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{name}");
            assert!(
                run.stderr.contains(said) && run.stderr.contains(name),
                "{}",
                run.stderr
            );
            assert!(
                run.stderr.contains("`tmam replay LOG -o FILE.rrd`"),
                "{}",
                run.stderr
            );
            assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
        }
    }
}
