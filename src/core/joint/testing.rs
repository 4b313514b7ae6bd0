//! Drives for tests.

use std::io::Cursor;

use crate::core::config::Config;
use crate::core::log::Log;
use crate::io::log::read_with_truth_in;
use crate::tools::simulate::{Driving, Motion, OdometryNoise, Path, RangeNoise, Simulation};

/// So many laps in the paper's room, at 3 mm, with much drift.
pub fn drifting_room(laps: u16) -> Log {
    let simulation = Simulation {
        path: Path::room().repeated(laps).unwrap(),
        motion: Motion::Driving(Driving::default()),
        range_noise: RangeNoise {
            sigma: 0.003,
            ..RangeNoise::default()
        },
        odometry_noise: OdometryNoise {
            distance: 0.01,
            heading: 0.2_f64.to_radians(),
            turn: 0.5_f64.to_radians(),
        },
        ..Simulation::default()
    };
    let bytes = simulation.write(Cursor::new(Vec::new())).unwrap();
    let bytes = Cursor::new(bytes.into_inner());
    read_with_truth_in(bytes, "room.mcap", &Config::default())
        .unwrap()
        .0
}
