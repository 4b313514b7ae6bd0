//! Collects what the messages of a log say, channel by channel.

use std::collections::BTreeMap;

use super::channels::Message;
use super::description;
use super::message::{Content, HitsMessage, MOST_SONARS, RangeMessage, Role, TransformMessage};
use super::moving::Moving;
use super::odometry::{Odometry, stamp};
use super::sonars::{Source, SourceKey};
use super::transforms::{Origin, TransformTree};
use crate::core::event::{RangeReading, SonarId};

/// Topic and frame of a message that stands in for all that is missing.
pub const STAND_IN: &str = "(none)";

/// More descriptions than this are passed over: a robot has one.
const MOST_DESCRIPTIONS: usize = 16;

/// Everything said so far.
#[derive(Debug, Clone, Default)]
pub struct Gatherer {
    /// Every sonar, in the order of their first readings.
    pub sources: Vec<Source>,
    source_index: BTreeMap<SourceKey, usize>,
    /// Each with the place of its sonar in `sources` for an id.
    pub readings: Vec<RangeReading>,
    /// Whether there are more sonars than can be told apart.
    pub crowded: bool,
    pub tracks: BTreeMap<String, Odometry>,
    pub transforms: TransformTree,
    /// Transforms that may say where the robot was, as long as no odometry does.
    pub moving: Moving,
    /// Points of sonar rings, with the topic and the time they were recorded.
    pub hits: Vec<(String, i64, HitsMessage)>,
    descriptions: usize,
    last_description: String,
    pub notes: Vec<String>,
    /// Those that are used whatever odometry is chosen.
    pub messages: u64,
    pub unstamped: u64,
}

impl Gatherer {
    /// Takes what one message says.
    pub fn take(&mut self, message: Message<'_>, log_time: u64) {
        let (role, topic) = (message.role, message.topic);
        let logged_ns = i64::try_from(log_time).unwrap_or(i64::MAX);
        match message.content {
            Content::Ranges(ranges) => {
                self.messages += 1;
                self.unstamped += u64::from(ranges.first().is_some_and(|r| r.stamp_ns == 0));
                for range in ranges {
                    self.take_range(topic, logged_ns, range);
                }
            }
            Content::Odometry(odometry) => {
                self.take_odometry(role, topic, logged_ns, odometry);
            }
            Content::Transforms(transforms) => {
                self.messages += 1;
                let origin = if topic.ends_with("tf_static") {
                    Origin::Fixed
                } else {
                    Origin::Moving
                };
                let no_odometry = |track: &Odometry| track.role != Role::Odometry;
                let may_move = origin == Origin::Moving && self.tracks.values().all(no_odometry);
                for transform in transforms {
                    if may_move {
                        self.moving.take(topic, logged_ns, &transform);
                    }
                    self.transforms.add(transform, origin);
                }
            }
            Content::Hits(hits) => self.hits.push((topic.to_owned(), logged_ns, hits)),
            Content::Crowd(_) => {}
            // A latched topic repeats what it said.
            Content::Description(urdf) if urdf == self.last_description => self.messages += 1,
            Content::Description(_) if self.descriptions >= MOST_DESCRIPTIONS => {}
            Content::Description(urdf) => self.take_description(topic, urdf),
        }
    }

    fn take_description(&mut self, topic: &str, urdf: String) {
        self.descriptions += 1;
        match description::fixed_joints(&urdf) {
            Ok(joints) => {
                self.messages += 1;
                for joint in joints {
                    self.transforms.add(joint, Origin::Description);
                }
            }
            Err(error) => self.notes.push(format!(
                "the robot's description on {topic} is left out: {error}"
            )),
        }
        self.last_description = urdf;
    }

    pub fn take_range(&mut self, topic: &str, logged_ns: i64, range: RangeMessage) {
        let key = SourceKey {
            topic: topic.to_owned(),
            frame: range.frame_id,
            element: range.element,
        };
        let index = match self.source_index.get(&key) {
            Some(index) => *index,
            None if self.sources.len() == MOST_SONARS => {
                self.crowded = true;
                return;
            }
            None => {
                self.sources.push(Source::new(&key, range.frame_from_beam));
                self.source_index.insert(key, self.sources.len() - 1);
                self.sources.len() - 1
            }
        };
        let (Some(source), Ok(id)) = (self.sources.get_mut(index), u16::try_from(index)) else {
            return;
        };
        source.turned |= source.frame_from_beam != range.frame_from_beam;
        source.learn(range.beam_width, range.likely_beam_width);
        // The beams of a ring share their message's stamp.
        if range.element.is_none_or(|element| element == 0) {
            source.clock.take(range.stamp_ns, logged_ns);
        }
        self.readings.push(RangeReading {
            stamp_ns: stamp(range.stamp_ns, logged_ns).saturating_add(range.delay_ns),
            sonar: SonarId(id),
            range: range.range,
            min_range: range.min_range,
            max_range: range.max_range,
            beam_width: range.beam_width,
            variance: range.variance,
        });
    }

    fn take_odometry(&mut self, role: Role, topic: &str, logged_ns: i64, pose: TransformMessage) {
        if role == Role::Odometry {
            self.moving.clear();
        }
        let track = self.tracks.entry(topic.to_owned());
        let track = track.or_insert_with(|| Odometry::new(role));
        track.take(logged_ns, &pose);
    }

    /// Puts one invented message in the place of all that the log says in a role, to see past what stands
    /// in a replay's way.
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
                let sample = TransformMessage {
                    stamp_ns: 0,
                    parent: String::new(),
                    child: String::new(),
                    parent_from_child: Some(nalgebra::Isometry3::identity()),
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
}
