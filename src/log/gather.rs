//! Collects what the messages say and puts it together: sonars with names and mounts, readings and
//! odometry in stamp order.

mod hits;
mod stand_in;
mod track;

use std::collections::BTreeMap;

pub use stand_in::STAND_IN;

use super::channels::ChannelReport;
use super::container::Loss;
use super::messages::{Content, HitsMessage, MOST_SONARS, OdometryMessage, RangeMessage, Role};
use super::sonars::{Placing, Source, SourceKey};
use super::stamps::{self, Clock};
use super::transforms::{Origin, TransformTree};
use super::{Log, LogError, description, notes, repeats};
use crate::config::Config;
use crate::event::{Events, OdometrySample, RangeReading, SonarId};
use crate::geometry::Pose2;
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
    pub fn take(&mut self, role: Role, topic: &str, log_time: u64, content: Content) {
        let logged_ns = i64::try_from(log_time).unwrap_or(i64::MAX);
        match content {
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
                for transform in transforms {
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
        let track = self
            .tracks
            .entry(topic.to_owned())
            .or_insert_with(|| Odometry {
                role,
                world_frame: message.world_frame,
                robot_frame: message.robot_frame,
                samples: Vec::new(),
                messages: 0,
                unstamped: 0,
                unusable: 0,
                clock: Clock::default(),
            });
        track.messages += 1;
        track.clock.take(message.stamp_ns, logged_ns);
        track.unstamped += u64::from(message.stamp_ns == 0);
        let Some(pose) = message.world_from_robot else {
            track.unusable += 1;
            return;
        };
        let forward = pose.rotation * nalgebra::Vector3::x();
        let position = pose.translation.vector;
        track.samples.push(OdometrySample {
            stamp_ns: stamp(message.stamp_ns, logged_ns),
            world_from_robot: Pose2::new(position.x, position.y, libm::atan2(forward.y, forward.x)),
        });
    }

    /// Puts everything together.
    ///
    /// # Errors
    /// When something is missing without which nothing can be replayed.
    pub fn finish(
        mut self,
        file: String,
        config: &Config,
        mut channels: Vec<ChannelReport>,
        losses: Vec<Loss>,
    ) -> Result<Log, LogError> {
        let no_ranges = |channels: &[ChannelReport]| LogError::NoRanges {
            file: file.clone(),
            asked: config.input.range_topics.clone(),
            found: channels.iter().map(notes::describe).collect(),
        };
        if self.crowded {
            return Err(LogError::TooManySonars { file });
        }
        if self.readings.is_empty() && self.hits.is_empty() {
            return Err(no_ranges(&channels));
        }
        let (topic, odometry) = self.choose_odometry(&file, config, &mut channels)?;
        let robot_frame = config
            .input
            .robot_frame
            .as_deref()
            .unwrap_or(&odometry.robot_frame);
        self.take_hits(config, robot_frame, &odometry.world_frame, &mut channels);
        if self.crowded {
            return Err(LogError::TooManySonars { file });
        }
        if self.readings.is_empty() {
            return Err(no_ranges(&channels));
        }
        let mut notes = notes::on_channels(&channels);
        notes.append(&mut self.notes);
        let unused = config
            .channel
            .keys()
            .filter(|topic| !channels.iter().any(|c| c.topic == **topic));
        notes.extend(unused.map(|topic| {
            format!("the configuration describes channel `{topic}`, which the log does not have")
        }));
        let unstamped = self.unstamped + odometry.unstamped;
        if unstamped > 0 {
            notes.push(format!(
                "{unstamped} messages have no stamp in their header; the time they were recorded is taken"
            ));
        }
        if odometry.unusable > 0 {
            notes.push(format!(
                "{} odometry messages on {topic} hold no pose (NaN, or a quaternion of zero) and were left out",
                odometry.unusable
            ));
        }
        notes.extend(self.transforms.note());
        if odometry.role == Role::Pose && config.input.odometry_topics.is_empty() {
            notes.push(format!(
                "the log has no odometry; the poses on {topic} are taken for it"
            ));
        }
        let placing = Placing {
            file: &file,
            odometry_topic: &topic,
            world_frame: &odometry.world_frame,
            robot_frame,
            transforms: &self.transforms,
            config,
        };
        let (sonars, mut readings) = placing.place(&self.sources, self.readings, &mut notes)?;
        let mut samples = odometry.samples;
        samples.sort_by_key(|s| s.stamp_ns);
        notes.extend(stamps::twins(&readings));
        let ranges: Vec<&Clock> = self.sources.iter().map(|source| &source.clock).collect();
        let clock_jump = stamps::jump(&ranges, &odometry.clock);
        let mut time_notes = Vec::new();
        time_notes.extend(stamps::skew(&ranges, &odometry.clock));
        time_notes.extend(stamps::backward(&ranges, &odometry.clock));
        time_notes.extend(stamps::uncovered(&readings, &samples, &config.frames));
        let repeating = repeats::find(&readings, &samples, config.input.range_delay, sonars.len());
        let dropped = config.input.drop_repeats;
        notes.extend(repeats::note(&readings, &repeating, &sonars, dropped));
        if dropped {
            let mut repeating = repeating.into_iter();
            readings.retain(|_| repeating.next() != Some(true));
        }
        Ok(Log {
            file,
            events: Events {
                sonars,
                readings,
                odometry: samples,
            },
            messages: self.messages + odometry.messages,
            losses: notes::on_losses(&losses, &channels),
            channels,
            notes,
            clock_jump,
            time_notes,
        })
    }
}

/// The message's own stamp, or the log's time where it has none.
fn stamp(stamp_ns: i64, logged_ns: i64) -> i64 {
    if stamp_ns == 0 { logged_ns } else { stamp_ns }
}
