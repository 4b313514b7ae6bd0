//! Names and mounts of the sonars, and their readings in order.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::stamps::Clock;
use super::transforms::{Mount, NoMount, TransformTree};
use super::{LogError, MissingMount};
use crate::config::{Config, SonarOverride};
use crate::event::{RangeReading, Sonar, SonarId};
use crate::geometry::Pose2;

/// What tells one sonar from another.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct SourceKey {
    /// The topic its readings come on.
    pub topic: String,
    /// Its frame.
    pub frame: String,
    /// Its place in a message that holds several.
    pub element: Option<usize>,
}

/// A sonar of which only the messages are known.
#[derive(Debug, Clone)]
pub struct Source {
    /// What tells it from the others.
    pub key: SourceKey,
    /// The beam in its first message: its axis is x.
    pub frame_from_beam: Isometry3<f64>,
    /// Whether a later message has the beam elsewhere.
    pub turned: bool,
    /// Beam width in its first message that has one, radians.
    beam_width: Option<f64>,
    /// What that is where neither messages nor configuration say it, radians.
    likely_beam_width: Option<f64>,
    /// When its messages were stamped and recorded.
    pub clock: Clock,
}

impl Source {
    /// A sonar before its first reading.
    pub fn new(key: &SourceKey, frame_from_beam: Isometry3<f64>) -> Self {
        Self {
            key: key.clone(),
            frame_from_beam,
            turned: false,
            beam_width: None,
            likely_beam_width: None,
            clock: Clock::default(),
        }
    }

    /// Takes what a message says of the beam's width, radians; 0 or NaN for nothing.
    pub fn learn(&mut self, beam_width: f64, likely_beam_width: f64) {
        self.beam_width = self.beam_width.or(usable(beam_width));
        self.likely_beam_width = self.likely_beam_width.or(usable(likely_beam_width));
    }
}

fn usable(width: f64) -> Option<f64> {
    (width > 0.0 && width.is_finite()).then_some(width)
}

/// What sonars are placed by.
#[derive(Debug, Clone, Copy)]
pub struct Placing<'a> {
    /// Name of the log.
    pub file: &'a str,
    /// Topic of the odometry.
    pub odometry_topic: &'a str,
    /// Frame that the odometry is in.
    pub world_frame: &'a str,
    /// Frame that the odometry moves; empty where it does not say it.
    pub robot_frame: &'a str,
    /// All transforms of the log.
    pub transforms: &'a TransformTree,
    /// What the user knows of sonars.
    pub config: &'a Config,
}

/// Sonars in their places.
#[derive(Debug)]
pub struct Placed {
    /// By name.
    pub sonars: Vec<Sonar>,
    /// By stamp, ties by sonar.
    pub readings: Vec<RangeReading>,
    /// By name.
    pub left_out: Vec<LeftOut>,
}

/// A sonar that cannot be used, while others can.
#[derive(Debug)]
pub struct LeftOut {
    sonar: String,
    index: usize,
    readings: u64,
    /// What is missing.
    pub why: LogError,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (sonar, readings) = (&self.sonar, self.readings);
        let plural = if readings == 1 { "" } else { "s" };
        write!(
            f,
            "sonar `{sonar}`, {readings} reading{plural}: left out, since {}",
            self.why.in_short()
        )
    }
}

/// That the odometry does not name the frame that it moves, with those that may be it.
struct NoRobotFrame {
    carriers: Vec<String>,
}

/// A source with its name and what the configuration says of it.
struct Named<'a> {
    source: &'a Source,
    name: String,
    /// The sonar's own; a ring's where it has none.
    known: SonarOverride,
    /// The mount of the frame: from the ring's name.
    frame_mount: Option<Pose2>,
    /// What the configuration says of the frame.
    ring: SonarOverride,
}

