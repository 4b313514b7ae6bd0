//! Where the robot was by the transforms that move, for a log without odometry messages.

use std::collections::BTreeSet;

use super::Gatherer;
use super::moving::{Course, Edge, sounds_like_a_robot};
use super::renamed::{self, Claim};
use super::track::{Chosen, Odometry};
use crate::core::config::Config;
use crate::core::pattern::glob_set;
use crate::io::log::LogError;
use crate::io::log::message::Role;

impl Gatherer {
    /// The transform that moves the robot, where no message of another kind says as often where it is.
    ///
    /// # Errors
    /// Where it cannot be told which transform that is, and nothing else says where the robot was.
    pub(super) fn by_transforms(
        &self,
        config: &Config,
        file: &str,
    ) -> Result<Option<Chosen>, LogError> {
        let is_odometry = |track: &Odometry| track.role == Role::Odometry;
        if self.tracks.values().any(is_odometry) {
            return Ok(None);
        }
        let courses = self.courses(config)?;
        let carriers = self.carriers();
        let poses = self.tracks.values().map(Odometry::len).max().unwrap_or(0);
        let is_candidate = |(edge, course): &(&Edge, &Course)| {
            (course.moved || sounds_like_a_robot(edge))
                && !self.is_below(config, &carriers, edge, course)
        };
        let candidates: Vec<(&Edge, &Course)> =
            courses.iter().copied().filter(is_candidate).collect();
        let children = robots(config, &carriers, &candidates);
        let of_robot = (candidates.iter().copied())
            .filter(|((_, child), _)| children.contains(child.as_str()))
            .max_by_key(|(_, course)| course.track.len())
            .filter(|_| children.len() == 1);
        let is_carrier = |(edge, _): &(&Edge, &Course)| is_robot(config, &carriers, &edge.1);
        // A transform to the odometry's frame, from the robot's: better than a frame of which nothing
        // says that it is the robot's.
        if !of_robot.as_ref().is_some_and(is_carrier) {
            let back = self.way_back(config, &carriers, &courses, poses);
            if back.is_some() {
                return Ok(back);
            }
        }
        let moving = || candidates.iter().map(|(edge, _)| (*edge).clone()).collect();
        match of_robot {
            Some((edge, course)) if course.track.len() > poses => {
                let strays = self.strays((edge, course));
                let strays = strays.map(|(edge, course)| Claim::forwards(edge, course));
                let rivals = courses.iter().filter(|(other, course)| {
                    *other != edge && course.moved && may_be_the_same(edge, other)
                });
                let rivals = rivals.map(|(edge, course)| Claim::forwards(edge, course));
                let claim = Claim::forwards(edge, course);
                let joined = renamed::joined(claim, strays, rivals, self.first_reading());
                let mut note = taken(edge, course, poses);
                Ok(joined.choose(course.topic.clone()).map(|mut chosen| {
                    chosen.notes.insert(0, std::mem::take(&mut note));
                    chosen
                }))
            }
            _ if poses > 0 => Ok(None),
            Some(_) => Ok(None),
            None if candidates.is_empty() => match &config.input.world_frame {
                Some(frame) if self.moving.courses().next().is_some() => {
                    Err(LogError::NoSuchFrame {
                        file: file.to_owned(),
                        frame: frame.clone(),
                        key: "input.world_frame",
                        moving: (self.moving.courses())
                            .filter(|(_, course)| course.moved)
                            .map(|(edge, _)| edge.clone())
                            .collect(),
                    })
                }
                _ => Ok(None),
            },
            None => match &config.input.robot_frame {
                Some(frame) => Err(LogError::NoSuchFrame {
                    file: file.to_owned(),
                    frame: frame.clone(),
                    key: "input.robot_frame",
                    moving: moving(),
                }),
                None => Err(LogError::UnclearTransforms {
                    file: file.to_owned(),
                    moving: moving(),
                }),
            },
        }
    }

    /// The transforms that move and are not looked at: what the robot carries.
    pub(super) fn passed_over(&self, config: &Config) -> Vec<Edge> {
        let courses = self.courses(config).unwrap_or_default();
        let carriers = self.carriers();
        let carried = courses
            .into_iter()
            .filter(|(edge, course)| self.is_below(config, &carriers, edge, course));
        carried.map(|(edge, _)| edge.clone()).collect()
    }

    /// The transforms on the topics and in the frame that are asked for, without those whose names are
    /// damaged ones of others.
    fn courses(&self, config: &Config) -> Result<Vec<(&Edge, &Course)>, LogError> {
        let asked = &config.input.odometry_topics;
        let topics = glob_set(asked)?;
        let is_asked = |(edge, course): &(&Edge, &Course)| {
            let world = config.input.world_frame.as_ref();
            course.track.len() > 1
                && (asked.is_empty() || topics.is_match(&course.topic))
                && world.is_none_or(|world| edge.0 == *world || edge.1 == *world)
        };
        let all: Vec<(&Edge, &Course)> = self.moving.courses().filter(is_asked).collect();
        let is_stray = |one: &(&Edge, &Course)| all.iter().any(|o| self.is_stray(*one, *o));
        Ok(all.iter().copied().filter(|one| !is_stray(one)).collect())
    }

    /// Whether a transform is another one that a few damaged messages name otherwise.
    fn is_stray(&self, one: (&Edge, &Course), usual: (&Edge, &Course)) -> bool {
        renamed::is_stray(one, usual, || {
            self.transforms.is_below(&one.0.0, &usual.0.1)
        })
    }

