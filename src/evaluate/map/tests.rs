use std::f64::consts::FRAC_PI_2;

use nalgebra::Matrix2;

use super::*;
use crate::config::Config;
use crate::event::{Events, OdometrySample, RangeReading, Sonar, SonarId};
use crate::geometry::{Pose2, Vec2};
use crate::log::Log;
use crate::log::truth::RecordedTruth;
use crate::replay::Replay;
use crate::tmam::feature::{Point, Segment};
use crate::world::{Wall, World};

/// Two walls, y = 2 from x = -2 to 2 and x = 9 from y = 0 to 1, of which a sensor at the origin
/// that looks up hears the first `echoes` times, and a point that it does not hear.
fn truth(echoes: i64) -> Truth {
    let readings = (0..echoes).map(|k| RangeReading {
        stamp_ns: k,
        sonar: SonarId(0),
        range: 2.0,
        min_range: 0.1,
        max_range: 5.0,
        beam_width: 0.4,
        variance: 0.0,
    });
    let at = |stamp_ns| OdometrySample {
        stamp_ns,
        world_from_robot: Pose2::new(0.0, 0.0, FRAC_PI_2),
    };
    let log = Log {
        file: "f".into(),
        events: Events {
            sonars: vec![Sonar {
                name: "a".into(),
                topic: "/a".into(),
                robot_from_sensor: Pose2::IDENTITY,
            }],
            readings: readings.collect(),
            odometry: vec![at(0), at(1000)],
        },
        messages: 0,
        channels: Vec::new(),
        losses: Vec::new(),
        notes: Vec::new(),
    };
    let walls = [((-2.0, 2.0), (2.0, 2.0)), ((9.0, 0.0), (9.0, 1.0))]
        .map(|((a, b), (c, d))| Wall::new(Vec2::new(a, b), Vec2::new(c, d)));
    let world = World::new(walls.to_vec(), vec![Vec2::new(5.0, 5.0)]).unwrap();
    let config = Config::default();
    let replay = Replay::new(&log, &config).unwrap();
    Truth::new(&replay, &RecordedTruth::default(), Some(world), 0.05).unwrap()
}

/// On the line y = `y` from one x to another.
fn line(id: u32, y: f64, from: f64, to: f64) -> MapFeature {
    MapFeature {
        id,
        shape: Shape::Line(Segment {
            rho: y,
            theta: FRAC_PI_2,
            covariance: Matrix2::identity() * 1e-4,
            mid: Vec2::new((from + to) / 2.0, y),
            half_length: (to - from) / 2.0,
        }),
        readings: 5,
    }
}

fn point(id: u32, x: f64, y: f64) -> MapFeature {
    MapFeature {
        id,
        shape: Shape::Point(Point {
            position: Vec2::new(x, y),
            covariance: Matrix2::identity() * 1e-4,
        }),
        readings: 5,
    }
}

#[test]
fn a_wall_has_one_line_and_what_else_lies_on_it_is_twice() {
    let features = [
        line(0, 2.05, -1.0, 0.0),
        line(1, 2.01, 0.5, 1.5),
        line(2, 2.5, 0.0, 1.0),
        line(3, 1.97, -0.5, 0.0),
        point(4, 5.1, 5.0),
        point(5, 5.0, 5.3),
    ];
    let score = MapScore::new(features.iter(), &truth(3));
    let lines = &score.lines;
    assert_eq!((lines.features, lines.visible), (4, 1));
    let [best] = lines.matches.as_slice() else {
        panic!("{:?}", lines.matches)
    };
    assert_eq!((best.feature, best.reflector), (1, Reflector::Line(0)));
    assert_eq!(lines.spurious, [2]);
    let twice = Reflector::Line(0);
    assert_eq!(lines.duplicates, [(0, twice), (3, twice)]);
    assert_eq!(lines.surplus(), 3);
    assert!(lines.missed.is_empty() && !lines.is_exact());
    // 1 m, another that holds half a metre more, of 4 m.
    assert!((lines.covered.unwrap() - 0.5).abs() < 1e-9);
    let rho = lines.errors.rho.unwrap();
    assert!((rho.mean - 0.01).abs() < 1e-9 && (rho.max - 0.01).abs() < 1e-9);
    assert!((lines.errors.nees.mean.unwrap() - 0.5).abs() < 1e-6);

    // What was not heard is not asked for, but may be there.
    assert_eq!(score.points.visible, 0);
    assert_eq!(score.points.matches.len(), 1);
    assert_eq!(score.points.spurious, [5]);
    assert!((score.points.errors.position.unwrap().max - 0.1).abs() < 1e-9);
}

#[test]
fn only_what_was_heard_three_times_can_be_missed() {
    assert_eq!(MapScore::new([].iter(), &truth(2)).lines.missed, []);
    let score = MapScore::new([].iter(), &truth(3));
    assert_eq!(score.lines.missed, [Reflector::Line(0)]);
    assert_eq!(score.lines.covered, Some(0.0));
    assert!(!score.is_exact());
    let whole = [line(0, 2.0, -2.0, 2.0)];
    let score = MapScore::new(whole.iter(), &truth(3));
    assert!(score.is_exact());
    assert_eq!(score.lines.covered, Some(1.0));
}

#[test]
fn overlapping_intervals_count_once() {
    assert_eq!(union(&[]), 0.0);
    assert_eq!(
        union(&[(0.0, 2.0), (0.5, 1.0), (1.5, 3.0), (4.0, 5.0)]),
        4.0
    );
    assert_eq!(union(&[(1.0, 0.5)]), 0.0);
}

#[test]
fn a_run_is_of_what_its_readings_came_from() {
    let (wall, other) = (
        Target::Reflector(Reflector::Line(0)),
        Target::Reflector(Reflector::Line(1)),
    );
    let near = line(0, 2.02, 0.0, 1.0).shape;
    let far = line(1, 3.0, 0.0, 1.0).shape;
    let extracted = [
        Extracted {
            shape: &near,
            targets: vec![wall; 4],
        },
        Extracted {
            shape: &far,
            targets: vec![wall; 3],
        },
        Extracted {
            shape: &near,
            targets: vec![wall, wall, other],
        },
        Extracted {
            shape: &near,
            targets: vec![wall, other],
        },
    ];
    let score = ExtractedScore::new(Kind::Line, &extracted, &truth(3));
    assert_eq!((score.features, score.pure, score.mostly), (4, 2, 3));
    let pure = score.pure_errors.rho.unwrap();
    assert!(
        (pure.max - 1.0).abs() < 1e-9,
        "the far one counts: {pure:?}"
    );
    let near = score.near_errors.rho.unwrap();
    assert!(
        (near.max - 0.02).abs() < 1e-9,
        "the far one does not: {near:?}"
    );
    let points = ExtractedScore::new(Kind::Point, &extracted, &truth(3));
    assert_eq!(points, ExtractedScore::default());
}
