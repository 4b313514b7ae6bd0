use std::f64::consts::FRAC_PI_2;

use nalgebra::Matrix2;

use super::*;
use crate::core::config::Config;
use crate::core::event::{Events, OdometrySample, RangeReading, Sonar, SonarId};
use crate::core::geometry::{Pose2, Vec2};
use crate::core::log::Log;
use crate::core::replay::Replay;
use crate::core::tmam::feature::Segment;
use crate::core::tmam::feature::Shape;
use crate::core::world::{Wall, World};
use crate::io::log::truth::RecordedTruth;

/// Two walls, y = 2 from x = -2 to 2 and x = 9 from y = 0 to 1, of which a sensor at the origin
/// that looks up hears the first `echoes` times, and a point that it does not hear.
pub fn truth(echoes: i64) -> Truth {
    let walls = [((-2.0, 2.0), (2.0, 2.0)), ((9.0, 0.0), (9.0, 1.0))]
        .map(|((a, b), (c, d))| Wall::new(Vec2::new(a, b), Vec2::new(c, d)));
    let world = World::new(walls.to_vec(), vec![Vec2::new(5.0, 5.0)]).unwrap();
    heard_in(echoes, world)
}

/// The truth of a sensor at the origin that looks up and measures 2 m so many times.
pub fn heard_in(echoes: i64, world: World) -> Truth {
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
        losses: Vec::new(),
        notes: Vec::new(),
        time_notes: Vec::new(),
    };
    let config = Config::default();
    let replay = Replay::new(&log, &config).unwrap();
    Truth::new(&replay, &RecordedTruth::default(), Some(world), 0.05).unwrap()
}

/// On the line y = `y` from one x to another.
pub fn line(id: u32, y: f64, from: f64, to: f64) -> MapFeature {
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
        runs: 2,
        status: Status::Confirmed,
    }
}
