//! `tmam info`: what it tells of sample logs, hopeless logs and damaged ones, and that the
//! configuration it proposes is enough to replay them.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test that meets something unexpected should fail on the spot"
)]

mod support;

use std::f32::consts::FRAC_PI_8;
use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use support::{Bench, Message, rewrite, sample, shared, without};

/// What `--json` says, and the exit code.
fn told(bench: &Bench, log: &Path, arguments: &str) -> (Value, i32) {
    let run = bench.tmam(log, &format!("info {{}} --json {arguments}"));
    assert_eq!(run.stderr, "");
    (serde_json::from_str(&run.stdout).unwrap(), run.code)
}

/// As files have it.
fn quarter_turn() -> f64 {
    (FRAC_PI_2 * 1e9).round() / 1e9
}

fn codes<'a>(info: &'a Value, weight: &str) -> Vec<&'a str> {
    let findings = info["findings"].as_array().unwrap();
    let of_weight = findings.iter().filter(|f| f["weight"] == weight);
    of_weight.map(|f| f["code"].as_str().unwrap()).collect()
}

fn put(bench: &Bench, bytes: Vec<u8>) -> PathBuf {
    bench.put("log.mcap", bytes)
}

fn changed(log: &str, change: impl Fn(Message) -> Vec<Message>) -> Vec<u8> {
    rewrite(&sample(log), mcap::WriteOptions::new(), change)
}

/// A log that cannot be replayed for a reason, and can with the skeleton.
fn mended(bytes: Vec<u8>, blocking: &[&str], skeleton: &[&str]) {
    let bench = Bench::new();
    let log = put(&bench, bytes);
    assert_ne!(bench.tmam(&log, "replay {} --features f").code, 0);
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(info["replay"]["possible"], "with-skeleton", "{info:#}");
    assert_eq!(codes(&info, "blocking"), blocking);

    let text = bench.tmam(&log, "info {}").stdout;
    assert!(
        text.lines().all(|line| line.chars().count() <= 100),
        "{text}"
    );
    let printed = bench.tmam(&log, "info {} --skeleton");
    assert_eq!(
        (printed.code, printed.stdout.as_str()),
        (3, info["skeleton"].as_str().unwrap())
    );
    for words in skeleton {
        assert!(
            printed.stdout.contains(words),
            "no {words:?} in {}",
            printed.stdout
        );
    }
    bench.put("tmam.toml", &printed.stdout);
    let run = bench.tmam(&log, "replay {} --config tmam.toml --features f");
    assert_eq!(run.code, 0, "{}\n{}", run.stderr, printed.stdout);
    assert_eq!(
        bench.json("f")["counts"]["frames"],
        info["replay"]["counts"]["frames"]
    );
    // With what it asked for, nothing stands in the way any more.
    let (info, code) = told(&bench, &log, "--config tmam.toml");
    assert_eq!(
        (code, &info["replay"]["possible"]),
        (0, &Value::from("yes"))
    );
    assert!(codes(&info, "blocking").is_empty());
}

#[test]
fn a_good_log_is_told_in_full() {
    let bench = Bench::new();
    let log = sample("room_drive.mcap");
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 0);
    assert_eq!(info["schema"], "tmam.info/1");
    assert_eq!(info["replay"]["possible"], "yes");
    assert_eq!(info["skeleton"], Value::Null);
    assert_eq!(codes(&info, "blocking"), Vec::<&str>::new());
    assert_eq!(info["channels"].as_array().unwrap().len(), 21);
    let sonar = &info["sonars"][4];
    assert_eq!(sonar["name"], "sonar_04");
    assert_eq!(sonar["mount"]["yaw"], quarter_turn());
    assert_eq!(sonar["beam_width"], 0.392699093);
    assert_eq!(sonar["readings"], 179);
    assert_eq!(sonar["resolution"]["quantised"], false);
    assert_eq!(info["odometry"]["samples"], 1001);
    assert_eq!(info["odometry"]["readings_with_pose"], 2857);
    assert!((info["odometry"]["distance"].as_f64().unwrap() - 18.0).abs() < 0.1);

    bench.tmam(&log, "replay {} --features f");
    let features = bench.json("f");
    for count in [
        "frames",
        "echoes",
        "contact",
        "intersection",
        "unidentified",
    ] {
        assert_eq!(info["replay"]["counts"][count], features["counts"][count]);
    }
    let again = bench.tmam(&log, "info {} --json");
    let json = bench.tmam(&log, "info {} --json");
    assert_eq!(again.stdout, json.stdout);
}

