//! What goes wrong with odometry: it drifts.

use crate::core::geometry::Pose2;

use super::random::Random;
use super::{SimulateError, deviation};

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
    pub(super) fn validate(&self) -> Result<(), SimulateError> {
        deviation("the distance noise in metres", self.distance)?;
        deviation("the heading noise in degrees", self.heading.to_degrees())?;
        deviation("the turn noise in degrees", self.turn.to_degrees())
    }
}

/// Odometry that adds up noisy increments.
pub(super) struct DriftingOdometry {
    noise: OdometryNoise,
    random: Random,
    /// The true pose and the drifted one at the last sample.
    last: Option<(Pose2, Pose2)>,
}

impl DriftingOdometry {
    pub(super) fn new(noise: OdometryNoise, seed: u64) -> Self {
        Self {
            noise,
            random: Random::new(seed, 1),
            last: None,
        }
    }

    /// What odometry says at `world_from_robot`; it starts out right.
    pub(super) fn sample(&mut self, world_from_robot: Pose2) -> Pose2 {
        let odom_from_robot = match self.last {
            Some((world_from_last, odom_from_last)) if self.noise != OdometryNoise::default() => {
                let last_from_robot = self.disturb(relative(world_from_last, world_from_robot));
                odom_from_last.compose(&last_from_robot)
            }
            _ => world_from_robot,
        };
        self.last = Some((world_from_robot, odom_from_robot));
        odom_from_robot
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
        Pose2::new(driven.x, driven.y, increment.yaw + swing)
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
mod tests {
    use super::*;
    use crate::tools::simulate::random::tests::mean_and_deviation;

    #[test]
    fn odometry_drifts_with_the_root_of_the_way() {
        let noise = OdometryNoise {
            distance: 0.02,
            heading: 0.0,
            turn: 0.01,
        };
        let ends: Vec<_> = (0..2000)
            .map(|seed| {
                let mut odometry = DriftingOdometry::new(noise, seed);
                let poses = (0..=40).map(|i| Pose2::new(0.1 * f64::from(i), 0.0, 0.0));
                poses.map(|pose| odometry.sample(pose).x).last().unwrap()
            })
            .collect();
        let (mean, deviation) = mean_and_deviation(&ends);
        assert!((mean - 4.0).abs() < 0.005);
        assert!((deviation - 0.02 * 2.0).abs() < 0.003, "{deviation}");
    }

    #[test]
    fn perfect_odometry_is_the_truth_to_the_last_bit() {
        let mut odometry = DriftingOdometry::new(OdometryNoise::default(), 1);
        for i in 0..100 {
            let pose = Pose2::new(0.1 * f64::from(i), 0.3, 0.7 * f64::from(i));
            assert_eq!(odometry.sample(pose), pose);
        }
    }
}
