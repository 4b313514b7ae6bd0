//! When odometry is sampled and sonars fire, and where the robot is then.

use crate::core::geometry::Pose2;
use crate::io::log::writer::Twist;

use super::{Driving, Path, SimulateError, Stepwise};

/// The most readings that a log may hold.
const MAX_READINGS: usize = 5_000_000;

/// Slack for a whole number of periods or steps that rounding has made a little short.
pub(super) const ROUNDING: f64 = 1e-9;

/// How the robot moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// It stops, all sonars fire, it goes on.
    Stepwise(Stepwise),
    /// It drives without stopping while one sonar fires at a time.
    Driving(Driving),
}

/// Something to log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tick {
    /// Nanoseconds from the start.
    pub(super) after_ns: i64,
    /// Where the robot really is.
    pub(super) world_from_robot: Pose2,
    /// What happens.
    pub(super) action: Action,
}

/// What happens at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Action {
    /// Odometry is sampled at this velocity.
    Odometry(Twist),
    /// A sonar fires.
    Fire(usize),
}

impl Motion {
    /// All ticks along `path` in time order, odometry before the shots of its instant.
    pub(super) fn schedule(&self, path: &Path, sonars: usize) -> Result<Vec<Tick>, SimulateError> {
        match self {
            Self::Stepwise(stepwise) => stepwise.schedule(path, sonars),
            Self::Driving(driving) => driving.schedule(path, sonars),
        }
    }
}

/// Seconds to the nearest nanosecond.
pub(super) fn nanoseconds(seconds: f64) -> i64 {
    libm::round(seconds * 1e9) as i64
}

/// Refuses a log of too many readings.
pub(super) fn limit(readings: f64) -> Result<(), SimulateError> {
    // Not `>`, which NaN and so an endless path would pass.
    if readings <= MAX_READINGS as f64 {
        Ok(())
    } else {
        Err(SimulateError::TooLong {
            readings,
            limit: MAX_READINGS,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::core::geometry::Vec2;

    /// A path along x, metres.
    pub(in crate::tools::simulate) fn line(length: f64) -> Path {
        Path::new(&[Vec2::zeros(), Vec2::new(length, 0.0)]).unwrap()
    }

    /// When which sonar fired.
    pub(in crate::tools::simulate) fn shots(ticks: &[Tick]) -> Vec<(i64, usize)> {
        let fired = |tick: &Tick| match tick.action {
            Action::Fire(sonar) => Some((tick.after_ns, sonar)),
            Action::Odometry(_) => None,
        };
        ticks.iter().filter_map(fired).collect()
    }
}