impl Placing<'_> {
    /// The sonars by name, and their readings by stamp; these come with the places of their sources
    /// for ids. A sonar that cannot be placed, or has no beam width, is left out.
    ///
    /// # Errors
    /// When none is left.
    pub fn place(
        &self,
        sources: &[Source],
        mut readings: Vec<RangeReading>,
        notes: &mut Vec<String>,
    ) -> Result<Placed, LogError> {
        let named = self.name(sources, notes);
        let robot_frame = self.robot_frame(&named, notes);
        let mut order: Vec<usize> = (0..named.len()).collect();
        order.sort_by(|a, b| {
            let name = |i: &usize| named.get(*i).map(|sonar| &sonar.name);
            name(a).cmp(&name(b))
        });
        let mut sonars = Vec::with_capacity(named.len());
        let mut left_out = Vec::new();
        let mut ids = vec![None; named.len()];
        for index in order {
            let (Some(sonar), Some(id)) = (named.get(index), ids.get_mut(index)) else {
                continue;
            };
            match self.mount_with(sonar, &robot_frame) {
                Ok(mount) => {
                    *id = Some(SonarId(u16::try_from(sonars.len()).map_err(|_| {
                        LogError::TooManySonars {
                            file: self.file.to_owned(),
                        }
                    })?));
                    notes.extend(on_mount(sonar, &mount));
                    sonars.push(Sonar {
                        name: sonar.name.clone(),
                        topic: sonar.source.key.topic.clone(),
                        robot_from_sensor: mount.robot_from_sensor,
                    });
                }
                Err(why) => left_out.push((index, why)),
            }
        }
        if sonars.is_empty() && !left_out.is_empty() {
            return Err(left_out.swap_remove(0).1);
        }
        let mut left_out: Vec<LeftOut> = left_out
            .into_iter()
            .filter_map(|(index, why)| {
                Some(LeftOut {
                    sonar: named.get(index)?.name.clone(),
                    index,
                    readings: 0,
                    why,
                })
            })
            .collect();
        let mut widths = vec![0_u64; named.len()];
        readings.retain_mut(|reading| {
            let index = reading.sonar.index();
            match (named.get(index), ids.get(index), widths.get_mut(index)) {
                (Some(sonar), Some(Some(id)), Some(lacking)) => {
                    reading.sonar = *id;
                    *lacking += u64::from(self.complete(sonar, reading));
                    true
                }
                _ => {
                    if let Some(sonar) = left_out.iter_mut().find(|sonar| sonar.index == index) {
                        sonar.readings += 1;
                    }
                    false
                }
            }
        });
        notes.extend(
            named
                .iter()
                .zip(widths)
                .filter_map(|(s, lacking)| on_width(s, lacking)),
        );
        let place = |r: &RangeReading| (r.stamp_ns, r.sonar);
        if !readings.is_sorted_by_key(place) {
            readings.sort_by_key(place); // which takes memory
        }
        Ok(Placed {
            sonars,
            readings,
            left_out,
        })
    }

    /// Where a sonar sits, if it has a beam width as well.
    fn mount_with(
        &self,
        sonar: &Named<'_>,
        robot_frame: &Result<String, NoRobotFrame>,
    ) -> Result<Mount, LogError> {
        let is_given = mount_of(&sonar.known).is_some() || sonar.frame_mount.is_some();
        let mount = match robot_frame {
            Ok(robot_frame) => self.mount(sonar, robot_frame)?,
            Err(_) if is_given => self.mount(sonar, "")?,
            Err(NoRobotFrame { carriers }) => {
                return Err(LogError::NoRobotFrame {
                    topic: self.odometry_topic.to_owned(),
                    carriers: carriers.clone(),
                });
            }
        };
        match self.beam_width(sonar) {
            Some(_) => Ok(mount),
            None => Err(LogError::NoBeamWidth {
                sonar: sonar.name.clone(),
                topic: sonar.source.key.topic.clone(),
            }),
        }
    }

    /// A sonar's name: its frame, or its topic where two topics share the frame; and its place in
    /// the message, where that holds several.
    fn name<'s>(&self, sources: &'s [Source], notes: &mut Vec<String>) -> Vec<Named<'s>> {
        let origins: BTreeSet<(&str, &str)> = sources
            .iter()
            .map(|s| (s.key.topic.as_str(), s.key.frame.as_str()))
            .collect();
        let (mut on_topic, mut in_frame) = (BTreeMap::new(), BTreeMap::new());
        for (topic, frame) in &origins {
            *on_topic.entry(*topic).or_insert(0) += 1;
            *in_frame.entry(*frame).or_insert(0) += 1;
        }
        let mut unused: BTreeSet<&str> = self.config.sonar.keys().map(String::as_str).collect();
        let named = sources.iter().map(|source| {
            let (topic, frame) = (source.key.topic.as_str(), source.key.frame.as_str());
            let only_of_topic = on_topic.get(topic) == Some(&1);
            let only_of_frame = in_frame.get(frame) == Some(&1);
            let whole = match (frame.is_empty(), only_of_frame, only_of_topic) {
                (false, true, _) => frame.to_owned(),
                (_, _, true) => topic.to_owned(),
                _ => format!("{topic}:{frame}"),
            };
            let name = match source.key.element {
                Some(element) => format!("{whole}[{element}]"),
                None => whole.clone(),
            };
            unused.remove(whole.as_str());
            unused.remove(name.as_str());
            let of = |name: &str| self.config.sonar.get(name).cloned().unwrap_or_default();
            let ring = source.key.element.map(|_| of(&whole)).unwrap_or_default();
            let own = of(&name);
            Named {
                source,
                name,
                frame_mount: mount_of(&ring),
                known: SonarOverride {
                    beam_width: own.beam_width.or(ring.beam_width),
                    min_range: own.min_range.or(ring.min_range),
                    max_range: own.max_range.or(ring.max_range),
                    ..own
                },
                ring,
            }
        });
        let named = named.collect();
        notes.extend(unused.into_iter().map(|name| {
            format!("the configuration describes sonar `{name}`, which the log does not have")
        }));
        named
    }

    /// The frame that the odometry moves: as it says, or else the one that carries every sonar
    /// whose mount is not in the configuration.
    fn robot_frame(
        &self,
        named: &[Named<'_>],
        notes: &mut Vec<String>,
    ) -> Result<String, NoRobotFrame> {
        let mut to_mount = named
            .iter()
            .filter(|sonar| mount_of(&sonar.known).is_none() && sonar.frame_mount.is_none())
            .map(|sonar| sonar.source.key.frame.as_str())
            .peekable();
        if !self.robot_frame.is_empty() || to_mount.peek().is_none() {
            return Ok(self.robot_frame.to_owned());
        }
        let frames: BTreeSet<&str> = to_mount.collect();
        let mut carriers: BTreeSet<&str> = frames
            .iter()
            .filter_map(|frame| self.transforms.carrier(frame, self.world_frame))
            .collect();
        // Messages that give their beams in the robot's own frame need no transform.
        if carriers.is_empty() && frames.len() == 1 {
            carriers = frames;
            carriers.retain(|frame| frame.starts_with("base"));
        }
        let mut found = carriers.iter();
        if let (Some(carrier), None) = (found.next(), found.next()) {
            notes.push(format!(
                "{} does not name the frame that it moves; `{carrier}` is taken, which carries the sonars \
                 (input.robot_frame sets another)",
                self.odometry_topic
            ));
            return Ok((*carrier).to_owned());
        }
        Err(NoRobotFrame {
            carriers: carriers.into_iter().map(Into::into).collect(),
        })
    }

    fn mount(&self, sonar: &Named<'_>, robot_frame: &str) -> Result<Mount, LogError> {
        let source = sonar.source;
        let found = match (mount_of(&sonar.known), sonar.frame_mount) {
            (Some(robot_from_sensor), _) => Ok(Mount {
                robot_from_sensor,
                tilt: None,
                moved: false,
            }),
            (None, Some(robot_from_frame)) => {
                Mount::projected(&(in_space(robot_from_frame) * source.frame_from_beam))
            }
            (None, None) if sonar.ring.has_mount() => self
                .transforms
                .mount(robot_frame, &source.key.frame, &Isometry3::identity())
                .and_then(|frame| {
                    let robot_from_frame = frame.overridden(&sonar.ring).robot_from_sensor;
                    Mount::projected(&(in_space(robot_from_frame) * source.frame_from_beam))
                }),
            (None, None) => {
                self.transforms
                    .mount(robot_frame, &source.key.frame, &source.frame_from_beam)
            }
        };
        let found = found.map(|mount| mount.overridden(&sonar.known));
        found.map_err(|why| {
            LogError::NoMount(Box::new(MissingMount {
                sonar: sonar.name.clone(),
                topic: source.key.topic.clone(),
                frame: source.key.frame.clone(),
                robot_frame: robot_frame.to_owned(),
                why: self.explain(why, &source.key.frame, robot_frame),
                frames: self
                    .transforms
                    .frames()
                    .into_iter()
                    .map(Into::into)
                    .collect(),
            }))
        })
    }

    fn explain(&self, why: NoMount, frame: &str, robot_frame: &str) -> String {
        match why {
            NoMount::Unconnected if frame.is_empty() => "its messages name no frame".to_owned(),
            NoMount::Unconnected if self.transforms.is_unusable(frame) => {
                format!("the transform of `{frame}` holds no pose (NaN, or a quaternion of zero)")
            }
            NoMount::Unconnected => format!("no transform joins it to `{robot_frame}`"),
            NoMount::Vertical => "its beam points straight up or down".to_owned(),
        }
    }

    /// The beam width of readings whose message does not say it, radians.
    fn beam_width(&self, sonar: &Named<'_>) -> Option<f64> {
        (sonar.source.beam_width)
            .or(sonar.known.beam_width)
            .or(self.config.sonars.beam_width)
            .or(sonar.source.likely_beam_width)
    }

    /// Puts into a reading what its message does not say; whether its beam width was that of others.
    fn complete(&self, sonar: &Named<'_>, reading: &mut RangeReading) -> bool {
        let known = &sonar.known;
        let own = usable(reading.beam_width);
        let width = own.or_else(|| self.beam_width(sonar));
        reading.beam_width = width.unwrap_or(reading.beam_width);
        reading.min_range = known.min_range.unwrap_or(reading.min_range);
        reading.max_range = known.max_range.unwrap_or(reading.max_range);
        own.is_none() && sonar.source.beam_width.is_some()
    }
}

