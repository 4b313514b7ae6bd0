//! Collects what the messages say and puts it together: sonars with names and mounts, readings and
//! odometry in stamp order.

use std::collections::BTreeMap;

use super::channels::ChannelReport;
use super::messages::{self, OdometryMessage, RangeMessage, Role};
use super::transforms::{Mount, NoMount, TransformTree};
use super::value::{FieldError, Value};
use super::{Log, LogError, Loss, MissingMount};
use crate::config::{Config, SonarOverride};
use crate::event::{Events, OdometrySample, RangeReading, Sonar, SonarId};
use crate::geometry::Pose2;

/// Topic and frame of an invented message.
pub const STAND_IN: &str = "(none)";

/// Everything said so far.
#[derive(Debug, Clone, Default)]
pub struct Gatherer {
    /// Topic and frame of every sonar, in the order of their first readings.
    sources: Vec<(String, String)>,
    source_index: BTreeMap<(String, String), usize>,
    readings: Vec<(usize, Unplaced)>,
    odometries: BTreeMap<String, Odometry>,
    transforms: TransformTree,
    messages: u64,
    unstamped: u64,
}

/// A range reading of a sonar that is not yet known by name.
#[derive(Debug, Clone, Copy)]
struct Unplaced {
    stamp_ns: i64,
    range: f64,
    min_range: f64,
    max_range: f64,
    beam_width: f64,
    variance: f64,
}

#[derive(Debug, Clone, Default)]
struct Odometry {
    robot_frame: String,
    samples: Vec<OdometrySample>,
    unusable: u64,
}

impl Gatherer {
    /// Takes one message.
    ///
    /// # Errors
    /// A field that the message lacks.
    pub fn take(
        &mut self,
        role: Role,
        topic: &str,
        log_time: u64,
        message: &Value,
    ) -> Result<(), FieldError> {
        match role {
            Role::Range => {
                let range = messages::range(message)?;
                let stamp_ns = self.stamp(range.stamp_ns, log_time);
                self.take_range(topic, stamp_ns, range);
            }
            Role::Odometry => {
                let odometry = messages::odometry(message)?;
                let stamp_ns = self.stamp(odometry.stamp_ns, log_time);
                self.take_odometry(topic, stamp_ns, odometry);
            }
            Role::Transform => {
                let fixed = topic.ends_with("tf_static");
                for transform in messages::transforms(message)? {
                    self.transforms.add(transform, fixed);
                }
            }
        }
        self.messages += 1;
        Ok(())
    }

    /// The message's own stamp, or the log's time where it has none.
    fn stamp(&mut self, stamp_ns: i64, log_time: u64) -> i64 {
        if stamp_ns != 0 {
            return stamp_ns;
        }
        self.unstamped += 1;
        i64::try_from(log_time).unwrap_or(i64::MAX)
    }

    fn take_range(&mut self, topic: &str, stamp_ns: i64, range: RangeMessage) {
        let source = (topic.to_owned(), range.frame_id);
        let index = match self.source_index.get(&source) {
            Some(index) => *index,
            None => {
                self.sources.push(source.clone());
                self.source_index.insert(source, self.sources.len() - 1);
                self.sources.len() - 1
            }
        };
        let reading = Unplaced {
            stamp_ns,
            range: range.range,
            min_range: range.min_range,
            max_range: range.max_range,
            beam_width: range.beam_width,
            variance: range.variance,
        };
        self.readings.push((index, reading));
    }

