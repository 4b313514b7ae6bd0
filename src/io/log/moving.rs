//! Where the robot was by the transforms that move, for a log without odometry messages.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Isometry3;

use super::error::LogError;
use super::message::{Role, TransformMessage};
use super::odometry::{Chosen, Odometry};
use super::transforms::TransformTree;
use crate::core::config::Config;
use crate::core::pattern::glob_set;
use crate::core::wording::{counted, seconds_between};

/// More samples than this are held only of frames that sound like a robot's.
const MOST_SAMPLES: usize = 1_000_000;
/// More pairs of frames than this are passed over.
const MOST_EDGES: usize = 256;
/// Two tracks are at the same time where they are no farther apart, nanoseconds.
const SOON: i64 = 1_000_000_000;

/// The transforms that are no fixed ones.
#[derive(Debug, Clone, Default)]
pub struct Moving {
    edges: BTreeMap<Edge, Course>,
    samples: usize,
    /// Transforms of the robot's kind that there was no room for.
    unheld: u64,
    /// More was said than is held.
    overfull: bool,
}

/// Parent and child.
pub type Edge = (String, String);

/// How a child moved in its parent.
#[derive(Debug, Clone)]
struct Course {
    /// Of its first transform.
    topic: String,
    track: Odometry,
    first: Option<Isometry3<f64>>,
    /// Whether it ever did.
    moved: bool,
}

/// What decides which transform is the robot's.
#[derive(Debug)]
pub struct Circumstances<'a> {
    pub file: &'a str,
    pub config: &'a Config,
    pub transforms: &'a TransformTree,
    /// The frames that carry sonars, as far as transforms say.
    pub carriers: BTreeSet<&'a str>,
    /// The most that messages of another kind say on one topic.
    pub poses: usize,
    /// Of the first reading.
    pub start_ns: Option<i64>,
}

type One<'a> = (&'a Edge, &'a Course);

impl Moving {
    /// Takes a transform.
    pub fn take(&mut self, topic: &str, logged_ns: i64, transform: &TransformMessage) {
        if self.samples == MOST_SAMPLES && !self.overfull {
            self.overfull = true;
            self.edges.retain(|edge, _| sounds_like_a_robot(edge));
            self.samples = self.edges.values().map(|course| course.track.len()).sum();
        }
        let edge = (transform.parent.clone(), transform.child.clone());
        let is_known = self.edges.contains_key(&edge);
        let is_robot = sounds_like_a_robot(&edge);
        if self.samples >= MOST_SAMPLES
            || (self.overfull && !is_robot)
            || (!is_known && self.edges.len() == MOST_EDGES)
        {
            self.unheld += u64::from(is_robot);
            return;
        }
        let course = self.edges.entry(edge).or_insert_with(|| Course {
            topic: topic.to_owned(),
            track: Odometry::new(Role::Transform),
            first: None,
            moved: false,
        });
        if let Some(pose) = &transform.parent_from_child {
            let change = course.first.get_or_insert(*pose).inv_mul(pose);
            course.moved |=
                change.translation.vector.norm() > 1e-3 || change.rotation.imag().norm() > 1e-3;
        }
        course.track.take(logged_ns, transform);
        self.samples += 1;
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// The transform that moves the robot, where no message of another kind says as often where it is.
    ///
    /// # Errors
    /// Where it cannot be told which transform that is, and nothing else says where the robot was.
    pub fn odometry(&self, of: &Circumstances<'_>) -> Result<Option<Chosen>, LogError> {
        let (config, file) = (of.config, || of.file.to_owned());
        let courses = self.asked_for(config)?;
        let is_candidate = |(edge, course): &One<'_>| {
            (course.moved || sounds_like_a_robot(edge)) && !of.is_below(edge, course)
        };
        let candidates: Vec<One<'_>> = courses.iter().copied().filter(is_candidate).collect();
        let children = of.robots(&candidates);
        let of_robot = (candidates.iter().copied())
            .filter(|((_, child), _)| children.contains(child.as_str()))
            .max_by_key(|(_, course)| course.track.len())
            .filter(|_| children.len() == 1);
        // A transform to the odometry's frame, from the robot's: better than a frame of which nothing
        // says that it is the robot's.
        if !of_robot.is_some_and(|(edge, _)| of.is_robot(&edge.1))
            && let Some(back) = self.way_back(of, &courses)
        {
            return Ok(Some(back));
        }
        let moving = || candidates.iter().map(|(edge, _)| (*edge).clone()).collect();
        let no_such_frame = |frame: &String, key, moving| LogError::NoSuchFrame {
            file: file(),
            frame: frame.clone(),
            key,
            moving,
        };
        match of_robot {
            Some((edge, course)) if course.track.len() > of.poses => {
                let may_be_the_same = |other: &Edge| {
                    other.1 == edge.1 || (other.0 == edge.0 && other.1.contains("base"))
                };
                let rivals = courses.iter().filter(|(other, course)| {
                    *other != edge && course.moved && may_be_the_same(other)
                });
                let (parent, child) = edge;
                let note = format!(
                    "{}; the transforms from `{parent}` to `{child}` on {} are taken for it",
                    of.why(),
                    course.topic
                );
                Ok(self.chosen(
                    of,
                    (edge, course),
                    note,
                    rivals.map(|rival| (rival.0.1.as_str(), *rival)),
                ))
            }
            _ if of.poses > 0 => Ok(None),
            Some(_) => Ok(None),
            None if candidates.is_empty() => match &config.input.world_frame {
                Some(frame) if !self.edges.is_empty() => {
                    let moved = self.edges.iter().filter(|(_, course)| course.moved);
                    let moving = moved.map(|(edge, _)| edge.clone()).collect();
                    Err(no_such_frame(frame, "input.world_frame", moving))
                }
                _ => Ok(None),
            },
            None => Err(match &config.input.robot_frame {
                Some(frame) => no_such_frame(frame, "input.robot_frame", moving()),
                None => LogError::UnclearTransforms {
                    file: file(),
                    moving: moving(),
                },
            }),
        }
    }

