//! A suite of twelve logs under seeded regressions, each of which must be caught and should be named for what it
//! is, and under harmless changes, none of which may be called a difference. The quick test changes one log for
//! each; all of them, and the table of docs/ci.md:
//! `cargo test --release --test it golden::suite -- --include-ignored --nocapture`.

use std::cell::{Cell, RefCell};
use std::fmt::Write as _;

use serde_json::{Value, json};

use super::tmam;
use crate::support::{Bench, Message, rewrite};

const LOGS: usize = 12;

/// What becomes of a log's messages.
type Rewriting = Box<dyn Fn(Message) -> Vec<Message>>;

/// What is changed.
enum Change {
    Log(fn() -> Rewriting),
    /// How the log is written.
    Written(fn() -> mcap::WriteOptions),
    /// What is given to the check, a file among it.
    Given(&'static str, &'static [&'static str]),
    Golden(fn(&mut Value)),
}

use Change::{Given, Golden, Log, Written};

/// From the end of a `sensor_msgs/Range` in CDR.
const VARIANCE: usize = 4;
const RANGE: usize = 8;
const MOST: usize = 12;
const BEAM: usize = 20;
/// From the end of a `nav_msgs/Odometry` in CDR: its x, and the z and w of its orientation.
const X: usize = 680;
const TURN: [usize; 2] = [640, 632];

fn number<const N: usize>(message: &Message, from_end: usize) -> [u8; N] {
    let at = message.data.len() - from_end;
    message.data[at..at + N].try_into().unwrap()
}

fn put(message: &mut Message, from_end: usize, bytes: &[u8]) {
    let at = message.data.len() - from_end;
    message.data[at..at + bytes.len()].copy_from_slice(bytes);
}

/// Changes a number of every reading of the sonars that are meant.
fn readings(from_end: usize, of: &'static str, change: impl Fn(f32) -> f32 + 'static) -> Rewriting {
    Box::new(move |mut message| {
        if message.topic.starts_with("/sonar/") && message.topic.ends_with(of) {
            let was = f32::from_le_bytes(number(&message, from_end));
            put(&mut message, from_end, &change(was).to_le_bytes());
        }
        vec![message]
    })
}

/// Changes x, y and yaw of every pose of odometry.
fn poses(change: impl Fn([f64; 3]) -> [f64; 3] + 'static) -> Rewriting {
    Box::new(move |mut message| {
        if message.topic == "/odom" {
            let read = |from_end| f64::from_le_bytes(number(&message, from_end));
            let [z, w] = TURN.map(read);
            let [x, y, yaw] = change([read(X), read(X - 8), 2.0 * libm::atan2(z, w)]);
            let turned = [libm::sin(yaw / 2.0), libm::cos(yaw / 2.0)];
            let all = [X, X - 8].into_iter().chain(TURN);
            for (from_end, value) in all.zip([x, y].into_iter().chain(turned)) {
                put(&mut message, from_end, &value.to_le_bytes());
            }
        }
        vec![message]
    })
}

/// Drives the same way with other steps: along, and turned.
fn driven(step: impl Fn(f64, f64) -> (f64, f64) + 'static) -> Rewriting {
    let before = RefCell::new(None::<([f64; 3], [f64; 3])>);
    poses(move |now| {
        let mut before = before.borrow_mut();
        let there = match *before {
            None => now,
            Some((was, at)) => {
                let way = libm::hypot(now[0] - was[0], now[1] - was[1]);
                let turn = libm::remainder(now[2] - was[2], std::f64::consts::TAU);
                let ahead = libm::atan2(now[1] - was[1], now[0] - was[0]) - was[2];
                let (way, turn) = step(way, turn);
                let along = at[2] + ahead;
                [
                    at[0] + way * libm::cos(along),
                    at[1] + way * libm::sin(along),
                    at[2] + turn,
                ]
            }
        };
        *before = Some((now, there));
        there
    })
}

/// Moves the stamps of the topics that begin so, by nanoseconds that may hang on the time since the start.
fn stamped(topic: &'static str, of: &'static str, by: impl Fn(i64) -> i64 + 'static) -> Rewriting {
    let start = Cell::new(None);
    Box::new(move |mut message| {
        if message.topic.starts_with(topic) && message.topic.ends_with(of) {
            let word = |at: usize| u32::from_le_bytes(message.data[at..at + 4].try_into().unwrap());
            let stamp = i64::from(word(4)) * 1_000_000_000 + i64::from(word(8));
            let first = start.get().unwrap_or(stamp);
            start.set(Some(first));
            let stamp = stamp + by(stamp - first);
            let [s, ns] = [stamp / 1_000_000_000, stamp % 1_000_000_000];
            message.data[4..8].copy_from_slice(&(s as u32).to_le_bytes());
            message.data[8..12].copy_from_slice(&(ns as u32).to_le_bytes());
        }
        vec![message]
    })
}

/// Leaves messages of a topic out, by how many came before.
fn lost(topic: &'static str, is_lost: impl Fn(usize, u64) -> bool + 'static) -> Rewriting {
    let (seen, start) = (Cell::new(0), Cell::new(None));
    Box::new(move |message| {
        let since = message.log_time - start.get().unwrap_or(message.log_time);
        start.set(start.get().or(Some(message.log_time)));
        if !message.topic.starts_with(topic) {
            return vec![message];
        }
        seen.set(seen.get() + 1);
        if is_lost(seen.get(), since) {
            vec![]
        } else {
            vec![message]
        }
    })
}

/// Calls a sonar by another name of the same length, and that one by its.
fn renamed(one: &'static str, other: &'static str) -> Rewriting {
    Box::new(move |mut message| {
        if !message.topic.starts_with("/sonar/") {
            return vec![message];
        }
        for at in 0..message.data.len().saturating_sub(one.len()) {
            let name = &mut message.data[at..at + one.len()];
            if name == one.as_bytes() {
                name.copy_from_slice(other.as_bytes());
            } else if name == other.as_bytes() {
                name.copy_from_slice(one.as_bytes());
            }
        }
        vec![message]
    })
}

/// Moves the mount that comes last.
fn mount(from_end: usize, change: fn(f64) -> f64) -> Rewriting {
    Box::new(move |mut message| {
        if message.topic == "/tf_static" {
            let was = f64::from_le_bytes(number(&message, from_end));
            put(&mut message, from_end, &change(was).to_le_bytes());
        }
        vec![message]
    })
}

/// One of `of` numbers at random, 0 to 1.
fn random(seen: &Cell<u32>) -> f32 {
    seen.set(
        seen.get()
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223),
    );
    (seen.get() >> 8) as f32 / (1 << 24) as f32
}

fn scattered() -> Rewriting {
    let seen = Cell::new(0);
    readings(RANGE, "", move |range| range + (random(&seen) - 0.5) * 0.06)
}

fn clutter() -> Rewriting {
    let seen = Cell::new(0);
    readings(RANGE, "", move |range| {
        if random(&seen) < 0.07 {
            range / 2.0
        } else {
            range
        }
    })
}

/// Regressions, and the cause that should be named first.
#[rustfmt::skip]
fn regressions() -> Vec<(&'static str, &'static str, Change)> {
    vec![
        ("2 cm more on every range", "ranges", Log(|| readings(RANGE, "", |r| r + 0.02))),
        ("ranges 2 % too long", "ranges", Log(|| readings(RANGE, "", |r| r * 1.02))),
        ("one sonar 3 cm too long", "ranges", Log(|| readings(RANGE, "3", |r| r + 0.03))),
        ("one sonar 3 % too short", "ranges", Log(|| readings(RANGE, "2", |r| r * 0.97))),
        ("ranges scatter by 3 cm", "ranges", Log(scattered)),
        ("7 % false echoes", "ranges", Log(clutter)),
        ("one sonar 80 ms late", "stamps", Log(|| stamped("/sonar/", "2", |_| 80_000_000))),
        ("all sonars 100 ms late", "stamps", Log(|| stamped("/sonar/", "", |_| 100_000_000))),
        ("odometry 100 ms late", "stamps", Log(|| stamped("/odom", "", |_| 100_000_000))),
        ("the clock of the sonars 1 % fast", "stamps", Log(|| stamped("/sonar/", "", |t| t / 100))),
        ("distances 3 % too long", "odometry", Log(|| driven(|way, turn| (way * 1.03, turn)))),
        ("turns 3 % too wide", "odometry", Log(|| driven(|way, turn| (way, turn * 1.03)))),
        ("a heading that drifts by 2 deg/m", "odometry", Log(|| driven(|way, turn| (way, turn + 0.035 * way)))),
        ("half the odometry lost", "odometry", Log(|| lost("/odom", |n, _| n % 2 == 0))),
        ("odometry that begins elsewhere", "odometry", Log(|| poses(|[x, y, yaw]| [x + 0.5, y, yaw]))),
        ("a mount moved by 5 cm", "mounts", Log(|| mount(56, |x| x + 0.05))),
        ("a mount turned", "mounts", Log(|| mount(16, |z| z + 0.03))),
        ("beams a tenth wider", "beams", Log(|| readings(BEAM, "", |width| width * 1.1))),
        ("a greatest range of 2 m", "beams", Log(|| readings(MOST, "", |_| 2.0))),
        ("variances four times as large", "variances", Log(|| readings(VARIANCE, "", |v| v * 4.0))),
        ("a sonar that is gone", "sonars", Log(|| lost("/sonar/sonar_02", |_, _| true))),
        ("two sonars swapped", "sonars", Log(|| renamed("sonar_02", "sonar_03"))),
        ("every fifth reading of a sonar lost", "readings", Log(|| lost("/sonar/sonar_02", |n, _| n % 5 == 0))),
        ("the end of the ranges lost", "readings", Log(|| lost("/sonar/", |_, since| since > 9_000_000_000))),
        ("speeds that contradict the poses", "findings", Log(|| odometry_says(336, 9.0))),
        ("other bounds in the team's file", "configuration", Given("opinion.decisive = 20\nopinion.gate = 3\n", &["--config", "given.toml"])),
        ("a wall that the program finds elsewhere", "program", Golden(|file| file["map"]["lines"][0]["rho"] = json!(0.3))),
    ]
}

/// Changes that nobody wants to hear of.
#[rustfmt::skip]
fn harmless() -> Vec<(&'static str, Change)> {
    vec![
        ("zstd", Written(|| mcap::WriteOptions::new().compression(Some(mcap::Compression::Zstd)))),
        ("lz4", Written(|| mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4)))),
        ("no compression", Written(|| mcap::WriteOptions::new().compression(None))),
        ("small chunks", Written(|| mcap::WriteOptions::new().chunk_size(Some(700)))),
        ("no chunks", Written(|| mcap::WriteOptions::new().use_chunks(false))),
        ("odometry last in the file", Log(|| ranked("/odom"))),
        ("mounts last in the file", Log(|| ranked("/tf_static"))),
        ("mounts said twice", Log(|| Box::new(|message| match message.topic.as_str() {
            "/tf_static" => vec![copy(&message), message],
            _ => vec![message],
        }))),
        ("recorded a second later", Log(|| Box::new(|mut message| { message.log_time += 1_000_000_000; vec![message] }))),
        ("another covariance in the odometry", Log(|| odometry_says(624, 0.5))),
        ("odometry to eleven decimals", Log(|| poses(|pose| pose.map(|x| (x * 1e11).round() / 1e11)))),
        ("the truth left out", Log(|| lost("/truth", |_, _| true))),
        ("the team's file says the defaults", Given("frames.step = 0.1\n", &["--config", "given.toml"])),
        ("an empty file of the team", Given("", &["--config", "given.toml"])),
        ("rows in another order", Golden(|file| for list in ["map", "features"] {
            for kind in ["lines", "points"] { file[list][kind].as_array_mut().unwrap().reverse(); }
        })),
        ("a wall off by 2 mm", Golden(|file| {
            let rho = file["map"]["lines"][0]["rho"].as_f64().unwrap();
            file["map"]["lines"][0]["rho"] = json!(rho + 0.002);
        })),
    ]
}