#[test]
fn text_keeps_within_a_hundred_columns() {
    let bench = Bench::new();
    for log in ["room_drive.mcap", "room_step.mcap"] {
        let run = bench.tmam(&sample(log), "info {}");
        assert_eq!(run.code, 0, "{}", run.stderr);
        for line in run.stdout.lines() {
            assert!(line.chars().count() <= 100, "{line}");
            assert_eq!(line, line.trim_end());
        }
        for title in [
            "CHANNELS", "SONARS", "ECHOES", "ODOMETRY", "CLOCKS", "FINDINGS",
        ] {
            assert!(
                run.stdout.contains(&format!("\n{title}\n")),
                "{}",
                run.stdout
            );
        }
    }
}

#[test]
fn no_mounts() {
    mended(
        without(&sample("room_step.mcap"), &["/tf"]),
        &["no-mount"],
        &[
            "[sonar.\"sonar_00\"]",
            "[sonar.\"sonar_15\"]",
            "x = 0.0",
            "measure these",
            "`base_link`",
        ],
    );
    let bench = Bench::new();
    let log = put(&bench, without(&sample("room_step.mcap"), &["/tf_static"]));
    let (info, _) = told(&bench, &log, "");
    assert_eq!(info["sonars"][0]["mount"], Value::Null);
    assert_eq!(info["sonars"][0]["readings"], 150);
    assert_eq!(codes(&info, "blocking"), ["no-mount"]);
    let finding = &info["findings"][0]["what"];
    assert!(
        finding.as_str().unwrap().contains("all 16 sonars"),
        "{finding}"
    );
}

#[test]
fn two_odometries() {
    let doubled = changed("room_step.mcap", |message| {
        let copy = Message {
            topic: "/wheel[odom]".into(),
            log_time: message.log_time,
            data: message.data.clone(),
            rank: 0,
        };
        match message.topic.as_str() {
            "/odom" if message.log_time % 2 == 0 => vec![copy, message],
            _ => vec![message],
        }
    });
    mended(
        doubled,
        &["many-odometries"],
        &["odometry_topics = [\"/odom\"]", "/wheel[odom]"],
    );
}

#[test]
fn no_beam_width_and_no_mounts_at_once() {
    let blind = changed("room_step.mcap", |mut message| {
        if message.topic.starts_with("/sonar") {
            // Behind header and radiation type: field_of_view, aligned to four bytes.
            let at = 4 + 8 + 4 + "sonar_00".len() + 1 + 3;
            let value: [u8; 4] = message.data[at..at + 4].try_into().unwrap();
            assert!((f32::from_le_bytes(value) - FRAC_PI_8).abs() < 1e-3);
            message.data[at..at + 4].copy_from_slice(&0f32.to_le_bytes());
        }
        if message.topic.starts_with("/tf") {
            Vec::new()
        } else {
            vec![message]
        }
    });
    mended(
        blind,
        &["no-mount", "no-beam-width"],
        &["[sonars]\nbeam_width = 22.5", "data sheet", "yaw = 0.0"],
    );
}