    /// The transforms that move and are not looked at: what the robot carries.
    pub fn passed_over(&self, of: &Circumstances<'_>) -> Vec<Edge> {
        let courses = self.asked_for(of.config).unwrap_or_default();
        let carried = courses
            .into_iter()
            .filter(|(edge, course)| of.is_below(edge, course));
        carried.map(|(edge, _)| edge.clone()).collect()
    }

    /// The transforms on the topics and in the frame that are asked for.
    fn asked_for(&self, config: &Config) -> Result<Vec<One<'_>>, LogError> {
        let asked = &config.input.odometry_topics;
        let topics = glob_set(asked)?;
        let is_asked = |(edge, course): &One<'_>| {
            let world = config.input.world_frame.as_ref();
            course.track.len() > 1
                && (asked.is_empty() || topics.is_match(&course.topic))
                && world.is_none_or(|world| edge.0 == *world || edge.1 == *world)
        };
        Ok(self.edges.iter().filter(is_asked).collect())
    }

    /// The odometry that the transform from the robot's frame to the odometry's gives, the other way
    /// round; `None` where there is none, or where several say different things of the same time.
    fn way_back(&self, of: &Circumstances<'_>, courses: &[One<'_>]) -> Option<Chosen> {
        let asked = of.config.input.world_frame.as_deref();
        let sounds_like_a_world = |frame: &str| {
            asked == Some(frame) || frame.contains("odom") || frame == "map" || frame == "world"
        };
        let mut ways: Vec<One<'_>> = (courses.iter().copied())
            .filter(|((parent, child), course)| {
                course.moved && sounds_like_a_world(child) && of.is_robot(parent)
            })
            .collect();
        // The longest one, of equally long ones the first.
        ways.sort_by_key(|(_, course)| std::cmp::Reverse(course.track.len()));
        let (way, others) = ways.split_first()?;
        let stamps = way.1.track.stamps();
        let contradicts = |(_, other): &One<'_>| Meeting::of(&stamps, &other.track).is_doubled();
        if way.1.track.len() <= of.poses || others.iter().any(contradicts) {
            return None;
        }
        let (robot, world) = way.0;
        let note = format!(
            "{}; the transforms on {} that give `{world}` in `{robot}` are taken for it, the other way round",
            of.why(),
            way.1.topic
        );
        let turned = |course: &Course| Course {
            track: course.track.clone().turned_round(),
            ..course.clone()
        };
        let edge = (world.clone(), robot.clone());
        let others = others.iter().map(|other| (other.0.0.as_str(), *other));
        self.chosen(of, (&edge, &turned(way.1)), note, others)
    }

    /// A transform's track, with what is told of others that say where the robot was: each with the name
    /// that it has for the robot's frame.
    fn chosen<'a>(
        &self,
        of: &Circumstances<'_>,
        (edge, course): One<'_>,
        note: String,
        rivals: impl Iterator<Item = (&'a str, One<'a>)>,
    ) -> Option<Chosen> {
        let stamps = course.track.stamps();
        let start_ns = of.start_ns.or(stamps.first().copied()).unwrap_or_default();
        let told = |robot: &str, world: &str, stamps: &[i64]| {
            let at = |end: Option<&i64>| seconds_between(start_ns, *end.unwrap_or(&start_ns), 1);
            format!(
                "`{robot}` in `{world}` by {} from {} s to {} s",
                counted(stamps.len() as u64, "transform"),
                at(stamps.first()),
                at(stamps.last())
            )
        };
        let taken = told(&edge.1, &edge.0, &stamps);
        let mut chosen = course.track.clone().choose(course.topic.clone())?;
        chosen.messages = 0; // those that carried the transforms are counted with these
        chosen.notes.insert(0, note);
        for (robot, (rival, course)) in rivals {
            let world = if rival.1 == robot { &rival.0 } else { &rival.1 };
            let meeting = Meeting::of(&stamps, &course.track);
            if robot != edge.1 && meeting.is_doubled() {
                continue; // another robot, or a part of this one
            }
            let left = told(robot, world, &course.track.stamps());
            let text = format!(
                "the robot moves as {taken}, which are used, and as {left}, which are left out, {} of them at \
                 times that the former lack; `input.world_frame = {}` takes the latter instead",
                meeting.alone,
                toml::Value::from(world.as_str())
            );
            if meeting.alone > 0 {
                chosen.losses.push(text);
            } else {
                chosen.notes.push(text);
            }
        }
        if self.unheld > 0 {
            chosen.losses.push(format!(
                "{} on {} left out: there are too many to be held",
                counted(self.unheld, "transform"),
                course.topic
            ));
        }
        Some(chosen)
    }
}

