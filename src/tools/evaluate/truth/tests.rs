use super::*;
use crate::core::config::Config;
use crate::core::event::{Events, OdometrySample, Sonar};
use crate::core::geometry::Vec2;
use crate::core::log::Log;
use crate::core::tmam::arc::ArcId;
use crate::core::world::Wall;
use crate::io::log::container::{Channel, RawMessage, Schema};
use crate::io::log::truth::{READING_SCHEMA, WORLD_SCHEMA};

/// A wall across x = 2, and a sensor at the origin that looks at it.
fn wall() -> World {
    let wall = Wall::new(Vec2::new(2.0, -1.0), Vec2::new(2.0, 1.0));
    World::new(vec![wall], Vec::new()).unwrap()
}

fn log(ranges: &[f64]) -> Log {
    let readings = ranges.iter().zip(0..).map(|(range, k)| RangeReading {
        stamp_ns: k * 1_000_000,
        sonar: SonarId(0),
        range: *range,
        min_range: 0.1,
        max_range: 5.0,
        beam_width: 0.4,
        variance: 0.0,
    });
    let sample = |stamp_ns| OdometrySample {
        stamp_ns,
        world_from_robot: Pose2::IDENTITY,
    };
    Log {
        file: "room.mcap".into(),
        events: Events {
            sonars: vec![Sonar {
                name: "a".into(),
                topic: "/a".into(),
                robot_from_sensor: Pose2::IDENTITY,
            }],
            readings: readings.collect(),
            odometry: vec![sample(0), sample(100_000_000)],
        },
        messages: 0,
        losses: Vec::new(),
        notes: Vec::new(),
        time_notes: Vec::new(),
    }
}

fn arc(stamp_ns: i64, range: f64, sigma: f64) -> Arc {
    Arc {
        id: ArcId {
            frame: 0,
            sonar: SonarId(0),
        },
        stamp_ns,
        world_from_sensor: Pose2::IDENTITY,
        range,
        beam_width: 0.4,
        variance: sigma * sigma,
    }
}

/// What a log with these messages says.
fn recorded(messages: &[(&str, &str)]) -> RecordedTruth {
    let mut recorded = RecordedTruth::default();
    for (schema, json) in messages {
        let channel = Channel {
            id: 1,
            topic: "/truth".into(),
            encoding: "json".into(),
            schema: std::rc::Rc::new(Schema {
                name: (*schema).into(),
                encoding: "jsonschema".into(),
                data: Vec::new(),
            }),
        };
        let data = json.as_bytes();
        recorded.take(&channel, RawMessage { log_time: 0, data });
    }
    recorded
}

fn reading(stamp_ns: i64, kind: &str, index: &str, outlier: bool) -> String {
    format!(
        r#"{{"stamp_ns":{stamp_ns},"sonar":"a","kind":{kind},"index":{index},"range":null,"outlier":{outlier}}}"#
    )
}

const WALL: &str = r#"{"walls": [[2,-1,2,1]], "points": []}"#;
const LINE: Target = Target::Reflector(Reflector::Line(0));

fn truth(
    ranges: &[f64],
    recorded: &RecordedTruth,
    given: Option<World>,
) -> Result<Truth, TruthError> {
    let (log, config) = (log(ranges), Config::default());
    let replay = Replay::new(&log, &config).unwrap();
    Truth::new(&replay, recorded, given, AGREEING_RANGE)
}

#[test]
fn a_range_agrees_within_the_noise_or_five_centimetres() {
    let truth = truth(&[2.0], &RecordedTruth::default(), Some(wall())).unwrap();
    assert_eq!(truth.origin(), Origin::EchoModel);
    let disagrees = Target::Other(Other::Disagrees);
    for (range, sigma, target) in [
        (2.049, 0.001, LINE),
        (2.051, 0.001, disagrees),
        (1.949, 0.001, disagrees),
        (2.14, 0.03, LINE),
        (2.16, 0.03, disagrees),
    ] {
        assert_eq!(
            truth.target(&arc(0, range, sigma)),
            target,
            "{range} {sigma}"
        );
    }
    let away = Arc {
        world_from_sensor: Pose2::new(0.0, 0.0, 3.0),
        ..arc(0, 2.0, 0.001)
    };
    assert_eq!(truth.target(&away), Target::Other(Other::Nothing));
}