#[test]
fn odometry_that_is_too_slow() {
    let slow = changed("room_step.mcap", |message| {
        let second = message.log_time / 1_000_000_000;
        let keep = message.topic != "/odom" || second % 8 == 0;
        if keep { vec![message] } else { Vec::new() }
    });
    let bench = Bench::new();
    let log = put(&bench, slow);
    let (info, _) = told(&bench, &log, "");
    assert_eq!(
        codes(&info, "serious").first(),
        Some(&"no-pose"),
        "{info:#}"
    );
    let skeleton = info["skeleton"].as_str().unwrap();
    assert!(
        skeleton.contains("[frames]\nmax_odometry_gap = "),
        "{skeleton}"
    );
    bench.put("tmam.toml", skeleton);
    let before = bench.tmam(&log, "replay {} --features f --trace t");
    let dropped = bench.json("f")["counts"]["dropped"]["odometry-gap"].as_u64();
    assert!(dropped.unwrap() > 1000, "{}", before.stderr);
    bench.tmam(&log, "replay {} --config tmam.toml --features f");
    assert_eq!(
        bench.json("f")["counts"]["dropped"]["odometry-gap"],
        Value::Null
    );
}

#[test]
fn a_gate_wider_than_the_beam() {
    let bench = Bench::new();
    let made = bench.tmam(Path::new(""), "simulate -o narrow.mcap --beam-width 8");
    assert_eq!(made.code, 0, "{}", made.stderr);
    let log = bench.path("narrow.mcap");
    // Where angles do not decide, the gate is nothing to fail over.
    assert_eq!(bench.tmam(&log, "replay {} --features f").code, 0);
    assert_eq!(
        bench.tmam(&log, "replay {} --rule paper --features f").code,
        2
    );
    let (info, code) = told(&bench, &log, "--rule paper");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["gamma-beyond-beam"]);
    let skeleton = info["skeleton"].as_str().unwrap();
    assert!(skeleton.contains("[triple]\ngamma = "), "{skeleton}");
    bench.put("tmam.toml", skeleton);
    let (info, code) = told(&bench, &log, "--rule paper --config tmam.toml");
    assert_eq!(
        (code, &info["replay"]["possible"]),
        (0, &Value::from("yes"))
    );
}

#[test]
fn what_no_configuration_can_mend_is_still_shown() {
    let bench = Bench::new();
    let sample_log = sample("room_step.mcap");
    let unmoved = rewrite(
        &sample_log,
        mcap::WriteOptions::new(),
        |message| match message.topic.as_str() {
            "/odom" | "/tf" => Vec::new(),
            _ => vec![message],
        },
    );
    let log = put(&bench, unmoved);
    let (info, code) = told(&bench, &log, "");
    assert_eq!((code, &info["replay"]["possible"]), (3, &Value::from("no")));
    assert_eq!(codes(&info, "blocking"), ["no-odometry"]);
    assert_eq!(info["odometry"], Value::Null);
    assert_eq!(info["sonars"][4]["mount"]["yaw"], quarter_turn());
    assert_eq!(info["sonars"].as_array().unwrap().len(), 16);

    let log = put(&bench, without(&sample("room_step.mcap"), &["/sonar"]));
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["no-ranges"]);
    assert_eq!(info["odometry"]["samples"], 150);
    assert_eq!(info["sonars"].as_array().unwrap().len(), 0);

    let log = put(&bench, without(&sample("room_step.mcap"), &["/"]));
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["no-ranges", "no-odometry"]);
    assert_eq!(bench.tmam(&log, "info {}").code, 3);
}

#[test]
fn clocks_that_do_not_meet_and_stamps_that_are_missing() {
    let bench = Bench::new();
    let shifted = changed("room_step.mcap", |mut message| {
        if message.topic == "/odom" {
            message.shift_stamp(3600);
        }
        vec![message]
    });
    let (info, code) = told(&bench, &put(&bench, shifted), "");
    assert_eq!((code, &info["replay"]["possible"]), (3, &Value::from("no")));
    assert_eq!(codes(&info, "blocking"), ["no-frames"]);
    assert!(codes(&info, "serious").contains(&"clock-skew"));

    let unstamped = changed("room_step.mcap", |mut message| {
        if message.topic.starts_with("/sonar") {
            message.data[4..12].fill(0);
        }
        vec![message]
    });
    let (info, code) = told(&bench, &put(&bench, unstamped), "");
    assert_eq!(code, 0);
    assert_eq!(codes(&info, "serious"), ["unstamped"]);
    assert_eq!(codes(&info, "notable"), Vec::<&str>::new());
}

