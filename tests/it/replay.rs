//! The main job, from outside: a log in; features, a trace and a recording out.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::support::{Bench, rewrite, ros1, sample, shared};
use serde_json::Value;

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn without_named_outputs_the_recording_and_the_features_are_written_here() {
    let bench = Bench::new();
    let run = bench.tmam(&sample("room_step.mcap"), "replay {}");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.is_empty(), "{}", run.stderr);
    let expected = ["room_step.features.json", "room_step.rrd"];
    assert!(bench.files().iter().eq(expected), "{:?}", bench.files());
    for said in ["frames", "2400", "contact", "rerun room_step.rrd", "0.36.3"] {
        assert!(run.stdout.contains(said), "no {said} in {}", run.stdout);
    }
}

#[test]
fn named_outputs_are_the_only_ones() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    assert_eq!(bench.tmam(&log, "replay {} --trace t.jsonl").code, 0);
    assert_eq!(bench.tmam(&log, "replay {} --no-recording").code, 0);
    let expected = ["room_step.features.json", "t.jsonl"];
    assert!(bench.files().iter().eq(expected), "{:?}", bench.files());
}

#[test]
fn standard_output_holds_the_output_and_nothing_else() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let run = bench.tmam(&log, "replay {} --features -");
    assert_eq!(run.code, 0);
    let features: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(features["schema"], "tmam.features/1");
    assert!(run.stderr.contains("frames"), "the summary goes elsewhere");
    let both = bench.tmam(&log, "replay {} --features - --trace -");
    assert_eq!(both.code, 2);
    assert!(both.stderr.contains("named twice"), "{}", both.stderr);
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn the_same_log_gives_the_same_bytes_on_any_number_of_threads() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    for (n, jobs) in [(1, 1), (2, 4), (3, 4)] {
        let outputs = format!("-o {n}.rrd --features {n}.json --trace {n}.jsonl");
        let arguments = format!("replay {{}} {outputs} --jobs {jobs}");
        assert_eq!(bench.tmam(&log, &arguments).code, 0);
    }
    for kind in ["rrd", "json", "jsonl"] {
        let [one, two, three] = [1, 2, 3].map(|n| bench.bytes(&format!("{n}.{kind}")));
        assert!(one == two && two == three, "{kind}");
        assert!(!one.is_empty());
    }
}

#[test]
fn order_compression_and_chunks_of_the_log_do_not_matter() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    assert_eq!(bench.tmam(&log, "replay {} --trace original.jsonl").code, 0);
    // Odometry and transforms at the very end, in small uncompressed chunks.
    let options = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(2000));
    let late = rewrite(&log, options, |mut message| {
        message.rank = u8::from(!message.topic.starts_with("/sonar"));
        vec![message]
    });
    let late = bench.put("late.mcap", late);
    assert_eq!(
        bench.tmam(&late, "replay {} --trace rewritten.jsonl").code,
        0
    );
    assert!(bench.bytes("original.jsonl") == bench.bytes("rewritten.jsonl"));
}

#[test]
fn a_trace_has_every_echo_once_in_order_and_adds_up() {
    let bench = Bench::new();
    let run = bench.tmam(
        &sample("room_step.mcap"),
        "replay {} --rule paper --trace t --features f",
    );
    assert_eq!(run.code, 0);
    let (rows, features) = (bench.json_lines("t"), bench.json("f"));
    let keys: Vec<(u64, &str)> = rows
        .iter()
        .map(|row| {
            (
                row["frame"].as_u64().unwrap(),
                row["sensor"].as_str().unwrap(),
            )
        })
        .collect();
    assert!(keys.is_sorted() && keys.windows(2).all(|pair| pair[0] != pair[1]));

    let counts = &features["counts"];
    for label in ["contact", "intersection", "unidentified"] {
        let n = rows.iter().filter(|row| row["label"] == label).count();
        assert_eq!(counts[label], n, "{label}");
    }
    assert_eq!(counts["echoes"], rows.len());
    for row in &rows {
        let labelled = row["label"] != "unidentified";
        assert_eq!(row["reason"].is_null(), labelled, "{row}");
        assert_eq!(row["feature"].is_number(), labelled, "{row}");
        let not_a_triple = ["missing", "gap", "turning"]
            .iter()
            .any(|r| row["reason"] == *r);
        assert_eq!(row["theta_c"].is_null(), not_a_triple, "{row}");
    }
    // A feature's run in the trace is what the feature says.
    for feature in features["features"].as_array().unwrap() {
        let run: Vec<&Value> = rows
            .iter()
            .filter(|r| r["feature"] == feature["id"])
            .collect();
        assert_eq!(feature["readings"].as_array().unwrap().len(), run.len() + 2);
        assert!(run.iter().all(|row| row["sensor"] == feature["sensor"]));
    }
}

