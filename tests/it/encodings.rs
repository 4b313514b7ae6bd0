//! Logs in other encodings and types, from outside: each is made from a sample log.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::PathBuf;

use crate::support::{Bench, sample};
use serde_json::{Value, json};

/// One channel's encoding and schema: message encoding, type name, schema encoding, schema.
type Kind = (&'static str, &'static str, &'static str, &'static [u8]);

const SCAN: Kind = ("json", "foxglove.LaserScan", "jsonschema", b"{}");
const TRANSFORMS: Kind = ("json", "foxglove.FrameTransforms", "jsonschema", b"{}");
const POSE: Kind = ("json", "foxglove.PoseInFrame", "jsonschema", b"{}");
const PLAIN: Kind = ("json", "", "", b"");

/// A log made of messages: topic, kind, time and content.
fn log(messages: &[(&str, Kind, i64, Vec<u8>)]) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .create(Cursor::new(Vec::new()))
        .unwrap();
    for (topic, (encoding, name, schema_encoding, schema), time, data) in messages {
        let schema = match schema_encoding.len() + name.len() {
            0 => 0,
            _ => writer.add_schema(name, schema_encoding, schema).unwrap(),
        };
        let channel_id = writer
            .add_channel(schema, topic, encoding, &BTreeMap::new())
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: *time as u64,
            publish_time: *time as u64,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn bytes(value: Value) -> Vec<u8> {
    value.to_string().into_bytes()
}

fn stamp(time: i64) -> Value {
    json!({"sec": time / 1_000_000_000, "nsec": time % 1_000_000_000})
}

/// A robot that drives a metre a second past a wall on its left, in JSON.
fn drive(ranges: impl Fn(i64) -> (Kind, Vec<u8>)) -> Vec<(&'static str, Kind, i64, Vec<u8>)> {
    let turn = json!({"x": 0, "y": 0, "z": 0, "w": 1});
    let edge = |parent: &str, child: &str, x: f64| {
        json!({"timestamp": stamp(1), "parent_frame_id": parent, "child_frame_id": child,
            "translation": {"x": x, "y": 0, "z": 0}, "rotation": turn})
    };
    let edges = bytes(json!({"transforms": [edge("base", "ring", 0.1)]}));
    let mut messages = vec![("/tf_static", TRANSFORMS, 1, edges)];
    for step in 0..60 {
        let time = 1_000_000_000 + step * 100_000_000;
        let at = json!({"position": {"x": step as f64 * 0.1, "y": 0, "z": 0}, "orientation": turn});
        let pose = json!({"timestamp": stamp(time), "frame_id": "odom", "pose": at});
        messages.push(("/pose", POSE, time, bytes(pose)));
        let (kind, data) = ranges(time);
        messages.push(("/ranges", kind, time, data));
    }
    messages
}

/// A ring of three beams, to the front left, left and rear left; the wall is 1.5 m away.
fn ring(time: i64) -> (Kind, Vec<u8>) {
    let slant = 1.5 * std::f64::consts::SQRT_2;
    let scan = json!({"timestamp": stamp(time), "frame_id": "ring",
        "start_angle": std::f64::consts::FRAC_PI_4, "end_angle": 3.0 * std::f64::consts::FRAC_PI_4,
        "ranges": [slant, 1.5, null]});
    (SCAN, bytes(scan))
}

fn sensors(bench: &Bench) -> Vec<(String, f64)> {
    let mut sensors: Vec<(String, f64)> = bench
        .json_lines("t")
        .iter()
        .map(|row| {
            (
                row["sensor"].as_str().unwrap().to_owned(),
                row["yaw"].as_f64().unwrap().to_degrees().round(),
            )
        })
        .collect();
    sensors.sort_by(|a, b| a.0.cmp(&b.0));
    sensors.dedup();
    sensors
}

#[test]
fn a_scan_is_a_ring_of_sonars_on_the_frame_that_carries_them() {
    let bench = Bench::new();
    let path = bench.put("ring.mcap", log(&drive(ring)));
    let run = bench.tmam(&path, "replay {} --trace t");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("`base` is taken"), "{}", run.stderr);
    let expected = [("ring[0]".to_owned(), 45.0), ("ring[1]".to_owned(), 90.0)];
    assert_eq!(sensors(&bench), expected);

    // One mount for the ring, or one for a beam.
    bench.put(
        "tmam.toml",
        "[sonar.ring]\nx = 0\ny = 0\nyaw = 10\n[sonar.'ring[1]']\nx = 0\ny = 0\nyaw = 80\n",
    );
    let run = bench.tmam(&path, "replay {} --trace t --config tmam.toml");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let expected = [("ring[0]".to_owned(), 55.0), ("ring[1]".to_owned(), 80.0)];
    assert_eq!(sensors(&bench), expected);
}

