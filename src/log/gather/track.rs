//! Which topic says where the robot was.

use super::Gatherer;
use crate::config::Config;
use crate::event::OdometrySample;
use crate::log::channels::ChannelReport;
use crate::log::messages::Role;
use crate::log::stamps::Clock;
use crate::log::{LogError, notes};

/// What one topic says of where the robot was.
#[derive(Debug, Clone)]
pub struct Odometry {
    pub role: Role,
    pub world_frame: String,
    pub robot_frame: String,
    pub samples: Vec<OdometrySample>,
    pub messages: u64,
    pub unstamped: u64,
    pub unusable: u64,
    pub clock: Clock,
}

impl Gatherer {
    /// The one topic that says where the robot was. One that the configuration describes is meant
    /// to be used; poses serve where there is no odometry,
    /// or where the configuration asks for them.
    pub(super) fn choose_odometry(
        &mut self,
        file: &str,
        config: &Config,
        channels: &mut [ChannelReport],
    ) -> Result<(String, Odometry), LogError> {
        let by_type = config.input.odometry_topics.is_empty();
        if by_type && self.tracks.keys().any(|t| config.channel.contains_key(t)) {
            self.tracks
                .retain(|topic, _| config.channel.contains_key(topic));
        }
        if by_type && self.tracks.values().any(|t| t.role == Role::Odometry) {
            self.tracks.retain(|_, track| track.role == Role::Odometry);
        }
        if self.tracks.len() > 1 {
            return Err(LogError::ManyOdometries {
                file: file.to_owned(),
                topics: self.tracks.keys().cloned().collect(),
            });
        }
        let (topic, track) = self
            .tracks
            .pop_first()
            .filter(|(_, track)| !track.samples.is_empty())
            .ok_or_else(|| LogError::NoOdometry {
                file: file.to_owned(),
                asked: config.input.odometry_topics.clone(),
                found: channels.iter().map(notes::describe).collect(),
            })?;
        for channel in channels {
            let says_where = matches!(channel.role, Some(Role::Odometry | Role::Pose));
            channel.used &= !says_where || channel.topic == topic;
        }
        Ok((topic, track))
    }
}