#[test]
fn a_log_that_is_not_whole_or_not_a_log() {
    let whole = fs::read(sample("room_drive.mcap")).unwrap();
    let bench = Bench::new();
    let log = put(&bench, whole[..whole.len() * 2 / 3].to_vec());
    let (info, code) = told(&bench, &log, "");
    assert_eq!(code, 3);
    assert_eq!(info["source"]["complete"], false);
    assert_eq!(info["replay"]["possible"], "yes");
    assert!(codes(&info, "serious").contains(&"incomplete"));
    let run = bench.tmam(&log, "info {}");
    assert_eq!(run.code, 3);
    assert!(run.stdout.contains(", INCOMPLETE"), "{}", run.stdout);

    for (bytes, said) in [
        (b"no log".to_vec(), "not an MCAP file"),
        (Vec::new(), "not an MCAP file"),
    ] {
        let run = bench.tmam(&put(&bench, bytes), "info {}");
        assert_eq!((run.code, run.stdout.as_str()), (2, ""));
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
    assert_eq!(bench.tmam(Path::new("no.mcap"), "info {}").code, 2);
    assert_eq!(
        bench
            .tmam(&sample("room_step.mcap"), "info {} --alpha 7")
            .code,
        2
    );
}

#[test]
fn a_log_in_which_nothing_echoes() {
    let bench = Bench::new();
    bench.tmam(
        Path::new(""),
        "simulate -o far.mcap --max-range 0.3 --steps 20",
    );
    let (info, code) = told(&bench, &bench.path("far.mcap"), "");
    assert_eq!(code, 3);
    assert_eq!(codes(&info, "blocking"), ["no-echo"]);
}

#[test]
fn a_real_robots_ranges_have_a_raster() {
    let Some(log) = shared("house_run1.mcap") else {
        return;
    };
    let (info, code) = told(&Bench::new(), &log, "");
    assert_eq!(code, 0);
    for sonar in info["sonars"].as_array().unwrap() {
        assert_eq!(sonar["resolution"]["quantised"], true, "{sonar:#}");
        let step = sonar["resolution"]["step"].as_f64().unwrap();
        assert!((step - 0.01).abs() < 1e-5, "{step}");
    }
    assert!(codes(&info, "serious").contains(&"coarse-ranges"));
}

#[test]
fn channels_that_are_not_read_are_named_with_the_reason() {
    let Some(log) = shared("encodings/ros1_lz4.mcap") else {
        return;
    };
    let (info, _) = told(&Bench::new(), &log, "");
    for channel in info["channels"].as_array().unwrap() {
        let told = channel["used"] == true || channel["problem"].is_string();
        assert!(told || channel["role"].is_null(), "{channel:#}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_reason_to_fail() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_tmam"))
        .arg("info")
        .arg(sample("room_step.mcap"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(
        output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_survey_of_a_good_log_is_what_a_replay_reads() {
    use tmam_replay::config::Config;
    use tmam_replay::log::{read, survey::survey};
    let config = Config::default();
    for name in ["room_drive.mcap", "room_step.mcap"] {
        let surveyed = survey(&sample(name), &config).unwrap();
        assert!(surveyed.obstacles.is_empty());
        assert_eq!(surveyed.config, config);
        assert_eq!(surveyed.clocks.len(), surveyed.log.channels.len());
        assert_eq!(surveyed.log, read(&sample(name), &config).unwrap());
    }
}