/// Puts a number into every odometry message.
fn odometry_says(from_end: usize, value: f64) -> Rewriting {
    Box::new(move |mut message| {
        if message.topic == "/odom" {
            put(&mut message, from_end, &value.to_le_bytes());
        }
        vec![message]
    })
}

fn ranked(topic: &'static str) -> Rewriting {
    Box::new(move |mut message| {
        message.rank = u8::from(message.topic == topic);
        vec![message]
    })
}

fn copy(message: &Message) -> Message {
    Message {
        topic: message.topic.clone(),
        data: message.data.clone(),
        ..*message
    }
}

/// A folder with the logs and their golden files.
fn blessed(logs: usize) -> Bench {
    let bench = Bench::new();
    for log in 0..logs {
        let (width, depth) = (5.0 + 0.25 * (log % 4) as f64, 3.0 + 0.2 * (log % 3) as f64);
        let world = json!({
            "walls": [[0, 0, width, 0], [width, 0, width, depth], [width, depth, 0, depth], [0, depth, 0, 0]],
            "points": [[0, 0], [width, 0], [width, depth], [0, depth]],
        });
        bench.put("world.json", world.to_string());
        let drive = if log % 2 == 0 { "--drive" } else { "" };
        let made = bench.sh(&format!(
            "tmam simulate --world world.json --sonars 4 --noise 0.003 --waypoints '1,1 4,1 4,1.8' --seed {log} \
             {drive} -o log_{log:02}.mcap"
        ));
        assert_eq!(made.code, 0, "{}", made.stderr);
    }
    let made = bench.sh("tmam check log_*.mcap --golden golden --bless");
    assert_eq!(made.code, 0, "{}{}", made.stdout, made.stderr);
    bench
}