#[test]
fn a_ring_of_points_says_what_it_lacks_and_works_with_that() {
    let cloud = |time: i64| {
        let points = json!([{"x": 0, "y": 1.5, "z": 0}, {"x": 2, "y": 0, "z": 0}]);
        let cloud = json!({"header": {"stamp": stamp(time), "frame_id": "base"}, "points": points});
        let kind: Kind = ("json", "sensor_msgs/PointCloud", "jsonschema", b"{}");
        (kind, bytes(cloud))
    };
    let bench = Bench::new();
    let path = bench.put("cloud.mcap", log(&drive(cloud)));
    let run = bench.tmam(&path, "replay {} --trace t");
    assert_eq!(run.code, 2, "{}", run.stderr);
    for said in [
        "the points on /ranges do not say",
        "of the 2 in",
        "[sonar.\"sonar_00\"]",
        "yaw = 90.0",
    ] {
        assert!(run.stderr.contains(said), "{said}: {}", run.stderr);
    }
    let info = bench.tmam(&path, "info {}");
    assert_eq!(info.code, 3, "{}", info.stdout);
    assert!(
        info.stdout.contains("the points on /ranges do not"),
        "{}",
        info.stdout
    );
    let skeleton = bench.tmam(&path, "info {} --skeleton").stdout;
    bench.put("tmam.toml", skeleton);
    let run = bench.tmam(&path, "replay {} --trace t --config tmam.toml");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let expected = [("sonar_00".to_owned(), 90.0), ("sonar_01".to_owned(), 0.0)];
    assert_eq!(sensors(&bench), expected);
}

#[test]
fn a_time_may_be_text() {
    let with_text = |time: i64| {
        let (kind, data) = ring(time);
        let mut scan: Value = serde_json::from_slice(&data).unwrap();
        scan["timestamp"] = format!(
            "1970-01-01T00:00:{:02}.{:09}Z",
            time / 1_000_000_000,
            time % 1_000_000_000
        )
        .into();
        (kind, bytes(scan))
    };
    let bench = Bench::new();
    let path = bench.put("log.mcap", log(&drive(ring)));
    assert_eq!(bench.tmam(&path, "replay {} --trace a").code, 0);
    let path = bench.put("log.mcap", log(&drive(with_text)));
    let run = bench.tmam(&path, "replay {} --trace b");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(bench.bytes("a"), bench.bytes("b"));
}

#[test]
fn a_lidar_is_no_sonar_ring_unless_it_is_asked_for() {
    let scan = |time: i64| {
        let scan = json!({"timestamp": stamp(time), "frame_id": "ring", "start_angle": -1.5,
            "end_angle": 1.5, "ranges": vec![2.0; 65]});
        (SCAN, bytes(scan))
    };
    let bench = Bench::new();
    let path = bench.put("lidar.mcap", log(&drive(scan)));
    let refused = bench.tmam(&path, "replay {} --trace t");
    assert_eq!(refused.code, 2);
    for said in ["65 ranges", "a lidar's", "--range-topic"] {
        assert!(refused.stderr.contains(said), "{}", refused.stderr);
    }
    let arguments = "replay {} --trace t --range-topic /ranges --gamma 1";
    let run = bench.tmam(&path, arguments);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(sensors(&bench).len(), 65);
}

#[test]
fn a_scan_in_degrees_is_the_ring_that_it_is_in_radians_and_told() {
    let in_degrees = |time| {
        let (kind, scan) = ring(time);
        let mut scan: serde_json::Value = serde_json::from_slice(&scan).unwrap();
        for angle in ["start_angle", "end_angle"] {
            scan[angle] = scan[angle].as_f64().unwrap().to_degrees().into();
        }
        (kind, bytes(scan))
    };
    let bench = Bench::new();
    for (name, ring) in [
        ("radians.mcap", log(&drive(ring))),
        ("degrees.mcap", log(&drive(in_degrees))),
    ] {
        let path = bench.put(name, ring);
        let run = bench.tmam(&path, "replay {} --trace t --no-causes");
        assert_eq!(run.code, 0, "{}", run.stderr);
        let yaws: Vec<f64> = sensors(&bench).iter().map(|(_, yaw)| *yaw).collect();
        assert_eq!(yaws, [45.0, 90.0], "{name}");
        let info = bench.tmam(&path, "info {} --no-causes").stdout;
        let said = "scans span more than a turn in radians (all 3 sonars)";
        assert_eq!(info.contains(said), name == "degrees.mcap", "{info}");
    }
}