impl Circumstances<'_> {
    /// Whether it is a part of the robot, or the way back: what the frame of the sonars moves, or what
    /// hangs on that. Never what moves that frame itself.
    fn is_below(&self, edge: &Edge, course: &Course) -> bool {
        let mut carriers = self.carriers.iter();
        self.config.input.robot_frame.is_none()
            && course.moved
            && !self.carriers.contains(edge.1.as_str())
            && carriers.any(|carrier| self.transforms.is_below(&edge.0, carrier))
    }

    /// Whether a frame is the robot's by what is asked for, or by what it carries or else is called.
    fn is_robot(&self, frame: &str) -> bool {
        match &self.config.input.robot_frame {
            Some(robot_frame) => robot_frame == frame,
            None if self.carriers.is_empty() => frame.starts_with("base"),
            None => self.carriers.contains(frame),
        }
    }

    /// The frames that may be the robot's: the one asked for; or those among the candidates' that carry
    /// sonars; or those that sound like it; or all.
    fn robots<'a>(&'a self, candidates: &[One<'a>]) -> BTreeSet<&'a str> {
        let children = candidates.iter().map(|((_, child), _)| child.as_str());
        let children: BTreeSet<&str> = children.collect();
        if let Some(frame) = &self.config.input.robot_frame {
            return BTreeSet::from([frame.as_str()]);
        }
        let carrying: BTreeSet<&str> = self.carriers.intersection(&children).copied().collect();
        let base = children.iter().filter(|child| child.starts_with("base"));
        let like_base: BTreeSet<&str> = base.copied().collect();
        match (carrying.is_empty(), like_base.is_empty()) {
            (false, _) => carrying,
            (true, false) => like_base,
            (true, true) => children,
        }
    }

    fn why(&self) -> &'static str {
        match self.poses {
            0 => "the log has no odometry",
            _ => "the log has no odometry and few poses",
        }
    }
}

/// Whether a frame and its parent have names as a robot's and its odometry's.
fn sounds_like_a_robot((parent, child): &Edge) -> bool {
    child.contains("base") || parent.contains("odom")
}

/// How one track meets another one.
struct Meeting {
    /// Samples of the other one at times of which the first one says nothing, and all others.
    alone: usize,
    together: usize,
}

impl Meeting {
    /// Of the stamps of a track, in order, and another track.
    fn of(known: &[i64], rival: &Odometry) -> Self {
        let stamps = rival.stamps();
        let is_alone = |stamp: &&i64| {
            let next = known.partition_point(|other| other < *stamp);
            let neighbours = [
                next.checked_sub(1).and_then(|n| known.get(n)),
                known.get(next),
            ];
            let mut neighbours = neighbours.into_iter().flatten();
            !neighbours.any(|other| other.saturating_sub(**stamp).saturating_abs() <= SOON)
        };
        let alone = stamps.iter().filter(is_alone).count();
        Self {
            alone,
            together: stamps.len() - alone,
        }
    }

    /// Whether both say where the robot was at the same time, mostly.
    fn is_doubled(&self) -> bool {
        self.together >= self.alone
    }
}

#[cfg(test)]
mod tests;
