//! Poses that are estimated with the features, from outside: the path, the recording, and an arc's story.

use std::path::PathBuf;

use crate::support::{Bench, sample};
use mcap::MessageStream;
use re_cdr::{CdrReader, LittleEndian};

/// A short drive along two walls and back whose odometry drifts.
fn drifting(bench: &Bench) -> PathBuf {
    let run = bench.sh(
        "tmam simulate -o d.mcap --drive --noise 0.003 --odometry-noise 0.02 --heading-noise 0.6 \
         --turn-noise 1 --sonars 8",
    );
    assert_eq!(run.code, 0, "{}", run.stderr);
    bench.path("d.mcap")
}

/// The poses of a TUM file: stamp in nanoseconds, x, y, and the sine and cosine of half the heading.
fn tum(text: &str) -> Vec<(i64, [f64; 4])> {
    let pose = |line: &str| {
        let fields: Vec<&str> = line.split(' ').collect();
        let [stamp, x, y, "0", "0", "0", qz, qw] = fields[..] else {
            panic!("eight fields, and a pose in the plane: {line}")
        };
        let (seconds, rest) = stamp.split_once('.').unwrap();
        assert_eq!(rest.len(), 9, "{line}");
        let stamp_ns = format!("{seconds}{rest}").parse().unwrap();
        (stamp_ns, [x, y, qz, qw].map(|value| value.parse().unwrap()))
    };
    text.lines().map(pose).collect()
}

/// The poses of an MCAP of `nav_msgs/Odometry`, in the same way, each with its covariance.
fn odometry(log: &[u8]) -> Vec<(i64, [f64; 4], [f64; 36])> {
    let pose = |message: mcap::Message<'_>| {
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(schema.name, "nav_msgs/msg/Odometry");
        let mut reader = CdrReader::<LittleEndian>::new(&message.data[4..]);
        let seconds = i64::from(reader.read_i32().unwrap());
        let stamp_ns = seconds * 1_000_000_000 + i64::from(reader.read_u32().unwrap());
        assert_eq!(reader.read_str().unwrap(), "odom");
        assert_eq!(reader.read_str().unwrap(), "base_link");
        let mut next = || reader.read_f64().unwrap();
        let [x, y, _z, _qx, _qy, qz, qw] = std::array::from_fn(|_| next());
        let covariance = std::array::from_fn(|_| next());
        (stamp_ns, [x, y, qz, qw], covariance)
    };
    let messages = MessageStream::new(log).unwrap();
    messages.map(|message| pose(message.unwrap())).collect()
}

#[test]
fn the_path_is_the_same_in_both_formats_and_odometry_s_where_that_is_asked_for() {
    let bench = Bench::new();
    let log = drifting(&bench);
    for (arguments, path) in [
        ("", "joint.tum"),
        ("", "joint.mcap"),
        ("", "again.mcap"),
        ("--poses odometry", "odometry.txt"),
        ("--poses odometry", "odometry.mcap"),
    ] {
        let run = bench.tmam(&log, &format!("replay {{}} -q {arguments} --path {path}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let text = |name: &str| tum(&String::from_utf8(bench.bytes(name)).unwrap());
    let (joint, odom) = (text("joint.tum"), text("odometry.txt"));
    assert!(joint.len() > 100);
    assert!(bench.bytes("joint.mcap") == bench.bytes("again.mcap"));
    for (name, poses) in [("joint.mcap", &joint), ("odometry.mcap", &odom)] {
        let messages = odometry(&bench.bytes(name));
        assert_eq!(messages.len(), poses.len(), "{name}");
        for ((stamp_ns, pose, _), (known_ns, known)) in messages.iter().zip(poses) {
            assert_eq!(stamp_ns, known_ns);
            for (a, b) in pose.iter().zip(known) {
                assert!((a - b).abs() < 1e-9, "{name}: {pose:?} {known:?}");
            }
        }
        let known = messages
            .iter()
            .filter(|(.., covariance)| covariance[0] > 0.0);
        assert_eq!(known.count() > 100, name == "joint.mcap", "{name}");
    }
    assert_eq!(joint[0], odom[0], "the first pose is odometry's");
    let pairs = joint.iter().zip(&odom);
    let apart = pairs.map(|((_, a), (_, b))| libm::hypot(a[0] - b[0], a[1] - b[1]));
    assert!(apart.fold(0.0, f64::max) > 0.01);
    let info = bench.tmam(&bench.path("joint.mcap"), "info {} --no-causes");
    assert!(info.stdout.contains("/tmam/odom"), "{}", info.stdout);
}

#[test]
fn of_a_part_of_the_log_the_path_is_of_that_part() {
    let bench = Bench::new();
    let run = |arguments: &str, path: &str| {
        let replay = format!("replay {{}} -q --poses odometry {arguments} --path {path}");
        let run = bench.tmam(&sample("room_drive.mcap"), &replay);
        assert_eq!(run.code, 0, "{}", run.stderr);
        tum(&String::from_utf8(bench.bytes(path)).unwrap())
    };
    let (whole, part) = (run("", "whole.tum"), run("--start 20 --end 30", "part.tum"));
    let (first, last) = (part[0], part[part.len() - 1]);
    let seconds = (last.0 - first.0) as f64 * 1e-9;
    assert!((9.5..10.0).contains(&seconds), "{seconds}");
    assert!(whole.contains(&first) && whole.contains(&last));
}

#[test]
fn a_path_that_is_no_path_is_refused_before_anything_is_read() {
    let bench = Bench::new();
    let run = bench.tmam(&sample("room_step.mcap"), "replay {} --path p.csv");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains(".tum, .txt or .mcap"), "{}", run.stderr);
    assert!(bench.files().is_empty());
}

#[test]
fn an_arc_s_story_says_how_its_pose_was_moved() {
    let bench = Bench::new();
    let log = drifting(&bench);
    let said = |arguments: &str| {
        let asked = format!("explain {{}} --time 60 --sensor sonar_00 {arguments}");
        bench.tmam(&log, &asked).stdout
    };
    assert!(
        said("").contains("Its pose: odometry's, moved by"),
        "{}",
        said("")
    );
    let told: serde_json::Value = serde_json::from_str(&said("--json")).unwrap();
    let pose = &told["pose"];
    assert!(pose["moved"].as_f64().unwrap() > 0.001, "{pose}");
    assert!(pose["sigma"].as_f64().unwrap() > 0.0, "{pose}");
    assert!(!said("--poses odometry").contains("Its pose"));
}