#[test]
fn a_selected_sonar_keeps_its_frames_and_labels() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    assert_eq!(bench.tmam(&log, "replay {} --trace all").code, 0);
    assert_eq!(
        bench
            .tmam(&log, "replay {} --trace one --sensor sonar_0[45]")
            .code,
        0
    );
    let key = |row: &Value| {
        (
            row["frame"].clone(),
            row["sensor"].clone(),
            row["label"].clone(),
        )
    };
    let all: Vec<_> = bench
        .json_lines("all")
        .iter()
        .filter(|row| row["sensor"] == "sonar_04" || row["sensor"] == "sonar_05")
        .map(key)
        .collect();
    let one: Vec<_> = bench.json_lines("one").iter().map(key).collect();
    assert_eq!(all, one);
    assert!(!one.is_empty());
}

#[test]
fn a_window_keeps_what_lies_in_it() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    assert_eq!(
        bench
            .tmam(&log, "replay {} --trace t --start 10 --end 20")
            .code,
        0
    );
    let stamps: Vec<i64> = bench
        .json_lines("t")
        .iter()
        .map(|row| row["stamp_ns"].as_i64().unwrap())
        .collect();
    let span = stamps.iter().max().unwrap() - stamps.iter().min().unwrap();
    assert!((9_000_000_000..=10_000_000_000).contains(&span), "{span}");
}

#[test]
fn flags_stand_before_the_file_and_the_file_before_the_defaults() {
    let bench = Bench::new();
    bench.put("tmam.toml", "[triple]\nalpha = 0.4\ngamma = 8\n");
    let log = sample("room_step.mcap");
    let run = bench.tmam(&log, "replay {} --config tmam.toml --set triple.gamma=7 --set sequence.max_gap=4 --gamma 9 --features f");
    assert_eq!(run.code, 0);
    let used = &bench.json("f")["config"]["triple"];
    assert_eq!(used["alpha"], 0.4);
    assert_eq!(used["beta"], 2.0);
    assert!((used["gamma"].as_f64().unwrap() - 9_f64.to_radians()).abs() < 1e-15);

    assert_eq!(bench.json("f")["config"]["sequence"]["max_gap"], 4.0);

    let shown = bench.tmam(
        &log,
        "config --config tmam.toml --set sequence.max_gap=4 --gamma 9",
    );
    bench.put("shown.toml", shown.stdout);
    assert_eq!(
        bench
            .tmam(&log, "replay {} --config shown.toml --features g")
            .code,
        0
    );
    assert!(bench.bytes("f") == bench.bytes("g"));
}

#[test]
fn readings_without_a_stamp_take_the_time_they_were_recorded_at() {
    let bench = Bench::new();
    let log = sample("room_step.mcap");
    let unstamped = rewrite(&log, mcap::WriteOptions::new(), |mut message| {
        if message.topic.starts_with("/sonar") {
            message.data[4..12].fill(0);
        }
        vec![message]
    });
    let unstamped = bench.put("unstamped.mcap", unstamped);
    assert_eq!(bench.tmam(&log, "replay {} --trace a").code, 0);
    let run = bench.tmam(&unstamped, "replay {} --trace b");
    assert_eq!(run.code, 0);
    assert!(
        run.stderr.contains("no stamp in the header"),
        "{}",
        run.stderr
    );
    assert!(bench.bytes("a") == bench.bytes("b"));
}