/// The report on a log after a change; the log and its golden file are as they were afterwards.
fn report(bench: &Bench, log: usize, change: &Change) -> (i32, Value) {
    let (name, golden) = (
        format!("log_{log:02}.mcap"),
        format!("golden/log_{log:02}.golden.json"),
    );
    let (bytes, text) = (bench.bytes(&name), bench.bytes(&golden));
    let mut more: &[&str] = &[];
    match change {
        Log(rewriting) => {
            let changed = rewrite(&bench.path(&name), mcap::WriteOptions::new(), rewriting());
            bench.put(&name, changed);
        }
        Written(options) => {
            let changed = rewrite(&bench.path(&name), options(), |message| vec![message]);
            bench.put(&name, changed);
        }
        Given(file, arguments) => {
            bench.put("given.toml", file);
            more = arguments;
        }
        Golden(change) => {
            let mut file = bench.json(&golden);
            change(&mut file);
            bench.put(&golden, file.to_string());
        }
    }
    let check = ["check", &name, "--golden", "golden", "--json"];
    let run = tmam(bench, &[&check[..], more].concat(), &[]);
    bench.put(&name, bytes);
    bench.put(&golden, text);
    let said = serde_json::from_str(&run.stdout);
    (
        run.code,
        said.unwrap_or_else(|error| panic!("{error}: {}{}", run.stdout, run.stderr)),
    )
}

