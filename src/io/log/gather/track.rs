//! Which topic says where the robot was.

use super::Gatherer;
use crate::core::config::Config;
use crate::core::event::OdometrySample;
use crate::core::wording::counted;
use crate::io::log::channels::ChannelReport;
use crate::io::log::message::Role;
use crate::io::log::stamps::Clock;
use crate::io::log::strays;
use crate::io::log::{LogError, notes};

/// More names of frames on one topic than this are damage in any case.
const MOST_NAMES: usize = 64;

/// What one topic says of where the robot was.
#[derive(Debug, Clone)]
pub struct Odometry {
    pub role: Role,
    /// Poses by the frames that their messages name, in the order of their first messages.
    poses: Vec<Named>,
    pub messages: u64,
    pub unstamped: u64,
    pub unusable: u64,
    pub clock: Clock,
}

#[derive(Debug, Clone)]
struct Named {
    world_frame: String,
    robot_frame: String,
    samples: Vec<OdometrySample>,
}

/// Where the robot was, by the one topic that is used.
#[derive(Debug, Clone)]
pub struct Chosen {
    pub topic: String,
    pub role: Role,
    pub world_frame: String,
    pub robot_frame: String,
    /// In file order.
    pub samples: Vec<OdometrySample>,
    pub messages: u64,
    pub unstamped: u64,
    pub unusable: u64,
    pub clock: Clock,
    /// What was left out, because it names other frames.
    pub losses: Vec<String>,
    /// That it names several frames and all are used, or what it was taken from.
    pub notes: Vec<String>,
}

impl Odometry {
    /// A topic of which no message was taken yet.
    pub fn new(role: Role) -> Self {
        Self {
            role,
            poses: Vec::new(),
            messages: 0,
            unstamped: 0,
            unusable: 0,
            clock: Clock::default(),
        }
    }

    /// Takes a pose of one frame in another.
    pub fn take(&mut self, world_frame: &str, robot_frame: &str, sample: OdometrySample) {
        let is_same = |n: &&mut Named| n.world_frame == world_frame && n.robot_frame == robot_frame;
        let is_full = self.poses.len() == MOST_NAMES;
        match self.poses.iter_mut().find(is_same) {
            Some(known) => known.samples.push(sample),
            None if is_full => self.unusable += 1,
            None => self.poses.push(Named {
                world_frame: world_frame.to_owned(),
                robot_frame: robot_frame.to_owned(),
                samples: vec![sample],
            }),
        }
    }

    /// Takes all of another track, under the names that it has there. The clock stays the busier one's.
    pub fn absorb(&mut self, other: Self) {
        if other.len() > self.len() {
            let quieter = std::mem::replace(&mut self.clock, other.clock);
            self.clock.absorb(quieter);
        } else {
            self.clock.absorb(other.clock);
        }
        self.messages += other.messages;
        self.unstamped += other.unstamped;
        self.unusable += other.unusable;
        self.poses.extend(other.poses);
    }

    /// The robot's frame taken for the world's and the world's for the robot's.
    pub fn turned_round(mut self) -> Self {
        for named in &mut self.poses {
            std::mem::swap(&mut named.world_frame, &mut named.robot_frame);
            for sample in &mut named.samples {
                sample.world_from_robot = sample.world_from_robot.inverse();
            }
        }
        self
    }

    /// Its samples by stamp, whatever frames they name.
    pub fn in_order(&self) -> Vec<OdometrySample> {
        let all = self.poses.iter().flat_map(|named| &named.samples);
        let mut samples: Vec<OdometrySample> = all.copied().collect();
        samples.sort_by_key(|sample| sample.stamp_ns);
        samples
    }

    /// Only some of its samples.
    pub fn retain(&mut self, is_kept: impl Fn(&OdometrySample) -> bool) {
        for named in &mut self.poses {
            named.samples.retain(&is_kept);
        }
        self.poses.retain(|named| !named.samples.is_empty());
    }

    /// Only the poses in a frame.
    pub fn keep_world(&mut self, world_frame: &str) {
        self.poses.retain(|named| named.world_frame == world_frame);
    }

    /// The frames that it gives poses of, with those that they are in.
    pub fn edges(&self) -> Vec<(String, String)> {
        let edge = |named: &Named| (named.world_frame.clone(), named.robot_frame.clone());
        self.poses.iter().map(edge).collect()
    }

    /// Poses that it has.
    pub fn len(&self) -> usize {
        self.poses.iter().map(|named| named.samples.len()).sum()
    }