/// Label counts of an independent implementation of the paper's rule.
#[test]
fn other_peoples_logs_give_the_labels_of_an_independent_implementation() {
    for (log, contact, intersection, unidentified) in [
        ("house_run1.mcap", 143, 40, 816),
        ("room_step_3mm.mcap", 220, 100, 898),
        ("room_drive_3mm.mcap", 169, 77, 645),
        ("encodings/ros2_humble_zstd.mcap", 179, 84, 628),
        ("encodings/ros2_jazzy_lz4.mcap", 179, 84, 628),
        ("encodings/rosbag2_jazzy.mcap", 179, 84, 628),
        ("encodings/ros1_lz4.mcap", 179, 84, 628),
        ("encodings/foxglove_protobuf.mcap", 179, 84, 628),
        ("encodings/foxglove_json.mcap", 179, 84, 628),
        ("encodings/special_values_ros2.mcap", 0, 0, 136),
    ] {
        let Some(path) = shared(log) else { continue };
        let bench = Bench::new();
        let run = bench.tmam(&path, "replay {} --rule paper --features f");
        assert_eq!(run.code, 0, "{}", run.stderr);
        let counts = &bench.json("f")["counts"];
        assert_eq!(counts["contact"], contact, "{log}");
        assert_eq!(counts["intersection"], intersection, "{log}");
        assert_eq!(counts["unidentified"], unidentified, "{log}");
    }
}

/// Poses and angles of a trace row, and what was decided; the chi-squared values depend on the
/// message's variance, which not every encoding has.
fn decided(row: &Value) -> ([&Value; 6], [Option<f64>; 6]) {
    let same = ["frame", "sensor", "stamp_ns", "label", "reason", "feature"];
    let close = ["x", "y", "yaw", "range", "theta_c", "theta_i"];
    (
        same.map(|key| &row[key]),
        close.map(|key| row[key].as_f64()),
    )
}

fn give_one_trace(logs: &[PathBuf]) {
    let mut first: Option<Vec<Value>> = None;
    for log in logs {
        let name = log.display();
        let bench = Bench::new();
        let run = bench.tmam(log, "replay {} --trace t");
        assert_eq!(run.code, 0, "{name}: {}", run.stderr);
        let rows = bench.json_lines("t");
        let first = first.get_or_insert_with(|| rows.clone());
        assert_eq!(rows.len(), first.len(), "{name}");
        for (row, expected) in rows.iter().zip(first) {
            let ((same, close), (same_expected, close_expected)) =
                (decided(row), decided(expected));
            assert_eq!(same, same_expected, "{name}");
            for pair in close.iter().zip(close_expected) {
                let (Some(a), Some(b)) = pair else {
                    assert!(pair.0.is_none() && pair.1.is_none(), "{name}: {row}");
                    continue;
                };
                assert!((a - b).abs() < 1e-6, "{name}: {row}, {expected}");
            }
        }
    }
}

#[test]
fn one_drive_gives_one_trace_in_every_encoding() {
    let encodings = [
        "ros2_jazzy_lz4",
        "ros2_humble_zstd",
        "rosbag2_jazzy",
        "ros1_lz4",
        "foxglove_protobuf",
        "foxglove_json",
    ];
    let logs = encodings.map(|encoding| shared(&format!("encodings/{encoding}.mcap")));
    give_one_trace(&logs.into_iter().flatten().collect::<Vec<_>>());
}

#[test]
fn one_drive_gives_one_trace_as_ros_1_and_as_ros_2() {
    let bench = Bench::new();
    // Ranges of ROS 1 have no variance, so here they are without noise.
    let made = bench.sh("tmam simulate -o ros2.mcap --sonars 8 --drive");
    assert_eq!(made.code, 0, "{}", made.stderr);
    let log = bench.path("ros2.mcap");
    let ros1 = bench.put("ros1.mcap", ros1(&log));
    give_one_trace(&[log, ros1]);
}

