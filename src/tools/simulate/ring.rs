//! The ring: sonars evenly round the robot, facing outward.

use std::f64::consts::{PI, TAU};

use crate::core::geometry::{Pose2, unit};
use crate::core::world::{Echo, World};
use crate::io::log::writer::{ROBOT_FRAME, Transform};

use super::error::{SimulateError, require};

/// Height of the sonars above the robot's origin, metres. Nothing depends on it.
const HEIGHT: f64 = 0.2;

/// The most sonars that a ring may have.
const MAX_SONARS: usize = 1000;

/// Farther than any sonar in air reaches, metres.
const MAX_RANGE: f64 = 10_000.0;

/// A ring of equal sonars; sonar 0 looks forward, the others follow counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// How many.
    pub sonars: usize,
    /// From the robot's origin to each, metres.
    pub radius: f64,
    /// Full opening angle of a beam, radians.
    pub beam_width: f64,
    /// Closest distance that can be measured, metres.
    pub min_range: f64,
    /// Farthest, metres.
    pub max_range: f64,
}

/// Sixteen sonars as in the paper, with beams of 22.5 degrees.
impl Default for Ring {
    fn default() -> Self {
        Self {
            sonars: 16,
            radius: 0.2,
            beam_width: PI / 8.0,
            min_range: 0.2,
            max_range: 10.0,
        }
    }
}

/// One sonar of a ring.
pub struct Mount {
    /// Its frame id.
    pub name: String,
    /// Where it is; its beam is along x.
    pub robot_from_sensor: Pose2,
}

impl Mount {
    /// The mounting as a log tells it.
    pub fn transform(&self) -> Transform<'_> {
        Transform {
            parent: ROBOT_FRAME,
            child: &self.name,
            parent_from_child: self.robot_from_sensor,
            height: HEIGHT,
        }
    }
}

impl Ring {
    /// Refuses what cannot be built or cannot measure.
    pub fn validate(&self) -> Result<(), SimulateError> {
        require(
            (1..=MAX_SONARS).contains(&self.sonars),
            "the number of sonars",
            self.sonars as f64,
            "1 to 1000",
        )?;
        require(
            self.radius >= 0.0 && self.radius.is_finite(),
            "the ring's radius in metres",
            self.radius,
            "0 or more",
        )?;
        require(
            self.beam_width > 0.0 && self.beam_width <= PI,
            "the beam width in degrees",
            self.beam_width.to_degrees(),
            "above 0 and at most 180",
        )?;
        require(
            self.min_range >= 0.0 && self.min_range < self.max_range,
            "the minimum range in metres",
            self.min_range,
            "0 or more and below the maximum range",
        )?;
        require(
            self.max_range <= MAX_RANGE,
            "the maximum range in metres",
            self.max_range,
            "at most 10000",
        )
    }

    /// What one of its sonars would hear in `world` if nothing went wrong.
    pub fn listen(&self, world: &World, world_from_sensor: Pose2) -> Option<Echo> {
        world.echo(world_from_sensor, self.beam_width, self.max_range)
    }

    /// The sonars, in order.
    pub fn mounts(&self) -> Vec<Mount> {
        // Names of one width, so that they sort as the sonars do.
        let digits = self.sonars.saturating_sub(1).to_string().len().max(2);
        let mount = |index: usize| {
            let bearing = TAU * index as f64 / self.sonars as f64;
            let position = unit(bearing) * self.radius;
            Mount {
                name: format!("sonar_{index:0digits$}"),
                robot_from_sensor: Pose2::new(position.x, position.y, bearing),
            }
        };
        (0..self.sonars).map(mount).collect()
    }
}

/// The order in which `sonars` fire in turn: bits reversed, so that neighbours in time look far
/// apart and do not hear each other.
pub fn firing_order(sonars: usize) -> Vec<usize> {
    let mut order = vec![0];
    while order.len() < sonars {
        let doubled = order.iter().map(|index| index * 2);
        order = doubled
            .clone()
            .chain(doubled.map(|index| index + 1))
            .collect();
    }
    order.retain(|index| *index < sonars);
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sonars_look_outward_from_the_ring() {
        let ring = Ring::default();
        let mounts = ring.mounts();
        assert_eq!(mounts.len(), 16);
        for (index, mount) in mounts.iter().enumerate() {
            let pose = mount.robot_from_sensor;
            assert_eq!(mount.name, format!("sonar_{index:02}"));
            assert!((pose.position() - unit(pose.yaw) * ring.radius).norm() < 1e-12);
        }
        assert!((mounts[4].robot_from_sensor.y - 0.2).abs() < 1e-12, "left");
    }

    #[test]
    fn names_sort_as_the_sonars_do() {
        let ring = Ring {
            sonars: 120,
            ..Ring::default()
        };
        let names: Vec<_> = ring.mounts().into_iter().map(|mount| mount.name).collect();
        assert!(names.is_sorted());
        assert_eq!(names[7], "sonar_007");
    }

    #[test]
    fn every_sonar_fires_once_and_neighbours_do_not_follow_each_other() {
        let order = firing_order(16);
        assert_eq!(order[..6], [0, 8, 4, 12, 2, 10]);
        for sonars in 1..40 {
            let mut order = firing_order(sonars);
            order.sort_unstable();
            assert!(order.into_iter().eq(0..sonars));
        }
    }

    #[test]
    fn an_impossible_ring_is_refused() {
        let good = Ring::default();
        for bad in [
            Ring { sonars: 0, ..good },
            Ring {
                sonars: 1001,
                ..good
            },
            Ring {
                radius: -0.1,
                ..good
            },
            Ring {
                beam_width: 0.0,
                ..good
            },
            Ring {
                beam_width: f64::NAN,
                ..good
            },
            Ring {
                min_range: 10.0,
                ..good
            },
            Ring {
                max_range: f64::INFINITY,
                ..good
            },
        ] {
            assert!(bad.validate().is_err(), "{bad:?}");
        }
        assert!(good.validate().is_ok());
    }
}
