//! Collects what the messages say and puts it together: sonars with names and mounts, readings and
//! odometry in stamp order.

mod stand_in;

use std::collections::BTreeMap;

pub use stand_in::STAND_IN;

use super::channels::ChannelReport;
use super::messages::{Content, HitsMessage, OdometryMessage, RangeMessage, Role};
use super::rings::Ring;
use super::sonars::{Placing, Source, SourceKey, Unplaced};
use super::transforms::{Origin, TransformTree};
use super::{Log, LogError, Loss, description, notes, repeats};
use crate::config::Config;
use crate::event::{Events, OdometrySample};
use crate::geometry::Pose2;

/// Everything said so far.
#[derive(Debug, Clone, Default)]
pub struct Gatherer {
    /// Every sonar, in the order of their first readings.
    sources: Vec<Source>,
    source_index: BTreeMap<SourceKey, usize>,
    readings: Vec<(usize, Unplaced)>,
    tracks: BTreeMap<String, Odometry>,
    transforms: TransformTree,
    /// Points of sonar rings, with the topic and the time they were recorded.
    hits: Vec<(String, i64, HitsMessage)>,
    notes: Vec<String>,
    messages: u64,
    unstamped: u64,
}

/// What one topic says of where the robot was.
#[derive(Debug, Clone)]
struct Odometry {
    role: Role,
    world_frame: String,
    robot_frame: String,
    samples: Vec<OdometrySample>,
    messages: u64,
    unstamped: u64,
    unusable: u64,
}

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
            Content::Description(urdf) => match description::fixed_joints(&urdf) {
                Ok(joints) => {
                    self.messages += 1;
                    for joint in joints {
                        self.transforms.add(joint, Origin::Description);
                    }
                }
                Err(error) => self.notes.push(format!(
                    "the robot's description on {topic} is left out: {error}"
                )),
            },
        }
    }

    fn take_range(&mut self, topic: &str, logged_ns: i64, range: RangeMessage) {
        let reading = Unplaced {
            stamp_ns: stamp(range.stamp_ns, logged_ns).saturating_add(range.delay_ns),
            range: range.range,
            min_range: range.min_range,
            max_range: range.max_range,
            beam_width: range.beam_width,
            likely_beam_width: range.likely_beam_width,
            variance: range.variance,
        };
        let key = SourceKey {
            topic: topic.to_owned(),
            frame: range.frame_id,
            element: range.element,
        };
        let index = match self.source_index.get(&key) {
            Some(index) => *index,
            None => {
                self.sources.push(Source {
                    key: key.clone(),
                    frame_from_beam: range.frame_from_beam,
                    turned: false,
                });
                self.source_index.insert(key, self.sources.len() - 1);
                self.sources.len() - 1
            }
        };
        if let Some(source) = self.sources.get_mut(index) {
            source.turned |= source.frame_from_beam != range.frame_from_beam;
        }
        self.readings.push((index, reading));
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
            });
        track.messages += 1;
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
        let readings = std::mem::take(&mut self.readings);
        let (sonars, mut readings) = placing.place(&self.sources, readings, &mut notes)?;
        let mut samples = odometry.samples;
        samples.sort_by_key(|s| s.stamp_ns);
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
        })
    }

    /// Turns the points of sonar rings into the ranges of the sonars whose mounts the configuration
    /// has.
    fn take_hits(
        &mut self,
        config: &Config,
        robot_frame: &str,
        world_frame: &str,
        channels: &mut [ChannelReport],
    ) {
        let hits = std::mem::take(&mut self.hits);
        let keys: Vec<&SourceKey> = self.sources.iter().map(|s| &s.key).collect();
        let ring = Ring::new(config, &|name| {
            keys.iter()
                .any(|key| key.frame == name || key.topic == name)
        });
        let mut strays = BTreeMap::<String, u64>::new();
        for (topic, logged_ns, cloud) in hits {
            let robot_frame = if robot_frame.is_empty() {
                self.transforms
                    .carrier(&cloud.frame_id, world_frame)
                    .unwrap_or(&cloud.frame_id)
            } else {
                robot_frame
            };
            let known = self.transforms.between(robot_frame, &cloud.frame_id);
            let (Some((robot_from_cloud, _)), false) = (known, ring.is_empty()) else {
                let problem = if ring.is_empty() {
                    "the points do not say where the sonars are that they come from; give x, y and yaw of \
                     each under [sonar.\"name\"] in the configuration"
                        .to_owned()
                } else {
                    format!(
                        "no transform joins its frame `{}` to `{robot_frame}`; if they are the same, set \
                         input.robot_frame",
                        cloud.frame_id
                    )
                };
                notes::refuse(channels, &topic, problem);
                continue;
            };
            self.messages += 1;
            self.unstamped += u64::from(cloud.stamp_ns == 0);
            let (ranges, unmatched) = ring.ranges(&cloud.points, &robot_from_cloud);
            *strays.entry(topic.clone()).or_default() += unmatched;
            for (sonar, range) in ranges {
                let range = RangeMessage::plain(cloud.stamp_ns, sonar, range);
                self.take_range(&topic, logged_ns, range);
            }
        }
        self.notes.extend(
            strays
                .into_iter()
                .filter(|(_, count)| *count > 0)
                .map(|(topic, count)| {
                    format!(
                        "{count} points on {topic} lie in no sonar's beam, or in one that has another; look \
                         at the mounts in the configuration"
                    )
                }),
        );
    }

    /// The one topic that says where the robot was. One that the configuration describes is meant
    /// to be used; poses serve where there is no odometry, or
    /// where the configuration asks for them.
    fn choose_odometry(
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

/// The message's own stamp, or the log's time where it has none.
fn stamp(stamp_ns: i64, logged_ns: i64) -> i64 {
    if stamp_ns == 0 { logged_ns } else { stamp_ns }
}