/// Holds the suite to all of it, each change to every `share`-th log; the table.
fn hold(share: usize) -> String {
    let bench = blessed(LOGS);
    let logs = |change: usize| (0..LOGS).filter(move |log| log % share == change % share);
    let mut table = String::from(
        "| regression | caught | named first | what is said of the first log |\n|---|--:|--:|---|\n",
    );
    let (mut named, mut all) = (0, 0);
    for (place, (what, cause, change)) in regressions().iter().enumerate() {
        let (mut caught, mut first, mut of, mut said) = (0, 0, 0, String::new());
        for log in logs(place) {
            let (code, report) = report(&bench, log, change);
            let causes = &report["logs"][0]["causes"];
            caught += usize::from(code == 1);
            first += usize::from(causes[0]["code"] == *cause);
            of += 1;
            if said.is_empty() {
                said = causes[0]["text"].as_str().unwrap_or_default().to_owned();
            }
            assert_eq!(code, 1, "{what} went unnoticed in log {log}: {report:#}");
        }
        (named, all) = (named + first, all + of);
        let said = said.split(" (unchanged").next().unwrap_or_default();
        let _ = writeln!(
            table,
            "| {what} | {caught} of {of} | {first} of {of} | {said} |"
        );
    }
    let _ = writeln!(table, "\n{named} of {all} named first.\n");
    println!("{table}");
    assert!(
        named * 5 >= all * 4,
        "{named} of {all} named first\n{table}"
    );
    for (place, (what, change)) in harmless().iter().enumerate() {
        for log in logs(place) {
            let (code, report) = report(&bench, log, change);
            assert_eq!(
                code, 0,
                "{what} is called a difference in log {log}: {report:#}"
            );
        }
    }
    table
}

#[test]
fn regressions_are_caught_and_named_and_harmless_changes_are_not() {
    hold(LOGS);
}

#[test]
#[ignore = "takes minutes without optimisation"]
fn in_every_log_of_the_suite_as_the_page_says() {
    let told = hold(1);
    let table = told.split("\n\n").next().unwrap();
    let page = include_str!("../../../docs/ci.md");
    assert!(
        page.contains(table),
        "docs/ci.md has another table than\n{told}"
    );
}