    fn take_odometry(&mut self, topic: &str, stamp_ns: i64, message: OdometryMessage) {
        let track = self.odometries.entry(topic.to_owned()).or_default();
        if track.robot_frame.is_empty() {
            track.robot_frame = message.robot_frame;
        }
        let Some(pose) = message.world_from_robot else {
            track.unusable += 1;
            return;
        };
        let forward = pose.rotation * nalgebra::Vector3::x();
        let position = pose.translation.vector;
        track.samples.push(OdometrySample {
            stamp_ns,
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
        channels: Vec<ChannelReport>,
        losses: Vec<Loss>,
    ) -> Result<Log, LogError> {
        let mut notes = notes_on(&channels);
        if self.unstamped > 0 {
            notes.push(format!(
                "{} messages have no stamp in their header; the time they were recorded is taken",
                self.unstamped
            ));
        }
        if self.readings.is_empty() {
            return Err(LogError::NoRanges {
                file,
                asked: config.input.range_topics.clone(),
                found: channels.iter().map(describe).collect(),
            });
        }
        let (topic, odometry) = self.choose_odometry(&file, config, &channels)?;
        if odometry.unusable > 0 {
            notes.push(format!(
                "{} odometry messages on {topic} hold no pose (NaN, or a quaternion of zero) and were left out",
                odometry.unusable
            ));
        }
        let robot_frame = config
            .input
            .robot_frame
            .clone()
            .unwrap_or_else(|| odometry.robot_frame.clone());
        let (sonars, ids) = self.place_sonars(&file, &topic, &robot_frame, config, &mut notes)?;
        let readings = self.place_readings(&sonars, &ids, config)?;
        let mut samples = odometry.samples;
        samples.sort_by_key(|s| s.stamp_ns);
        Ok(Log {
            file,
            events: Events {
                sonars,
                readings,
                odometry: samples,
            },
            messages: self.messages,
            losses: describe_losses(&losses, &channels),
            channels,
            notes,
        })
    }

    fn choose_odometry(
        &mut self,
        file: &str,
        config: &Config,
        channels: &[ChannelReport],
    ) -> Result<(String, Odometry), LogError> {
        if self.odometries.len() > 1 {
            return Err(LogError::ManyOdometries {
                file: file.to_owned(),
                topics: self.odometries.keys().cloned().collect(),
            });
        }
        self.odometries
            .pop_first()
            .filter(|(_, track)| !track.samples.is_empty())
            .ok_or_else(|| LogError::NoOdometry {
                file: file.to_owned(),
                asked: config.input.odometry_topics.clone(),
                found: channels.iter().map(describe).collect(),
            })
    }

    /// The sonars by name, and the id of each source.
    fn place_sonars(
        &self,
        file: &str,
        odometry_topic: &str,
        robot_frame: &str,
        config: &Config,
        notes: &mut Vec<String>,
    ) -> Result<(Vec<Sonar>, Vec<SonarId>), LogError> {
        let names = self.names();
        let mut order: Vec<usize> = (0..self.sources.len()).collect();
        order.sort_by(|a, b| names.get(*a).cmp(&names.get(*b)));
        let mut sonars = Vec::with_capacity(order.len());
        let mut ids = vec![SonarId(0); order.len()];
        for (place, source) in order.into_iter().enumerate() {
            let (Some((topic, frame)), Some(name)) = (self.sources.get(source), names.get(source))
            else {
                continue;
            };
            let known = config.sonar.get(name).cloned().unwrap_or_default();
            let robot_from_sensor = match mount_of(&known) {
                Some(mount) => mount,
                None if robot_frame.is_empty() => {
                    return Err(LogError::NoRobotFrame {
                        topic: odometry_topic.to_owned(),
                    });
                }
                None => {
                    let mount = self.transforms.mount(robot_frame, frame).map_err(|why| {
                        LogError::NoMount(Box::new(MissingMount {
                            sonar: name.clone(),
                            topic: topic.clone(),
                            frame: frame.clone(),
                            robot_frame: robot_frame.to_owned(),
                            why: explain(why, frame, robot_frame),
                            frames: self
                                .transforms
                                .frames()
                                .into_iter()
                                .map(Into::into)
                                .collect(),
                        }))
                    })?;
                    notes_on_mount(name, &mount, notes);
                    mount.robot_from_sensor
                }
            };
            if let Some(id) = ids.get_mut(source) {
                *id = SonarId(u16::try_from(place).map_err(|_| LogError::TooManySonars {
                    file: file.to_owned(),
                })?);
            }
            sonars.push(Sonar {
                name: name.clone(),
                topic: topic.clone(),
                robot_from_sensor,
            });
        }
        let unused = config.sonar.keys().filter(|name| !names.contains(name));
        notes.extend(unused.map(|name| {
            format!("the configuration describes sonar `{name}`, which the log does not have")
        }));
        Ok((sonars, ids))
    }

    /// A sonar's name: its frame, or its topic where two topics share the frame.
    fn names(&self) -> Vec<String> {
        let same = |test: &dyn Fn(&(String, String)) -> bool| {
            self.sources.iter().filter(|source| test(source)).count()
        };
        self.sources
            .iter()
            .map(|(topic, frame)| {
                let frame_is_unique = same(&|(_, other)| other == frame) == 1;
                let topic_is_unique = same(&|(other, _)| other == topic) == 1;
                match (frame.is_empty(), frame_is_unique, topic_is_unique) {
                    (false, true, _) => frame.clone(),
                    (_, _, true) => topic.clone(),
                    _ => format!("{topic}:{frame}"),
                }
            })
            .collect()
    }

    fn place_readings(
        &mut self,
        sonars: &[Sonar],
        ids: &[SonarId],
        config: &Config,
    ) -> Result<Vec<RangeReading>, LogError> {
        let mut readings = Vec::with_capacity(self.readings.len());
        for (source, unplaced) in std::mem::take(&mut self.readings) {
            let Some((id, sonar)) = ids
                .get(source)
                .and_then(|id| Some((*id, sonars.get(id.index())?)))
            else {
                continue;
            };
            let known = config.sonar.get(&sonar.name);
            let usable = |width: f64| width > 0.0 && width.is_finite();
            let beam_width = Some(unplaced.beam_width)
                .filter(|width| usable(*width))
                .or(known.and_then(|known| known.beam_width))
                .or(config.sonars.beam_width)
                .ok_or_else(|| LogError::NoBeamWidth {
                    sonar: sonar.name.clone(),
                    topic: sonar.topic.clone(),
                })?;
            readings.push(RangeReading {
                stamp_ns: unplaced.stamp_ns,
                sonar: id,
                range: unplaced.range,
                min_range: known
                    .and_then(|k| k.min_range)
                    .unwrap_or(unplaced.min_range),
                max_range: known
                    .and_then(|k| k.max_range)
                    .unwrap_or(unplaced.max_range),
                beam_width,
                variance: unplaced.variance,
            });
        }
        readings.sort_by_key(|r| (r.stamp_ns, r.sonar));
        Ok(readings)
    }
}

/// What a survey does to see past what stands in a replay's way.
impl Gatherer {
    /// Puts one invented message in the place of all that the log says in a role.
    pub fn stand_in(&mut self, role: Role) {
        match role {
            Role::Range => {
                self.sources.clear();
                self.source_index.clear();
                self.readings.clear();
                let reading = RangeMessage {
                    stamp_ns: 0,
                    frame_id: STAND_IN.to_owned(),
                    range: f64::NAN,
                    min_range: 0.0,
                    max_range: 1.0,
                    beam_width: 1.0,
                    variance: 0.0,
                };
                self.take_range(STAND_IN, 0, reading);
            }
            Role::Odometry => {
                self.odometries.clear();
                let sample = OdometryMessage {
                    stamp_ns: 0,
                    robot_frame: String::new(),
                    world_from_robot: Some(nalgebra::Isometry3::identity()),
                };
                self.take_odometry(STAND_IN, 0, sample);
            }
            Role::Transform => {}
        }
    }

    /// Forgets every odometry but one.
    pub fn keep_odometry(&mut self, topic: &str) {
        self.odometries.retain(|known, _| known == topic);
    }

    /// Names of all frames that a transform mentions.
    pub fn frames(&self) -> Vec<&str> {
        self.transforms.frames()
    }
}

fn mount_of(known: &SonarOverride) -> Option<Pose2> {
    Some(Pose2::new(known.x?, known.y?, known.yaw?))
}

fn explain(why: NoMount, frame: &str, robot_frame: &str) -> String {
    match why {
        NoMount::Unconnected if frame.is_empty() => "its messages name no frame".to_owned(),
        NoMount::Unconnected => format!("no transform joins it to `{robot_frame}`"),
        NoMount::Vertical => "its beam points straight up or down".to_owned(),
    }
}

fn notes_on_mount(name: &str, mount: &Mount, notes: &mut Vec<String>) {
    if let Some(tilt) = mount.tilt {
        notes.push(format!(
            "sonar `{name}` is tilted {:.1} deg out of the plane; its mount is projected and its ranges are taken as they are",
            tilt.to_degrees()
        ));
    }
    if mount.moved {
        notes.push(format!(
            "the mount of sonar `{name}` moves on /tf; its first pose is taken for the whole log"
        ));
    }
}

fn describe(channel: &ChannelReport) -> String {
    let problem = match &channel.problem {
        Some(problem) => format!(": {problem}"),
        None => String::new(),
    };
    let type_name = if channel.type_name.is_empty() {
        "no type"
    } else {
        &channel.type_name
    };
    format!(
        "{} ({type_name}, {}, {} messages{problem})",
        channel.topic, channel.encoding, channel.messages
    )
}

/// Channels that would have been used and cannot be.
fn notes_on(channels: &[ChannelReport]) -> Vec<String> {
    channels
        .iter()
        .filter(|channel| !channel.used && channel.undecoded == 0)
        .filter_map(|channel| {
            let problem = channel.problem.as_ref()?;
            Some(format!("{} is left out: {problem}", channel.topic))
        })
        .collect()
}

fn describe_losses(losses: &[Loss], channels: &[ChannelReport]) -> Vec<String> {
    let of_file = losses.iter().map(ToString::to_string);
    let of_channels = channels.iter().filter(|c| c.undecoded > 0).map(|channel| {
        format!(
            "{} of {} messages on {}: {}",
            channel.undecoded,
            channel.messages,
            channel.topic,
            channel.problem.as_deref().unwrap_or_default()
        )
    });
    of_file.chain(of_channels).collect()
}