fn on_width(sonar: &Named<'_>, lacking: u64) -> Option<String> {
    let width = sonar.source.beam_width?.to_degrees();
    (lacking > 0).then(|| {
        format!(
            "{lacking} readings of sonar `{}` give no beam width; the {width:.1} deg that its others give \
             are taken",
            sonar.name
        )
    })
}

fn mount_of(known: &SonarOverride) -> Option<Pose2> {
    Some(Pose2::new(known.x?, known.y?, known.yaw?))
}

fn in_space(pose: Pose2) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.yaw);
    Isometry3::from_parts([pose.x, pose.y, 0.0].into(), turn)
}

fn on_mount(sonar: &Named<'_>, mount: &Mount) -> Vec<String> {
    let name = &sonar.name;
    let tilted = mount.tilt.map(|tilt| {
        format!(
            "sonar `{name}` is tilted {:.1} deg out of the plane; its mount is projected and its ranges are taken as they are",
            tilt.to_degrees()
        )
    });
    let moved = mount.moved.then(|| {
        format!(
            "the mount of sonar `{name}` moves on /tf; its first pose is taken for the whole log"
        )
    });
    let turned = sonar.source.turned.then(|| {
        format!(
            "the beam of sonar `{name}` turns in its messages; its first bearing is taken for the whole log"
        )
    });
    [tilted, moved, turned].into_iter().flatten().collect()
}