#[test]
fn what_the_log_says_stands_before_the_echo_model() {
    let point = reading(1_000_000, "\"point\"", "1", false);
    let outlier = reading(2_000_000, "\"line\"", "0", true);
    let silence = reading(3_000_000, "null", "null", false);
    let recorded = recorded(&[
        (WORLD_SCHEMA, WALL),
        (READING_SCHEMA, &point),
        (READING_SCHEMA, &outlier),
        (READING_SCHEMA, &silence),
    ]);
    let truth = truth(&[2.0; 4], &recorded, None).unwrap();
    assert_eq!(truth.origin(), Origin::Log);
    let target = |millis: i64| truth.target(&arc(millis * 1_000_000, 2.0, 0.01));
    assert_eq!(target(0), LINE, "of which the log says nothing");
    assert_eq!(target(1), Target::Reflector(Reflector::Point(1)));
    assert_eq!(target(2), Target::Other(Other::Outlier));
    assert_eq!(target(3), Target::Other(Other::Nothing));
    assert_eq!(truth.echoes(Reflector::Line(0)), 1);
    assert_eq!(truth.echoes(Reflector::Point(1)), 1);
}

#[test]
fn another_world_replaces_what_the_log_says_and_the_same_one_does_not() {
    let point = reading(0, "\"point\"", "1", false);
    let recorded = recorded(&[(WORLD_SCHEMA, WALL), (READING_SCHEMA, &point)]);
    let same = truth(&[2.0], &recorded, Some(wall())).unwrap();
    assert_eq!(
        same.target(&arc(0, 2.0, 0.01)),
        Target::Reflector(Reflector::Point(1))
    );
    let longer = Wall::new(Vec2::new(2.0, -2.0), Vec2::new(2.0, 2.0));
    let other = World::new(vec![longer], Vec::new()).unwrap();
    let other = truth(&[2.0], &recorded, Some(other)).unwrap();
    assert_eq!(other.origin(), Origin::EchoModel);
    assert_eq!(other.target(&arc(0, 2.0, 0.01)), LINE);
}

#[test]
fn three_echoes_make_a_wall_visible() {
    let none = RecordedTruth::default();
    let seen = |ranges: &[f64]| {
        let truth = truth(ranges, &none, Some(wall())).unwrap();
        (
            truth.echoes(Reflector::Line(0)),
            truth.is_visible(Reflector::Line(0)),
        )
    };
    assert_eq!(seen(&[2.0, 2.01, f64::INFINITY, 3.0]), (2, false));
    assert_eq!(seen(&[2.0, 2.01, 1.99]), (3, true));
}

#[test]
fn what_cannot_be_used_is_refused_with_what_to_do() {
    let refused = |recorded: &RecordedTruth| truth(&[2.0], recorded, None).unwrap_err().to_string();
    let nothing = refused(&RecordedTruth::default());
    assert!(nothing.contains("room.mcap carries no truth"), "{nothing}");
    let bad = recorded(&[(WORLD_SCHEMA, "{}")]);
    let broken = refused(&bad);
    assert!(broken.contains("missing field `walls`"), "{broken}");
    assert!(broken.contains("--truth WORLD.json"), "{broken}");
    assert!(truth(&[2.0], &bad, Some(wall())).is_ok());
    let several = refused(&recorded(&[
        (WORLD_SCHEMA, WALL),
        (WORLD_SCHEMA, r#"{"walls": [[3,-1,3,1]], "points": []}"#),
    ]));
    assert!(several.contains("several worlds"), "{several}");
    let far = reading(0, "\"line\"", "7", false);
    let far = refused(&recorded(&[(WORLD_SCHEMA, WALL), (READING_SCHEMA, &far)]));
    assert!(far.contains("wall 7 echoed, but its world has 1"), "{far}");
    let (log, config) = (log(&[2.0]), Config::default());
    let replay = Replay::new(&log, &config).unwrap();
    for value in [f64::NAN, -0.1, f64::INFINITY] {
        let refused = Truth::new(&replay, &RecordedTruth::default(), Some(wall()), value);
        assert!(matches!(refused, Err(TruthError::Agreement { .. })));
    }
}

#[test]
fn a_message_that_cannot_be_read_is_a_loss() {
    let good = reading(0, "\"line\"", "0", false);
    let recorded = recorded(&[
        (WORLD_SCHEMA, WALL),
        (READING_SCHEMA, "{\"stamp_ns\": 1"),
        (READING_SCHEMA, &good),
        (READING_SCHEMA, "[]"),
        ("other.Schema", "nonsense"),
    ]);
    assert_eq!(recorded.readings().len(), 1);
    let loss = recorded.losses().next().unwrap();
    assert!(
        loss.starts_with("2 of 3 messages about the truth"),
        "{loss}"
    );
}