    /// The frames that most of its messages name. What only a few name is left out as damaged, and
    /// what many do is used: a node that was started again with other names.
    pub fn choose(self, topic: String) -> Option<Chosen> {
        let all = self.len();
        let mut poses = self.poses;
        // Of equally many the first.
        let most = (0..poses.len())
            .rev()
            .max_by_key(|i| poses.get(*i).map(|n| n.samples.len()))?;
        let named = poses.remove(most);
        let mut samples = named.samples;
        let usual = samples.len();
        let (mut lost, mut lost_names, mut other_names) = (0, Vec::new(), Vec::new());
        for other in poses {
            let name = format!("`{}` in `{}`", other.robot_frame, other.world_frame);
            if strays::is_handful(other.samples.len(), usual) {
                lost += other.samples.len();
                lost_names.push(name);
            } else {
                samples.extend(other.samples);
                other_names.push(name);
            }
        }
        let usual_name = format!("`{}` in `{}`", named.robot_frame, named.world_frame);
        let what = if self.role == Role::Transform {
            "transform"
        } else {
            "message"
        };
        let loss = (lost > 0).then(|| {
            format!(
                "{lost} of {} on {topic} {} the pose of {}, all others that of {usual_name}: they are taken for \
                 damaged and left out",
                counted(all as u64, what),
                if lost == 1 { "gives" } else { "give" },
                strays::few(&lost_names)
            )
        });
        let note = (!other_names.is_empty()).then(|| {
            format!(
                "{what}s on {topic} give the pose of {usual_name} and of {}; all are taken for one track",
                strays::few(&other_names)
            )
        });
        Some(Chosen {
            losses: loss.into_iter().collect(),
            notes: note.into_iter().collect(),
            topic,
            role: self.role,
            world_frame: named.world_frame,
            robot_frame: named.robot_frame,
            samples,
            messages: self.messages,
            unstamped: self.unstamped,
            unusable: self.unusable,
            clock: self.clock,
        })
    }
}

impl Gatherer {
    /// The one topic that says where the robot was. One that the configuration describes is meant
    /// to be used; poses serve where there is no odometry, or where the configuration asks for them;
    /// and transforms where there are no poses, or fewer of them.
    pub(super) fn choose_odometry(
        &mut self,
        file: &str,
        config: &Config,
        channels: &mut [ChannelReport],
    ) -> Result<Chosen, LogError> {
        let by_type = config.input.odometry_topics.is_empty();
        if by_type && self.tracks.keys().any(|t| config.channel.contains_key(t)) {
            self.tracks
                .retain(|topic, _| config.channel.contains_key(topic));
        }
        if by_type && self.tracks.values().any(|t| t.role == Role::Odometry) {
            self.tracks.retain(|_, track| track.role == Role::Odometry);
        }
        if let Some(moving) = self.by_transforms(config, file)? {
            return Ok(moving);
        }
        if self.tracks.len() > 1 {
            return Err(LogError::ManyOdometries {
                file: file.to_owned(),
                topics: self.tracks.keys().cloned().collect(),
            });
        }
        if let Some(frame) = &config.input.world_frame {
            let found: Vec<(String, String)> =
                self.tracks.values().flat_map(Odometry::edges).collect();
            for track in self.tracks.values_mut() {
                track.keep_world(frame);
            }
            if !found.is_empty() && self.tracks.values().all(|track| track.len() == 0) {
                return Err(LogError::NoSuchFrame {
                    file: file.to_owned(),
                    frame: frame.clone(),
                    key: "input.world_frame",
                    moving: found,
                });
            }
        }
        for topic in self
            .tracks
            .iter()
            .filter(|(_, t)| t.len() == 0)
            .map(|(topic, _)| topic)
        {
            notes::refuse(channels, topic, notes::NO_POSE.to_owned());
        }
        let passed_over = self.passed_over(config);
        let chosen = self
            .tracks
            .pop_first()
            .and_then(|(topic, track)| track.choose(topic))
            .ok_or_else(|| LogError::NoOdometry {
                file: file.to_owned(),
                asked: config.input.odometry_topics.clone(),
                found: notes::candidates(channels, &[Role::Odometry, Role::Pose, Role::Transform]),
                passed_over,
            })?;
        for channel in channels {
            let says_where = matches!(channel.role, Some(Role::Odometry | Role::Pose));
            channel.used &= !says_where || channel.topic == chosen.topic;
        }
        Ok(chosen)
    }
}
