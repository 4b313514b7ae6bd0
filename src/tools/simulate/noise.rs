//! What goes wrong: noisy, missing and spurious echoes, and odometry that drifts.

use crate::core::geometry::Pose2;

use super::error::{SimulateError, deviation, require};
use super::random::Random;
use super::ring::Ring;

/// What goes wrong with a reading. All zero: nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RangeNoise {
    /// Standard deviation of an echo's range, metres.
    pub sigma: f64,
    /// Probability that an echo is not heard.
    pub no_echo: f64,
    /// Probability that a reading is replaced by a range drawn evenly from all that the sonar can
    /// measure, whether there was an echo or not.
    pub outliers: f64,
}

impl RangeNoise {
    /// The variance that the sonar reports, square metres.
    pub fn variance(&self) -> f64 {
        self.sigma * self.sigma
    }

    /// Refuses what is not a deviation or a probability.
    pub fn validate(&self) -> Result<(), SimulateError> {
        deviation("the range noise in metres", self.sigma)?;
        for (name, value) in [
            ("the probability of no echo", self.no_echo),
            ("the probability of an outlier", self.outliers),
        ] {
            require((0.0..=1.0).contains(&value), name, value, "0 to 1")?;
        }
        Ok(())
    }
}

/// What a sonar made of an echo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Metres, as REP-117 has it: +inf for no echo, -inf for an echo too close to measure.
    pub range: f32,
    /// Whether the range has nothing to do with the echo.
    pub outlier: bool,
}

/// Sonars with noise.
pub struct NoisySonar {
    noise: RangeNoise,
    random: Random,
}

impl NoisySonar {
    pub fn new(noise: RangeNoise, seed: u64) -> Self {
        Self {
            noise,
            random: Random::new(seed, 0),
        }
    }

    /// The reading that an echo from `range` metres gives a sonar of `ring`.
    pub fn measure(&mut self, range: Option<f64>, ring: &Ring) -> Measured {
        let Ring {
            min_range,
            max_range,
            ..
        } = *ring;
        // Always the same draws, so that one setting does not reshuffle another's noise.
        let deviation = self.random.normal() * self.noise.sigma;
        let lost = self.random.uniform() < self.noise.no_echo;
        let outlier = self.random.uniform() < self.noise.outliers;
        let anywhere = min_range + (max_range - min_range) * self.random.uniform();

        let range = if outlier {
            anywhere
        } else {
            range
                .filter(|_| !lost)
                .map_or(f64::INFINITY, |range| range + deviation)
        } as f32;
        Measured {
            range: if range >= max_range as f32 {
                f32::INFINITY
            } else if range < min_range as f32 {
                f32::NEG_INFINITY
            } else {
                range
            },
            outlier,
        }
    }
}

/// How odometry drifts: random walks, so that each deviation grows with the square root of what
/// was driven or turned. All zero: not at all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OdometryNoise {
    /// Standard deviation of the distance after a metre, metres.
    pub distance: f64,
    /// Standard deviation of the heading after a metre, radians.
    pub heading: f64,
    /// Standard deviation of the heading after turning by a radian, radians.
    pub turn: f64,
}

impl OdometryNoise {
    /// Refuses what is not a deviation.
    pub fn validate(&self) -> Result<(), SimulateError> {
        deviation("the distance noise in metres", self.distance)?;
        deviation("the heading noise in degrees", self.heading.to_degrees())?;
        deviation("the turn noise in degrees", self.turn.to_degrees())
    }
}

/// Odometry that adds up noisy increments.
pub struct DriftingOdometry {
    noise: OdometryNoise,
    /// What distances and turns are multiplied with.
    scales: [f64; 2],
    random: Random,
    /// The true pose and the drifted one at the last sample.
    last: Option<(Pose2, Pose2)>,
}

impl DriftingOdometry {
    pub fn new(noise: OdometryNoise, scales: [f64; 2], seed: u64) -> Self {
        Self {
            noise,
            scales,
            random: Random::new(seed, 1),
            last: None,
        }
    }

    /// What odometry says at `world_from_robot`; it starts out right.
    pub fn sample(&mut self, world_from_robot: Pose2) -> Pose2 {
        let odom_from_robot = match self.last {
            Some((world_from_last, odom_from_last)) if self.drifts() => {
                let last_from_robot = self.disturb(relative(world_from_last, world_from_robot));
                odom_from_last.compose(&last_from_robot)
            }
            _ => world_from_robot,
        };
        self.last = Some((world_from_robot, odom_from_robot));
        odom_from_robot
    }

    /// Whether it will be anywhere else than where the robot is.
    pub fn drifts(&self) -> bool {
        self.noise != OdometryNoise::default() || self.scales != [1.0, 1.0]
    }

    fn disturb(&mut self, increment: Pose2) -> Pose2 {
        let driven = increment.position();
        let distance = driven.norm();
        let turned = increment.yaw.abs();
        let OdometryNoise {
            distance: per_metre,
            heading,
            turn,
        } = self.noise;
        let stretch = self.random.normal() * per_metre * distance.sqrt();
        let swing =
            self.random.normal() * (heading * heading * distance + turn * turn * turned).sqrt();
        let driven = match driven.try_normalize(0.0) {
            Some(forward) => driven + forward * stretch,
            None => driven,
        };
        let [distance, turn] = self.scales;
        let driven = driven * distance;
        Pose2::new(driven.x, driven.y, (increment.yaw + swing) * turn)
    }
}

/// `last_from_robot` of two poses in the world.
fn relative(world_from_last: Pose2, world_from_robot: Pose2) -> Pose2 {
    let position = world_from_last.inverse_transform(world_from_robot.position());
    Pose2::new(
        position.x,
        position.y,
        world_from_robot.yaw - world_from_last.yaw,
    )
}

#[cfg(test)]
mod tests;