#[test]
fn a_sonar_that_is_not_read_is_a_loss_and_a_camera_is_none() {
    let idl = |name: &'static str| -> Kind { ("cdr", name, "ros2idl", b"module m {};") };
    let xcdr2: Kind = ("cdr", "sensor_msgs/msg/Range", "", b"");
    let bench = Bench::new();
    let with = |others: &[(&'static str, Kind, Vec<u8>)]| {
        let mut messages = drive(ring);
        messages
            .extend((others.iter()).map(|(topic, kind, data)| (*topic, *kind, 5, data.clone())));
        bench.put("log.mcap", log(&messages))
    };
    let path = with(&[
        ("/idl", idl("sensor_msgs/msg/Range"), vec![0, 1, 0, 0]),
        ("/xcdr2", xcdr2, vec![0, 7, 0, 0]),
    ]);
    let run = bench.tmam(&path, "replay {} --features f");
    assert_eq!(run.code, 3, "{}", run.stderr);
    for said in [
        "/idl, 1 message: left out, since its type is defined in IDL",
        "/xcdr2, 1 message: left out",
        "not plain CDR",
    ] {
        assert!(run.stderr.contains(said), "no {said}: {}", run.stderr);
    }
    let source = &bench.json("f")["source"];
    assert_eq!(
        (
            &source["complete"],
            source["lost"].as_array().unwrap().len()
        ),
        (&json!(false), 2)
    );
    assert_eq!(bench.tmam(&path, "replay {} --strict").code, 2);
    let info = bench.tmam(&path, "info {}");
    assert_eq!(info.code, 3, "{}", info.stdout);
    assert!(info.stdout.contains("INCOMPLETE"), "{}", info.stdout);
    assert!(
        !info.stdout.contains("the log is not whole"),
        "{}",
        info.stdout
    );
    // Whoever leaves them out loses nothing.
    assert_eq!(
        bench
            .tmam(&path, "replay {} --range-topic /ranges --features f")
            .code,
        0
    );

    let path = with(&[
        ("/camera", idl("sensor_msgs/msg/Image"), vec![0, 1, 0, 0]),
        ("/laser", idl("sensor_msgs/msg/LaserScan"), vec![0, 1, 0, 0]),
    ]);
    let run = bench.tmam(&path, "replay {} --features f");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        run.stderr.contains("/laser is left out: its type"),
        "{}",
        run.stderr
    );
    assert!(!run.stderr.contains("/camera"), "{}", run.stderr);
    assert_eq!(bench.tmam(&path, "info {}").code, 0);
    // Asked for, it is missing.
    let run = bench.tmam(
        &path,
        "replay {} --range-topic /{ranges,laser} --features f",
    );
    assert_eq!(run.code, 3, "{}", run.stderr);
}

#[test]
fn a_type_that_the_file_does_not_say_is_named_in_the_configuration() {
    let bench = Bench::new();
    let file = std::fs::read(sample("room_step.mcap")).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&file)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let bare: Vec<_> = (messages.iter())
        .filter(|m| m.channel.message_encoding == "cdr")
        .map(|m| {
            let name = match m.channel.schema.as_ref().unwrap().name.as_str() {
                "nav_msgs/msg/Odometry" => "nav_msgs/msg/Odometry",
                "tf2_msgs/msg/TFMessage" => "tf2_msgs/msg/TFMessage",
                _ => "",
            };
            let topic = m.channel.topic.as_str();
            (
                topic,
                ("cdr", name, "", &b""[..]) as Kind,
                m.log_time as i64,
                m.data.to_vec(),
            )
        })
        .collect();
    let path = bench.put("bare.mcap", log(&bare));
    let said = "[channel.\"/topic\"] type = \"sensor_msgs/msg/Range\"";
    let run = bench.tmam(&path, "replay {} --features f");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains(said), "{}", run.stderr);
    assert_eq!(run.stderr.matches(said).count(), 1, "{}", run.stderr);
    assert!(
        run.stderr
            .contains("/sonar/sonar_01 (no type, cdr, 150 messages: likewise)"),
        "{}",
        run.stderr
    );
    let types: String = (0..16)
        .map(|k| format!("[channel.\"/sonar/sonar_{k:02}\"]\ntype = \"sensor_msgs/msg/Range\"\n"))
        .collect();
    bench.put("tmam.toml", &types);
    let run = bench.tmam(&path, "replay {} --config tmam.toml --features f");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(bench.json("f")["counts"]["readings"], 2400);
    bench.put("tmam.toml", types.replace("msg/Range", "msg/Rang"));
    let run = bench.tmam(&path, "replay {} --config tmam.toml --features f");
    assert_eq!(run.code, 2);
    assert!(
        run.stderr
            .contains("`sensor_msgs/msg/Rang`, which the configuration says"),
        "{}",
        run.stderr
    );
}

