//! Findings on logs that are made up event by event.

use super::*;
use crate::core::config::Config;
use crate::core::event::{Events, OdometrySample, RangeReading, Sonar, SonarId};
use crate::core::geometry::Pose2;
use crate::core::log::Log;
use crate::io::config::file::{check, parse};
use crate::io::log::Role;
use crate::io::log::channels::ChannelReport;
use crate::io::log::survey::ChannelClock;
use crate::io::log::traits::{MountTraits, Traits};
use crate::tools::findings::finding::Weight;

/// Two sonars on a robot that drives 0.1 m a second past a wall, in numbers on no raster.
fn good() -> Events {
    let stamp = |k: usize| k as i64 * 1_000_000_000;
    let wall = |k: usize| 1.0 + 0.05 * (k as f64 * 0.618_034).fract();
    Events {
        sonars: vec![
            Sonar {
                name: "left".into(),
                topic: "/left".into(),
                robot_from_sensor: Pose2::new(0.0, 0.1, 1.5),
            },
            Sonar {
                name: "right".into(),
                topic: "/right".into(),
                robot_from_sensor: Pose2::new(0.0, -0.1, -1.5),
            },
        ],
        readings: (0..80)
            .map(|k| RangeReading {
                stamp_ns: stamp(k / 2),
                sonar: SonarId((k % 2) as u16),
                range: wall(k),
                min_range: 0.1,
                max_range: 5.0,
                beam_width: 0.4,
                variance: 0.0,
            })
            .collect(),
        odometry: (0..400)
            .map(|k| OdometrySample {
                stamp_ns: stamp(k) / 10,
                world_from_robot: Pose2::new(0.01 * k as f64, 0.0, 0.0),
            })
            .collect(),
    }
}

fn info(events: Events) -> Info {
    told(&surveyed(events))
}

fn told(survey: &Survey) -> Info {
    Info::new(survey, &|_| None)
}

fn surveyed(events: Events) -> Survey {
    Survey {
        traits: Traits {
            mounts: vec![MountTraits::default(); events.sonars.len()],
            ..Traits::default()
        },
        log: Log {
            file: "made_up.mcap".into(),
            events,
            messages: 1,
            losses: Vec::new(),
            notes: Vec::new(),
            time_notes: Vec::new(),
        },
        channels: Vec::new(),
        clock_set: None,
        config: Config::default(),
        obstacles: Vec::new(),
        in_part: false,
        clocks: Vec::new(),
        odometry_topic: Some("/odom".into()),
    }
}

#[test]
fn a_channel_that_is_not_read_is_told_once() {
    let told = |losses: &[&str]| {
        let mut survey = surveyed(good());
        survey.channels = vec![ChannelReport {
            id: 1,
            topic: "/a, b".into(),
            type_name: "sensor_msgs/msg/Range".into(),
            encoding: "cbor".into(),
            role: Some(Role::Range),
            used: false,
            messages: 3,
            undecoded: 0,
            problem: Some("no such encoding".into()),
            wanted: true,
        }];
        survey.clocks = vec![ChannelClock::default()];
        survey.log.losses = losses.iter().map(|loss| (*loss).to_owned()).collect();
        codes(&told(&survey))
    };
    let of_it = "/a, b, 3 messages: left out";
    assert_eq!(told(&[of_it]), ["unread-channel"]);
    let both = told(&[of_it, "/c, 3 messages: left out"]);
    assert_eq!(both, ["unread-channel", "incomplete"]);
}

/// Codes of what is found, but for how many arcs are labelled.
fn codes(info: &Info) -> Vec<&'static str> {
    info.findings
        .iter()
        .map(|finding| finding.code)
        .filter(|code| *code != "few-labels")
        .collect()
}

fn found(change: impl FnOnce(&mut Events)) -> Vec<&'static str> {
    let mut events = good();
    change(&mut events);
    codes(&info(events))
}

