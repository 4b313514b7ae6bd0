//! Collects what the messages say and puts it together: sonars with names and mounts, readings and
//! odometry in stamp order.

mod by_transforms;
mod finish;
mod hits;
mod moving;
mod renamed;
mod stand_in;
mod track;

use std::collections::BTreeMap;

pub use stand_in::STAND_IN;

use nalgebra::Isometry3;

use super::channels::Message;
use super::description;
use super::message::{Content, HitsMessage, MOST_SONARS, OdometryMessage, RangeMessage, Role};
use super::sonars::{Source, SourceKey};
use super::transforms::{Origin, TransformTree};
use crate::core::event::{OdometrySample, RangeReading, SonarId};
use crate::core::geometry::Pose2;
use moving::Moving;
use track::Odometry;

/// Everything said so far.
#[derive(Debug, Clone, Default)]
pub struct Gatherer {
    /// Every sonar, in the order of their first readings.
    sources: Vec<Source>,
    source_index: BTreeMap<SourceKey, usize>,
    /// Each with the place of its sonar in `sources` for an id.
    readings: Vec<RangeReading>,
    /// Whether there are more sonars than can be told apart.
    crowded: bool,
    tracks: BTreeMap<String, Odometry>,
    transforms: TransformTree,
    /// Transforms that may say where the robot was, as long as no odometry does.
    moving: Moving,
    /// Points of sonar rings, with the topic and the time they were recorded.
    hits: Vec<(String, i64, HitsMessage)>,
    descriptions: usize,
    notes: Vec<String>,
    messages: u64,
    unstamped: u64,
}

/// More descriptions than this are passed over: a robot has one.
const MOST_DESCRIPTIONS: usize = 16;

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
                        let stamp_ns = stamp(transform.stamp_ns, logged_ns);
                        let sample = |pose: &_| in_plane(stamp_ns, pose);
                        self.moving.take(topic, logged_ns, &transform, sample);
                    }
                    self.transforms.add(transform, origin);
                }
            }
            Content::Hits(hits) => self.hits.push((topic.to_owned(), logged_ns, hits)),
            Content::Crowd(_) => {}
            Content::Description(_) if self.descriptions >= MOST_DESCRIPTIONS => {}
            Content::Description(urdf) => self.take_description(topic, &urdf),
        }
    }

    fn take_description(&mut self, topic: &str, urdf: &str) {
        self.descriptions += 1;
        match description::fixed_joints(urdf) {
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
    }

    fn take_range(&mut self, topic: &str, logged_ns: i64, range: RangeMessage) {
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

    fn take_odometry(&mut self, role: Role, topic: &str, logged_ns: i64, message: OdometryMessage) {
        if role == Role::Odometry {
            self.moving.clear();
        }
        let track = self
            .tracks
            .entry(topic.to_owned())
            .or_insert_with(|| Odometry::new(role));
        track.messages += 1;
        track.clock.take(message.stamp_ns, logged_ns);
        track.unstamped += u64::from(message.stamp_ns == 0);
        let Some(pose) = &message.world_from_robot else {
            track.unusable += 1;
            return;
        };
        let sample = in_plane(stamp(message.stamp_ns, logged_ns), pose);
        track.take(&message.world_frame, &message.robot_frame, sample);
    }
}

/// A pose laid into the plane.
fn in_plane(stamp_ns: i64, world_from_robot: &Isometry3<f64>) -> OdometrySample {
    let forward = world_from_robot.rotation * nalgebra::Vector3::x();
    let position = world_from_robot.translation.vector;
    OdometrySample {
        stamp_ns,
        world_from_robot: Pose2::new(position.x, position.y, libm::atan2(forward.y, forward.x)),
    }
}

/// The message's own stamp, or the log's time where it has none.
fn stamp(stamp_ns: i64, logged_ns: i64) -> i64 {
    if stamp_ns == 0 { logged_ns } else { stamp_ns }
}
