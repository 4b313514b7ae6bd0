//! What a log says otherwise than it is: the configuration that would mend it is what is true of the robot.

use crate::core::calibrate::change::configured_delay;
use crate::core::config::{Config, SonarDefaults, SonarOverride};
use crate::core::geometry::Pose2;

use super::error::{SimulateError, known};
use super::ring::Mount;

/// The keys that a log can be made to need.
pub const KEYS: &str = "input.range_delay, input.range_clock_rate, input.odometry_scale, input.odometry_turn_scale, \
     sonars.range_scale, sonars.range_offset, and x, y, yaw, range_scale, range_offset and \
     range_delay of sonar.NAME";

/// A configuration that the log needs to be right.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Untold(pub Config);

impl Untold {
    /// Refuses keys that nothing can be made to need, and sonars that there are not.
    pub fn validate(&self, told: &[Mount]) -> Result<(), SimulateError> {
        let mut rest = self.0.clone();
        let plain = Config::default();
        rest.input.range_delay = plain.input.range_delay;
        rest.input.range_clock_rate = plain.input.range_clock_rate;
        rest.input.odometry_scale = plain.input.odometry_scale;
        rest.input.odometry_turn_scale = plain.input.odometry_turn_scale;
        rest.sonars = SonarDefaults {
            range_scale: plain.sonars.range_scale,
            range_offset: plain.sonars.range_offset,
            ..rest.sonars
        };
        for (name, sonar) in std::mem::take(&mut rest.sonar) {
            let others = SonarOverride {
                x: None,
                y: None,
                yaw: None,
                range_scale: None,
                range_offset: None,
                range_delay: None,
                ..sonar
            };
            if others != SonarOverride::default() {
                return Err(SimulateError::CannotNeed);
            }
            known(&name, told.iter().map(|mount| mount.name.as_str()))?;
        }
        if rest == plain {
            Ok(())
        } else {
            Err(SimulateError::CannotNeed)
        }
    }

    /// Where the sonars are, of where they are said to be.
    pub fn mounts(&self, told: &[Mount]) -> Vec<Mount> {
        let placed = |mount: &Mount| {
            let known = self.0.sonar.get(&mount.name).cloned().unwrap_or_default();
            let told = mount.robot_from_sensor;
            Mount {
                name: mount.name.clone(),
                robot_from_sensor: Pose2::new(
                    known.x.unwrap_or(told.x),
                    known.y.unwrap_or(told.y),
                    known.yaw.unwrap_or(told.yaw),
                ),
            }
        };
        told.iter().map(placed).collect()
    }

    /// How long after the start a reading is said to be taken, nanoseconds.
    pub fn stamp_after_ns(&self, after_ns: i64, sonar: &str) -> i64 {
        let input = &self.0.input;
        let late = after_ns as f64 + (input.range_delay + configured_delay(&self.0, sonar)) * 1e9;
        libm::rint(late / (1.0 - input.range_clock_rate)) as i64
    }

    /// What a sonar says of a distance, metres.
    pub fn range(&self, sonar: &str, range: f32) -> f32 {
        let own = self.0.sonar.get(sonar);
        let all = &self.0.sonars;
        let scale = own.and_then(|own| own.range_scale).or(all.range_scale);
        let offset = own.and_then(|own| own.range_offset).or(all.range_offset);
        if scale.is_none() && offset.is_none() {
            return range;
        }
        ((f64::from(range) - offset.unwrap_or(0.0)) / scale.unwrap_or(1.0)) as f32
    }

    /// What odometry's distances and turns are multiplied with.
    pub fn odometry(&self) -> [f64; 2] {
        let input = &self.0.input;
        [input.odometry_scale, input.odometry_turn_scale].map(|scale| 1.0 / scale)
    }
}
