//! What sonars hear in place of an echo: each other, and sound that came by way of two walls.

use crate::core::geometry::Pose2;
use crate::core::truth::FalseEcho;
use crate::core::world::{Echo, World};

use super::error::{SimulateError, require};
use super::random::Random;
use super::ring::{Mount, Ring};

/// How often sonars hear what is no echo of their own. All zero: never.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FalseEchoes {
    /// Probability that a reading is of the sound of another sonar of the ring, which fires at the same
    /// time, where that one has an echo.
    pub cross_talk: f64,
    /// Probability that a reading is of sound that came by way of two walls, where there is such a way.
    pub double_reflections: f64,
}

impl FalseEchoes {
    /// Refuses what is no probability.
    pub fn validate(&self) -> Result<(), SimulateError> {
        for (name, value) in [
            ("the probability of cross-talk", self.cross_talk),
            (
                "the probability of a double reflection",
                self.double_reflections,
            ),
        ] {
            require((0.0..=1.0).contains(&value), name, value, "0 to 1")?;
        }
        Ok(())
    }
}

/// What a sonar hears at a place, without noise.
pub struct Heard {
    /// What was there to echo.
    pub echo: Option<Echo>,
    /// What is measured in its place.
    pub false_echo: Option<FalseEcho>,
    /// Metres; none where nothing is heard.
    pub range: Option<f64>,
}

/// The sonars of a ring in a world.
pub struct Listener<'a> {
    chances: FalseEchoes,
    world: &'a World,
    ring: &'a Ring,
    mounts: &'a [Mount],
    random: Random,
}

impl<'a> Listener<'a> {
    pub fn new(
        chances: FalseEchoes,
        world: &'a World,
        ring: &'a Ring,
        mounts: &'a [Mount],
        seed: u64,
    ) -> Self {
        Self {
            chances,
            world,
            ring,
            mounts,
            random: Random::new(seed, 2),
        }
    }

    /// What the sonar of a mount hears, its place in the ring being `index`.
    pub fn hear(&mut self, index: usize, mount: &Mount, world_from_robot: Pose2) -> Heard {
        // Always the same draws, so that one setting does not reshuffle another's chances.
        let is_cross_talk = self.random.uniform() < self.chances.cross_talk;
        let others = self.mounts.len().saturating_sub(1);
        let step = 1 + (self.random.uniform() * others as f64) as usize;
        let is_double = self.random.uniform() < self.chances.double_reflections;

        let world_from_sensor = world_from_robot.compose(&mount.robot_from_sensor);
        let echo = self.ring.listen(self.world, world_from_sensor);
        let of_other = || {
            let other = self.mounts.get((index + step) % self.mounts.len())?;
            let world_from_other = world_from_robot.compose(&other.robot_from_sensor);
            let echo = self.ring.listen(self.world, world_from_other)?;
            let back = (echo.place - world_from_sensor.position()).norm();
            Some((FalseEcho::CrossTalk, (echo.range + back) / 2.0))
        };
        let double = || {
            let Ring {
                beam_width,
                max_range,
                ..
            } = *self.ring;
            let range = (self.world).double_reflection(world_from_sensor, beam_width, max_range)?;
            Some((FalseEcho::DoubleReflection, range))
        };
        let heard = (is_cross_talk && others > 0)
            .then(of_other)
            .flatten()
            .or_else(|| is_double.then(double).flatten());
        let (false_echo, range) = heard.unzip();
        Heard {
            echo,
            false_echo,
            range: range.or(echo.map(|echo| echo.range)),
        }
    }
}
