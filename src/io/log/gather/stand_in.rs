//! What a survey does to see past what stands in a replay's way.

use super::Gatherer;
use crate::io::log::message::{OdometryMessage, RangeMessage, Role};

/// Topic and frame of a message that stands in for all that is missing.
pub const STAND_IN: &str = "(none)";

impl Gatherer {
    /// Puts one invented message in the place of all that the log says in a role.
    pub fn stand_in(&mut self, role: Role) {
        match role {
            Role::Range => {
                self.sources.clear();
                self.source_index.clear();
                self.readings.clear();
                self.hits.clear();
                let reading = RangeMessage {
                    max_range: 1.0,
                    beam_width: 1.0,
                    ..RangeMessage::plain(0, STAND_IN, f64::NAN)
                };
                self.take_range(STAND_IN, 0, reading);
            }
            Role::Odometry => {
                self.tracks.clear();
                let sample = OdometryMessage {
                    stamp_ns: 0,
                    world_frame: String::new(),
                    robot_frame: String::new(),
                    world_from_robot: Some(nalgebra::Isometry3::identity()),
                };
                self.take_odometry(role, STAND_IN, 0, sample);
            }
            Role::Pose | Role::Transform | Role::Description => {}
        }
    }

    /// Forgets every odometry but one.
    pub fn keep_odometry(&mut self, topic: &str) {
        self.tracks.retain(|known, _| known == topic);
    }

    /// Names of all frames that a transform mentions.
    pub fn frames(&self) -> Vec<&str> {
        self.transforms.frames()
    }
}
