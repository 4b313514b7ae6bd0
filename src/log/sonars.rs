//! Names and mounts of the sonars, and their readings in order.

mod mounts;
mod names;
mod source;

use std::fmt;

pub use source::{Source, SourceKey};

use super::LogError;
use super::transforms::{Mount, TransformTree};
use crate::config::{Config, SonarOverride};
use crate::event::{RangeReading, Sonar, SonarId};
use crate::geometry::Pose2;
use source::usable;

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