#[test]
fn a_log_that_needs_a_key_is_right_with_it_and_wrong_without() {
    let bench = Bench::new();
    let flags = "--drive --noise 0.003 --odometry-rate 10";
    let replayed = |log: &str, flags: &str| {
        let run = bench.sh(&format!(
            "tmam replay {log} --poses odometry --no-causes -q --features f.json {flags}"
        ));
        assert_eq!(run.code, 0, "{}", run.stderr);
        bench.json("f.json")
    };
    let map = |features: &serde_json::Value| -> Vec<(&'static str, Vec<f64>)> {
        let of = |kind: &'static str| {
            let all = features["map"][kind].as_array().unwrap().clone();
            all.into_iter().map(move |feature| {
                let keys = ["rho", "theta", "x", "y"].iter();
                let numbers = keys.filter_map(|key| feature[key].as_f64());
                (kind, numbers.collect())
            })
        };
        of("lines").chain(of("points")).collect()
    };
    let made = bench.sh(&format!("tmam simulate -o plain.mcap {flags}"));
    assert_eq!(made.code, 0, "{}", made.stderr);
    let plain = map(&replayed("plain.mcap", ""));
    for needs in [
        "input.range_delay=0.1",
        "input.range_clock_rate=0.01",
        "input.odometry_scale=1.02",
        "input.odometry_turn_scale=0.98",
        "sonars.range_scale=1.05",
        "sonars.range_offset=0.03",
    ] {
        let made = bench.sh(&format!(
            "tmam simulate -o off.mcap {flags} --needs {needs}"
        ));
        assert_eq!(made.code, 0, "{}", made.stderr);
        let mended = map(&replayed("off.mcap", &format!("--set {needs}")));
        assert_eq!(mended.len(), plain.len(), "{needs}: {mended:?} {plain:?}");
        for (is, was) in mended.iter().zip(&plain) {
            assert_eq!(is.0, was.0, "{needs}");
            for (is, was) in is.1.iter().zip(&was.1) {
                assert!((is - was).abs() < 0.005, "{needs}: {mended:?} {plain:?}");
            }
        }
        let off = map(&replayed("off.mcap", ""));
        let same = off.len() == plain.len()
            && off.iter().zip(&plain).all(|(is, was)| {
                is.1.iter()
                    .zip(&was.1)
                    .all(|(is, was)| (is - was).abs() < 0.005)
            });
        assert!(!same, "{needs}: {off:?}");
    }
    // A mount and a dead sonar touch one sonar alone.
    for (fault, key) in [
        (
            "--needs sonar.sonar_04.yaw=95",
            "--set sonar.sonar_04.yaw=95",
        ),
        (
            "--needs sonar.sonar_04.x=0.05",
            "--set sonar.sonar_04.x=0.05",
        ),
        ("--silent sonar_04", ""),
    ] {
        let made = bench.sh(&format!("tmam simulate -o off.mcap {flags} {fault}"));
        assert_eq!(made.code, 0, "{}", made.stderr);
        let mended = replayed("off.mcap", key);
        assert_eq!(map(&mended).len(), plain.len(), "{fault}");
    }
}

#[test]
fn what_a_simulated_log_cannot_need_is_refused() {
    let bench = Bench::new();
    for (fault, said) in [
        ("--needs triple.gamma=8", "--needs takes input.range_delay"),
        (
            "--needs sonar.sonar_04.beam_width=9",
            "--needs takes input.range_delay",
        ),
        ("--needs rule=papr", "--needs takes KEY=VALUE"),
        (
            "--needs sonar.front.yaw=3",
            "no sonar is called \"front\"; there are sonar_00, sonar_01,",
        ),
        ("--silent front", "no sonar is called \"front\""),
        // Nor can a sonar say less than nothing.
        ("--needs sonars.range_offset=0.5", "the smallest range"),
    ] {
        let run = bench.sh(&format!("tmam simulate -o no.mcap {fault}"));
        assert_eq!(run.code, 2, "{fault}");
        assert!(run.stderr.contains(said), "{fault}: {}", run.stderr);
    }
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

#[test]
fn frames_of_a_part_have_the_numbers_of_the_whole_run() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    let numbers = |name: &str, flags: &str| -> BTreeMap<(String, i64), u64> {
        let run = bench.tmam(&log, &format!("replay {{}} --trace {name} {flags}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let rows = bench.json_lines(name);
        let row = |row: &Value| {
            let sensor = row["sensor"].as_str().unwrap().to_owned();
            (
                (sensor, row["stamp_ns"].as_i64().unwrap()),
                row["frame"].as_u64().unwrap(),
            )
        };
        rows.iter().map(row).collect()
    };
    let (whole, part) = (numbers("whole", ""), numbers("part", "--start 30 --end 60"));
    let same = part
        .iter()
        .filter(|(arc, frame)| whole.get(*arc) == Some(frame))
        .count();
    // In the first frame another reading of a sonar may be the first of it.
    assert!(
        same + 16 >= part.len() && same > 300,
        "{same} of {}",
        part.len()
    );
    let first = part.values().min().unwrap();
    assert!((60..75).contains(first), "{first}");
    let run = bench.tmam(
        &log,
        "explain {} --sensor sonar_04 --frame 3 --start 30 --end 60",
    );
    let said = format!("the replay has frames {first} to ");
    assert!(run.stderr.contains(&said), "{}", run.stderr);
}
