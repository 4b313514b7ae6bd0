//! Names and mounts of the sonars, and their readings in order.

mod mounts;
mod names;
mod notes;
mod source;

use std::fmt;

pub use source::{Source, SourceKey};

use super::LogError;
use super::transforms::{Mount, TransformTree};
use crate::core::config::{Config, SonarOverride};
use crate::core::event::{RangeReading, Sonar, SonarId};
use crate::core::geometry::Pose2;
use crate::core::wording::counted;
pub use notes::TOO_WIDE;
pub use source::WIDEST_BEAM;
use source::{is_senseless, usable};

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
        let readings = counted(self.readings, "reading");
        write!(
            f,
            "sonar `{}`, {readings}: left out, since {}",
            self.sonar,
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
        let mut mounts = Vec::with_capacity(named.len());
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
                    mounts.push((sonar, mount));
                    sonars.push(Sonar {
                        name: sonar.name.clone(),
                        topic: sonar.source.key.topic.clone(),
                        robot_from_sensor: mount.robot_from_sensor,
                    });
                }
                Err(why) => left_out.push((index, why)),
            }
        }
        notes.extend(self::notes::on_mounts(&mounts));
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
        let placed: Vec<&Named<'_>> = mounts.iter().map(|(sonar, _)| *sonar).collect();
        notes.extend(self::notes::on_missing_widths(&named, &widths));
        notes.extend(self::notes::on_senseless_widths(&placed, self));
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

    /// The beam width of readings whose message does not say it, radians.
    fn beam_width(&self, sonar: &Named<'_>) -> Option<f64> {
        (sonar.known.beam_width)
            .or(sonar
                .source
                .beam_width
                .filter(|width| !is_senseless(*width)))
            .or(self.config.sonars.beam_width)
            .or(sonar.source.beam_width)
            .or(sonar.source.likely_beam_width)
    }

    /// The beam width that stands before a message's own, radians.
    fn overruling(&self, sonar: &Named<'_>, own: f64) -> Option<f64> {
        let for_all = self.config.sonars.beam_width;
        (sonar.known.beam_width).or(for_all.filter(|_| is_senseless(own)))
    }

    /// Puts into a reading what its message does not say; whether its beam width was that of others.
    fn complete(&self, sonar: &Named<'_>, reading: &mut RangeReading) -> bool {
        let known = &sonar.known;
        let own = usable(reading.beam_width);
        let overruling = own.and_then(|own| self.overruling(sonar, own));
        let width = overruling.or(own).or_else(|| self.beam_width(sonar));
        reading.beam_width = width.unwrap_or(reading.beam_width);
        reading.min_range = known.min_range.unwrap_or(reading.min_range);
        reading.max_range = known.max_range.unwrap_or(reading.max_range);
        own.is_none() && known.beam_width.is_none() && sonar.source.beam_width.is_some()
    }
}

fn mount_of(known: &SonarOverride) -> Option<Pose2> {
    Some(Pose2::new(known.x?, known.y?, known.yaw?))
}