    fn strays<'a>(
        &'a self,
        usual: (&'a Edge, &'a Course),
    ) -> impl Iterator<Item = (&'a Edge, &'a Course)> {
        let others = self.moving.courses();
        others.filter(move |other| self.is_stray(*other, usual))
    }

    /// The odometry that the transform from the robot's frame to the odometry's gives, the other way
    /// round; `None` where there is none, or where several say different things of the same time.
    fn way_back(
        &self,
        config: &Config,
        carriers: &BTreeSet<&str>,
        courses: &[(&Edge, &Course)],
        poses: usize,
    ) -> Option<Chosen> {
        let asked = config.input.world_frame.as_deref();
        let sounds_like_a_world = |frame: &str| {
            asked == Some(frame) || frame.contains("odom") || frame == "map" || frame == "world"
        };
        let mut ways: Vec<(&Edge, &Course)> = (courses.iter().copied())
            .filter(|((parent, child), course)| {
                course.moved && sounds_like_a_world(child) && is_robot(config, carriers, parent)
            })
            .collect();
        // The longest one, of equally long ones the first.
        ways.sort_by_key(|(_, course)| std::cmp::Reverse(course.track.len()));
        let (edge, course) = *ways.first()?;
        if course.track.len() <= poses {
            return None;
        }
        let strays = self.strays((edge, course));
        let strays = strays.map(|(edge, course)| Claim::turned(edge, course));
        let rivals = ways.iter().skip(1);
        let rivals = rivals.map(|(edge, course)| Claim::turned(edge, course));
        let claim = Claim::turned(edge, course);
        let joined = renamed::joined(claim, strays, rivals, self.first_reading());
        if joined.contradicted {
            return None;
        }
        let mut chosen = joined.choose(course.topic.clone())?;
        chosen.notes.insert(0, taken_back(edge, course, poses));
        Some(chosen)
    }

    /// Whether it is a part of the robot, or the way back: what the frame of the sonars moves, or what
    /// hangs on that. Never what moves that frame itself: only a damaged message says so.
    fn is_below(
        &self,
        config: &Config,
        carriers: &BTreeSet<&str>,
        edge: &Edge,
        course: &Course,
    ) -> bool {
        config.input.robot_frame.is_none()
            && course.moved
            && !carriers.contains(edge.1.as_str())
            && (carriers.iter()).any(|carrier| self.transforms.is_below(&edge.0, carrier))
    }

    /// The frames that carry sonars, as far as transforms say.
    fn carriers(&self) -> BTreeSet<&str> {
        let of_ranges = self.sources.iter().map(|source| source.key.frame.as_str());
        let of_clouds = self
            .hits
            .iter()
            .map(|(_, _, cloud)| cloud.frame_id.as_str());
        let frames: BTreeSet<&str> = of_ranges.chain(of_clouds).collect();
        frames
            .into_iter()
            .filter_map(|frame| self.transforms.carrier(frame, ""))
            .collect()
    }

    fn first_reading(&self) -> Option<i64> {
        self.readings.iter().map(|reading| reading.stamp_ns).min()
    }
}

/// Whether one transform may go on with what another one said of the robot: of its frame in another
/// one, or of a frame in the same one that is called as a robot's.
fn may_be_the_same((parent, child): &Edge, other: &Edge) -> bool {
    other.1 == *child || (other.0 == *parent && other.1.contains("base"))
}

/// Whether a frame is the robot's by what is asked for, or by what it carries or else is called.
fn is_robot(config: &Config, carriers: &BTreeSet<&str>, frame: &str) -> bool {
    match &config.input.robot_frame {
        Some(robot_frame) => robot_frame == frame,
        None if carriers.is_empty() => frame.starts_with("base"),
        None => carriers.contains(frame),
    }
}

/// The frames that may be the robot's: the one asked for; or those among the candidates' that carry
/// sonars; or those that sound like it; or all.
fn robots<'a>(
    config: &'a Config,
    carriers: &BTreeSet<&'a str>,
    candidates: &[(&'a Edge, &'a Course)],
) -> BTreeSet<&'a str> {
    let children: BTreeSet<&str> = candidates
        .iter()
        .map(|((_, child), _)| child.as_str())
        .collect();
    if let Some(frame) = &config.input.robot_frame {
        return BTreeSet::from([frame.as_str()]);
    }
    let carrying: BTreeSet<&str> = carriers.intersection(&children).copied().collect();
    let base = children.iter().filter(|child| child.starts_with("base"));
    let like_base: BTreeSet<&str> = base.copied().collect();
    match (carrying.is_empty(), like_base.is_empty()) {
        (false, _) => carrying,
        (true, false) => like_base,
        (true, true) => children,
    }
}

fn why(poses: usize) -> &'static str {
    if poses == 0 {
        "the log has no odometry"
    } else {
        "the log has no odometry and few poses"
    }
}

fn taken((parent, child): &Edge, course: &Course, poses: usize) -> String {
    format!(
        "{}; the transforms from `{parent}` to `{child}` on {} are taken for it",
        why(poses),
        course.topic
    )
}

fn taken_back((robot, world): &Edge, course: &Course, poses: usize) -> String {
    format!(
        "{}; the transforms on {} that give `{world}` in `{robot}` are taken for it, the other way round",
        why(poses),
        course.topic
    )
}

#[cfg(test)]
mod tests;
