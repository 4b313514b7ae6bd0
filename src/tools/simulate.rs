//! A robot with a sonar ring in a world of walls and points, written as a ROS 2 log with the truth
//! in it.
//!
//! Same parameters, same bytes, on every platform: random numbers come from ChaCha8 with one
//! stream for the ranges and one for the odometry, so changing one noise leaves the other alone.

mod driving;
mod motion;
mod odometry_noise;
mod path;
mod random;
mod range_noise;
mod ring;
mod stepwise;

use std::io::{Seek, Write};

use crate::core::truth::ReadingTruth;
use crate::core::world::World;
use crate::io::log::writer::{LogWriter, RangeMessage, WriteError};

pub use driving::Driving;
pub use motion::Motion;
pub use odometry_noise::OdometryNoise;
pub use path::Path;
pub use range_noise::RangeNoise;
pub use ring::Ring;
pub use stepwise::Stepwise;

use motion::Action;
use odometry_noise::DriftingOdometry;
use range_noise::NoisySonar;

/// When every simulated log starts: 2015-01-01T00:00:00Z, nanoseconds.
pub const START_NS: i64 = 1_420_070_400_000_000_000;

/// Why a simulation cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// A parameter out of its range.
    #[error("{name} is {value}, but must be {allowed}")]
    Parameter {
        /// Which.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        allowed: &'static str,
    },
    /// A way-point that is not two numbers.
    #[error("{0:?} is not a way-point; write x,y in metres, with spaces between way-points")]
    WaypointText(String),
    /// Nowhere to go.
    #[error("a path needs at least 2 way-points, got {0}")]
    TooFewWaypoints(usize),
    /// A way-point at which there is no direction of travel.
    #[error(
        "way-points {index} and {} are {distance} m apart; neighbours must be at least 1e-6 m apart and finite",
        index + 1
    )]
    Waypoints {
        /// The earlier of the two, from 0.
        index: usize,
        /// How far apart they are, metres.
        distance: f64,
    },
    /// An open path with fewer places than steps.
    #[error(
        "{steps} steps of {step} m do not fit an open path of {length} m; take at most {most}, or end the way-points where they begin"
    )]
    PathTooShort {
        /// The number of steps asked for.
        steps: usize,
        /// Metres a step.
        step: f64,
        /// The path's length, metres.
        length: f64,
        /// How many fit.
        most: usize,
    },
    /// More than anyone wants to replay.
    #[error(
        "the log would hold about {readings:.0} readings, more than {limit}; shorten the path, or sample it less often"
    )]
    TooLong {
        /// How many readings it would hold.
        readings: f64,
        /// How many it may.
        limit: usize,
    },
    /// The log could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// All that a simulated log depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// What there is to hear.
    pub world: World,
    /// Where the robot goes.
    pub path: Path,
    /// How it goes there and when its sonars fire.
    pub motion: Motion,
    /// The sonars.
    pub ring: Ring,
    /// What goes wrong with their ranges.
    pub range_noise: RangeNoise,
    /// What goes wrong with the odometry.
    pub odometry_noise: OdometryNoise,
    /// Chooses the noise; equal seeds give equal noise.
    pub seed: u64,
}

impl Simulation {
    /// Drives the path and writes the log; gives the output back.
    pub fn write<W: Write + Seek>(&self, output: W) -> Result<W, SimulateError> {
        self.ring.validate()?;
        self.range_noise.validate()?;
        self.odometry_noise.validate()?;
        let ticks = self.motion.schedule(&self.path, self.ring.sonars)?;
        let mounts = self.ring.mounts();

        let mut log = LogWriter::new(output)?;
        let mounted: Vec<_> = mounts.iter().map(ring::Mount::transform).collect();
        log.static_transforms(START_NS, &mounted)?;
        log.world(START_NS, &self.world)?;

        let mut sonar_noise = NoisySonar::new(self.range_noise, self.seed);
        let mut odometry = DriftingOdometry::new(self.odometry_noise, self.seed);
        for tick in ticks {
            let stamp_ns = START_NS.saturating_add(tick.after_ns);
            match tick.action {
                Action::Odometry(twist) => {
                    let odom_from_robot = odometry.sample(tick.world_from_robot);
                    log.odometry(stamp_ns, odom_from_robot, twist)?;
                }
                Action::Fire(sonar) => {
                    let Some(mount) = mounts.get(sonar) else {
                        continue;
                    };
                    let world_from_sensor = tick.world_from_robot.compose(&mount.robot_from_sensor);
                    let echo = self.ring.listen(&self.world, world_from_sensor);
                    let measured = sonar_noise.measure(echo, &self.ring);
                    log.range(&self.message(stamp_ns, &mount.name, measured.range))?;
                    let truth = ReadingTruth::new(stamp_ns, &mount.name, echo, measured.outlier);
                    log.truth(&truth)?;
                }
            }
        }
        Ok(log.finish()?)
    }

    fn message<'a>(&self, stamp_ns: i64, sonar: &'a str, range: f32) -> RangeMessage<'a> {
        RangeMessage {
            stamp_ns,
            sonar,
            field_of_view: self.ring.beam_width as f32,
            min_range: self.ring.min_range as f32,
            max_range: self.ring.max_range as f32,
            range,
            variance: self.range_noise.variance() as f32,
        }
    }
}

/// Refuses a parameter outside `allowed`; `valid` is false for NaN when it is a comparison.
fn require(
    valid: bool,
    name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<(), SimulateError> {
    if valid {
        Ok(())
    } else {
        Err(SimulateError::Parameter {
            name,
            value,
            allowed,
        })
    }
}

/// Refuses what is not a standard deviation.
fn deviation(name: &'static str, value: f64) -> Result<(), SimulateError> {
    require(
        value >= 0.0 && value.is_finite(),
        name,
        value,
        "a standard deviation: 0 or more",
    )
}

/// Refuses what is not above zero.
fn positive(name: &'static str, value: f64) -> Result<(), SimulateError> {
    require(value > 0.0 && value.is_finite(), name, value, "above 0")
}

#[cfg(test)]
mod tests;