#[test]
fn messages_of_unknown_types_are_read_by_field_paths() {
    let bench = Bench::new();
    let own = |time: i64| {
        let data = bytes(json!({"t": time / 1_000_000, "cm": [150, 140]}));
        (PLAIN, data)
    };
    let path = bench.put("own.mcap", log(&drive(own)));
    let refused = bench.tmam(&path, "replay {} --trace t");
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("[channel."), "{}", refused.stderr);
    bench.put(
        "tmam.toml",
        "[channel.'/ranges']\nrange = 'cm'\nmetres_per_unit = 0.01\nstamp = 't'\nstamp_unit = 'ms'\n\
         frame_name = 'ring'\nbeam_width = 25\n[sonar.'ring[0]']\nx = 0\ny = 0.1\nyaw = 90\n\
         [sonar.'ring[1]']\nx = 0\ny = -0.1\nyaw = -90\n[input]\nrobot_frame = 'base'\n",
    );
    let run = bench.tmam(&path, "replay {} --trace t --config tmam.toml");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let rows = bench.json_lines("t");
    assert_eq!(rows[0]["range"], 1.5);
    let expected = [("ring[0]".to_owned(), 90.0), ("ring[1]".to_owned(), -90.0)];
    assert_eq!(sensors(&bench), expected);
}

#[test]
fn standard_types_need_no_definition() {
    let bench = Bench::new();
    let original: PathBuf = sample("room_step.mcap");
    let file = std::fs::read(&original).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&file)
        .unwrap()
        .map(Result::unwrap)
        .filter(|m| m.channel.message_encoding == "cdr")
        .collect();
    let bare: Vec<_> = messages
        .iter()
        .map(|m| {
            let name = match m.channel.schema.as_ref().unwrap().name.as_str() {
                "sensor_msgs/msg/Range" => "sensor_msgs/msg/Range",
                "nav_msgs/msg/Odometry" => "nav_msgs/msg/Odometry",
                _ => "tf2_msgs/msg/TFMessage",
            };
            let kind: Kind = ("cdr", name, "", b"");
            (
                m.channel.topic.as_str(),
                kind,
                m.log_time as i64,
                m.data.to_vec(),
            )
        })
        .collect();
    let path = bench.put("bare.mcap", log(&bare));
    assert_eq!(
        bench
            .tmam(&original, "replay {} --rule paper --trace a")
            .code,
        0
    );
    let run = bench.tmam(&path, "replay {} --rule paper --trace b");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let labels = |name: &str| -> Vec<Value> {
        let rows = bench.json_lines(name);
        rows.iter().map(|row| row["label"].clone()).collect()
    };
    assert_eq!(labels("a"), labels("b"));
}

#[test]
fn one_odd_message_costs_itself_alone() {
    // A scan of a lidar amid those of a ring, and a pose that is none.
    let mut messages = drive(ring);
    let scan = json!({"timestamp": stamp(2_000_000_001), "frame_id": "ring", "start_angle": -1.5,
        "end_angle": 1.5, "ranges": vec![2.0; 1000]});
    let pose = json!({"timestamp": stamp(2_000_000_001), "frame_id": "odom", "pose": {
        "position": {"x": "NaN", "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}});
    messages.push(("/ranges", SCAN, 2_000_000_001, bytes(scan)));
    messages.push(("/pose", POSE, 2_000_000_001, bytes(pose)));
    let bench = Bench::new();
    let path = bench.put("log.mcap", log(&messages));
    let run = bench.tmam(&path, "replay {} --features f");
    assert_eq!(run.code, 3, "{}", run.stderr);
    for said in [
        "1 of 61 messages on /ranges: a message of it holds 1000 ranges",
        "1 odometry message on /pose without a pose",
    ] {
        assert!(run.stderr.contains(said), "no {said}: {}", run.stderr);
    }
    assert_eq!(bench.json("f")["counts"]["readings"], 180);
}

#[test]
fn a_name_is_one_short_line_wherever_it_is_shown() {
    let named = |name: &str| {
        let name = name.to_owned();
        let mut messages = drive(move |time| {
            let mut scan = json!({"timestamp": stamp(time), "start_angle": 1.5, "end_angle": 1.6,
                "ranges": [1.5]});
            scan["frame_id"] = name.clone().into();
            (SCAN, bytes(scan))
        });
        messages.retain(|(topic, ..)| *topic != "/tf_static");
        log(&messages)
    };
    let bench = Bench::new();
    bench.put("tmam.toml", "[input]\nrobot_frame = 'base'\n");
    let path = bench.put("evil.mcap", named("base\n::error::x\u{1b}[2J\u{202e}"));
    let path_of_long = bench.put("long.mcap", named(&"x".repeat(1_000_000)));
    for path in [&path, &path_of_long] {
        let run = bench.tmam(path, "replay {} --config tmam.toml");
        assert_eq!(run.code, 2, "{}", run.stderr);
        let shown = run.stderr;
        assert!(
            !shown.contains(['\u{1b}', '\u{202e}']) && shown.len() < 4000,
            "{shown}"
        );
        assert!(!shown.contains("\n::error"), "{shown}");
    }
}