#[test]
fn a_good_log_has_nothing_wrong() {
    assert_eq!(found(|_| {}), Vec::<&str>::new());
    assert!(info(good()).is_fine());
}

#[test]
fn each_trouble_has_its_finding() {
    let each = |events: &mut Events, change: fn(&mut RangeReading)| {
        events.readings.change(change);
    };
    assert_eq!(found(|e| each(e, |r| r.beam_width = 22.5)), ["beam-width"]);
    assert_eq!(
        found(|e| each(e, |r| {
            r.range *= 100.0;
            r.max_range = 500.0;
        })),
        ["units"]
    );
    assert_eq!(
        found(
            |e| each(e, |r| r.range = if r.stamp_ns % 3_000_000_000 == 0 {
                r.range
            } else {
                f64::NAN
            })
        ),
        ["invalid"]
    );
    assert_eq!(
        found(|e| {
            let ranges: Vec<f64> = e.readings.iter().map(|r| r.range).collect();
            let mut places = 0..;
            e.readings.change(|reading| {
                let k = places.next().unwrap();
                reading.range = ranges[k / 4 * 4 + k % 2];
            });
        }),
        ["repeats"]
    );
    assert_eq!(
        found(|e| e.sonars[1].robot_from_sensor = e.sonars[0].robot_from_sensor),
        ["one-mount"]
    );
    assert_eq!(
        found(|e| {
            for sample in e.odometry.iter_mut().skip(200) {
                sample.world_from_robot.x += 1.0;
            }
        }),
        ["odometry-jump"]
    );
    assert_eq!(
        found(|e| {
            for sample in &mut e.odometry {
                sample.world_from_robot.x = 0.0;
            }
        }),
        ["still"]
    );
    assert_eq!(
        found(|e| e.odometry.truncate(300)),
        ["no-pose"],
        "a fifth of the readings comes after it"
    );
}

#[test]
fn limits_that_let_no_echo_through_get_a_key() {
    let mut events = good();
    events.readings.change(|reading| reading.max_range = 0.0);
    let info = info(events);
    assert_eq!(codes(&info)[..2], ["no-echo", "limits"]);
    assert!(info.findings.is_sorted_by_key(|finding| finding.weight));
    assert_eq!(info.findings[0].weight, Weight::Blocking);
    assert!(!info.is_fine());
    let config = parse(info.skeleton.as_deref().unwrap()).unwrap();
    check(&config).unwrap();
    assert_eq!(config.sonar["left"].max_range, Some(5.1));
}

#[test]
fn ranges_on_a_coarse_raster_are_told_with_what_they_hide() {
    let mut events = good();
    let mut places = 0_u32..;
    (events.readings).change(|r| r.range = 3.0 + 0.02 * f64::from(places.next().unwrap() % 37));
    let info = info(events);
    assert_eq!(codes(&info), ["coarse-ranges"]);
    let what = &info.findings[0].what;
    assert!(
        what.contains("20.0 mm") && what.contains("differ by 1."),
        "{what}"
    );
}

#[test]
fn json_has_null_for_what_is_without_limit() {
    let mut events = good();
    events
        .readings
        .change(|reading| reading.max_range = f64::INFINITY);
    let mut bytes = Vec::new();
    info(events).write(&mut bytes).unwrap();
    let document: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    assert!(document["sonars"][0]["max_range"].is_null());
    assert_eq!(document["sonars"][0]["mount"]["yaw"], 1.5);
    assert_eq!(bytes.last(), Some(&b'\n'));
}

#[test]
fn text_of_a_log_without_anything_is_short() {
    let nothing = info(Events::default());
    assert_eq!(nothing.facts.replay.possible, Replayable::No);
    let text = text::text(&nothing);
    assert!(
        text.starts_with("made_up.mcap: 0.0 s, 1 message used, 0 sonars\ncannot"),
        "{text}"
    );
}
