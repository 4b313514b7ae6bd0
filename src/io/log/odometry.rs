//! Where the robot was: by the poses of one topic, or by the transforms that move, for a log without odometry
//! messages.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Isometry3;

use super::error::LogError;
use super::message::{Role, TransformMessage};
use super::stamps::Clock;
use super::traits::{PoseTraits, integrated};
use super::transforms::TransformTree;
use crate::core::config::Config;
use crate::core::event::OdometrySample;
use crate::core::geometry::Pose2;
use crate::core::pattern::glob_set;
use crate::core::wording::{counted, few, seconds_between};

/// No more poses than this are odd, and only among more than ten times as many.
const FEW: usize = 3;

/// More names of frames on one topic than this are damage in any case.
const MOST_NAMES: usize = 64;

/// What one topic says of where the robot was.
#[derive(Debug, Clone)]
pub struct Odometry {
    pub role: Role,
    /// Poses by the frames that their messages name, in the order of their first messages.
    poses: Vec<Named>,
    pub messages: u64,
    pub unstamped: u64,
    /// Messages without a pose, or with one that is not held.
    pub unusable: u64,
    pub clock: Clock,
    /// Whether the path is made of the speeds.
    from_speeds: bool,
}

#[derive(Debug, Clone)]
struct Named {
    world_frame: String,
    robot_frame: String,
    /// Whether their quaternions are zero.
    are_unturned: bool,
    samples: Vec<OdometrySample>,
    /// The speeds that come with the samples: as long as the poses of these are all the same, or as the path is made
    /// of them.
    twists: Vec<[f64; 3]>,
    traits: PoseTraits,
}

/// Where the robot was, by the one topic that is used.
#[derive(Debug, Clone)]
pub struct Chosen {
    pub topic: String,
    pub role: Role,
    pub world_frame: String,
    pub robot_frame: String,
    /// In file order.
    pub samples: Vec<OdometrySample>,
    pub traits: PoseTraits,
    pub messages: u64,
    pub unstamped: u64,
    pub unusable: u64,
    pub clock: Clock,
    /// What else says where the robot was and is not used.
    pub losses: Vec<String>,
    /// That it names several frames and all are used, or what it was taken from.
    pub notes: Vec<String>,
}

impl Named {
    fn take(&mut self, message: &TransformMessage<'_>, sample: OdometrySample, from_speeds: bool) {
        self.traits.take(message, sample);
        let first = self.samples.first().unwrap_or(&sample);
        let is_first = first.world_from_robot == sample.world_from_robot;
        match message.twist {
            Some(twist) if (from_speeds || is_first) && self.twists.len() == self.samples.len() => {
                self.twists.push(twist);
            }
            _ => self.twists = Vec::new(),
        }
        self.samples.push(sample);
    }

    /// Makes the poses of the speeds, where the poses stay the same and the speeds say that the robot moves
    /// (introlab/rtabmap_ros#1059); whether that was so.
    fn integrate(&mut self) -> bool {
        let moves = |twist: &[f64; 3]| twist.iter().any(|speed| *speed != 0.0);
        if self.twists.len() != self.samples.len() || !self.twists.iter().any(moves) {
            return false;
        }
        let twists = std::mem::take(&mut self.twists);
        let mut all: Vec<_> = self.samples.drain(..).zip(twists).collect();
        all.sort_by_key(|(sample, _)| sample.stamp_ns);
        if let Some((first, _)) = all.first() {
            integrated(first.world_from_robot, &mut all);
        }
        self.samples = all.into_iter().map(|(sample, _)| sample).collect();
        self.traits.are_of_twist = true;
        true
    }

    /// Whether it has samples while another has.
    fn is_beside(&self, other: &Self) -> bool {
        let span = |named: &Self| {
            let stamps = || named.samples.iter().map(|sample| sample.stamp_ns);
            Some((stamps().min()?, stamps().max()?))
        };
        let (Some((from, to)), Some((first, last))) = (span(self), span(other)) else {
            return false;
        };
        let within = |sample: &&OdometrySample| (first..=last).contains(&sample.stamp_ns);
        let inside = self.samples.iter().filter(within).count();
        from <= last && first <= to && 2 * inside > self.samples.len()
    }
}

impl Odometry {
    /// A topic of which no message was taken yet.
    pub fn new(role: Role, from_speeds: bool) -> Self {
        Self {
            role,
            poses: Vec::new(),
            messages: 0,
            unstamped: 0,
            unusable: 0,
            clock: Clock::default(),
            from_speeds,
        }
    }

    /// Takes what a message says, recorded at `logged_ns`, of one frame in another.
    pub fn take(&mut self, logged_ns: i64, pose: &TransformMessage<'_>) {
        self.messages += 1;
        self.clock.take(pose.stamp_ns, logged_ns);
        self.unstamped += u64::from(pose.stamp_ns == 0);
        // A frame that moves in itself is a slip of the driver (dawonn/vectornav#55), and names nothing.
        let child = match pose.child == pose.parent {
            true => "",
            false => &*pose.child,
        };
        let are_unturned = pose.is_unturned();
        let is_same = |n: &Named| {
            n.world_frame == pose.parent && n.robot_frame == child && n.are_unturned == are_unturned
        };
        let place = self.poses.iter().position(is_same);
        let Some(sample) = (pose.parent_from_child.as_ref())
            .filter(|_| place.is_some() || self.poses.len() < MOST_NAMES)
            .map(|place| in_plane(stamp(pose.stamp_ns, logged_ns), place))
        else {
            self.unusable += 1;
            return;
        };
        let place = place.unwrap_or(self.poses.len());
        if place == self.poses.len() {
            self.poses.push(Named {
                world_frame: pose.parent.to_string(),
                robot_frame: child.to_owned(),
                are_unturned,
                samples: Vec::new(),
                twists: Vec::new(),
                traits: PoseTraits::default(),
            });
        }
        if let Some(named) = self.poses.get_mut(place) {
            named.take(pose, sample, self.from_speeds);
        }
    }

    /// The robot's frame taken for the world's and the world's for the robot's.
    pub fn turned_round(mut self) -> Self {
        for named in &mut self.poses {
            std::mem::swap(&mut named.world_frame, &mut named.robot_frame);
            for sample in &mut named.samples {
                sample.world_from_robot = sample.world_from_robot.inverse();
            }
        }
        self
    }

    /// The stamps of its samples, in order.
    pub fn stamps(&self) -> Vec<i64> {
        let all = self.poses.iter().flat_map(|named| &named.samples);
        let mut stamps: Vec<i64> = all.map(|sample| sample.stamp_ns).collect();
        stamps.sort_unstable();
        stamps
    }

    /// Only the poses in a frame.
    pub fn keep_world(&mut self, world_frame: &str) {
        self.poses.retain(|named| named.world_frame == world_frame);
    }

    /// The frames that it gives poses of, with those that they are in.
    pub fn edges(&self) -> Vec<(String, String)> {
        let edge = |named: &Named| (named.world_frame.clone(), named.robot_frame.clone());
        self.poses.iter().map(edge).collect()
    }

    /// Poses that it has.
    pub fn len(&self) -> usize {
        self.poses.iter().map(|named| named.samples.len()).sum()
    }

    /// All of it under the frames that most of its messages name: a node may have been started again with
    /// other names. Where only a few messages do, they are lost.
    pub fn choose(self, topic: String) -> Option<Chosen> {
        let (unturned, turned): (Vec<_>, Vec<_>) =
            self.poses.into_iter().partition(|named| named.are_unturned);
        let count = |poses: &[Named]| poses.iter().map(|n| n.samples.len() as u64).sum::<u64>();
        let were_unturned = count(&unturned);
        // Where all are, it is the driver's way to say nothing, and where the robot was is all there is to go by.
        let (mut poses, unusable) = match turned.is_empty() {
            true => (unturned, 0),
            false => (turned, were_unturned),
        };
        // Of equally many the first.
        let most = (0..poses.len())
            .rev()
            .max_by_key(|i| poses.get(*i).map(|n| n.samples.len()))?;
        let mut named = poses.remove(most);
        let names = |n: &Named| format!("`{}` in `{}`", n.robot_frame, n.world_frame);
        let usual = named.samples.len();
        let is_odd = |n: &Named| n.samples.len() <= FEW && 10 * n.samples.len() < usual;
        let (odd, others): (Vec<_>, Vec<_>) = poses.into_iter().partition(is_odd);
        let losses = odd.iter().map(|odd| {
            format!(
                "{} on {topic} of {}, unlike all others, left out",
                counted(odd.samples.len() as u64, "pose"),
                names(odd)
            )
        });
        let losses = losses.collect();
        // Two publishers on one topic (introlab/rtabmap_ros#760); a node that was started again with other names
        // goes on where it ended.
        let (beside, others): (Vec<_>, Vec<_>) = others
            .into_iter()
            .partition(|other| other.is_beside(&named));
        let beside = beside.iter().map(|other| {
            format!(
                "messages on {topic} give the pose of {} and at the same times of {}: two tracks of two publishers; \
                 the former is used, and `input.world_frame = {}` takes the latter",
                names(&named),
                names(other),
                toml::Value::from(other.world_frame.as_str())
            )
        });
        let mut notes: Vec<String> = beside.collect();
        if named.are_unturned {
            notes.push(format!(
                "the quaternions of {} on {topic} are zero; all are taken for poses that are not turned",
                counted(were_unturned, "pose")
            ));
        }
        let all: Vec<String> = others.iter().map(names).collect();
        let note = (!all.is_empty()).then(|| {
            format!(
                "messages on {topic} give the pose of {} and of {}; all are taken for one track",
                names(&named),
                few(&all)
            )
        });
        notes.extend(note);
        if others.is_empty() && named.integrate() {
            let asked = format!(
                "the path is made of the speeds on {topic}, as input.odometry_from_speeds has it"
            );
            notes.push(if self.from_speeds { asked } else { format!(
                "the poses on {topic} stay what they are while the speeds in the same messages say that the robot \
                 moves; the path is made of the speeds"
            ) });
        }
        named
            .samples
            .extend(others.into_iter().flat_map(|n| n.samples));
        Some(Chosen {
            losses,
            notes,
            traits: named.traits,
            topic,
            role: self.role,
            world_frame: named.world_frame,
            robot_frame: named.robot_frame,
            samples: named.samples,
            messages: self.messages,
            unstamped: self.unstamped,
            unusable: self.unusable + unusable,
            clock: self.clock,
        })
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
pub fn stamp(stamp_ns: i64, logged_ns: i64) -> i64 {
    if stamp_ns == 0 { logged_ns } else { stamp_ns }
}

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
    pub fn take(&mut self, topic: &str, logged_ns: i64, transform: &TransformMessage<'_>) {
        if self.samples == MOST_SAMPLES && !self.overfull {
            self.overfull = true;
            self.edges.retain(|edge, _| sounds_like_a_robot(edge));
            self.samples = self.edges.values().map(|course| course.track.len()).sum();
        }
        let edge = (transform.parent.to_string(), transform.child.to_string());
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
            track: Odometry::new(Role::Transform, false),
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

    /// Takes what is not known yet.
    pub fn join(&mut self, other: Self) {
        for (edge, course) in other.edges {
            if self.edges.len() < MOST_EDGES && !self.edges.contains_key(&edge) {
                self.samples += course.track.len();
                self.edges.insert(edge, course);
            }
        }
        self.unheld += other.unheld;
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
        let courses = self.asked_for(of.config)?;
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
        if let Some((edge, course)) = of_robot
            && course.track.len() > of.poses
        {
            let rivals = courses
                .iter()
                .filter(|(other, course)| *other != edge && course.moved && other.1 == edge.1);
            let (parent, child) = edge;
            let note = format!(
                "{}; the transforms from `{parent}` to `{child}` on {} are taken for it",
                of.why(),
                course.topic
            );
            return Ok(self.chosen(of, (edge, course), note, rivals));
        }
        let edges = |all: &[One<'_>]| all.iter().map(|(edge, _)| (*edge).clone()).collect();
        let input = &of.config.input;
        let (asked, key, moving) = match (&input.world_frame, &input.robot_frame) {
            _ if of.poses > 0 || of_robot.is_some() || self.edges.is_empty() => return Ok(None),
            (Some(world), _) if candidates.is_empty() => {
                let moved: Vec<One<'_>> = self.edges.iter().filter(|it| it.1.moved).collect();
                (world, "input.world_frame", edges(&moved))
            }
            _ if candidates.is_empty() => return Ok(None),
            (_, Some(robot)) => (robot, "input.robot_frame", edges(&candidates)),
            (_, None) => {
                return Err(LogError::UnclearTransforms {
                    file: of.file.to_owned(),
                    moving: edges(&candidates),
                });
            }
        };
        Err(LogError::NoSuchFrame {
            file: of.file.to_owned(),
            frame: asked.clone(),
            key,
            moving,
        })
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
    /// round; `None` where there is none, or where there are several.
    fn way_back(&self, of: &Circumstances<'_>, courses: &[One<'_>]) -> Option<Chosen> {
        let asked = of.config.input.world_frame.as_deref();
        let sounds_like_a_world = |frame: &str| {
            asked == Some(frame) || frame.contains("odom") || frame == "map" || frame == "world"
        };
        let mut ways = courses.iter().filter(|((parent, child), course)| {
            course.moved && sounds_like_a_world(child) && of.is_robot(parent)
        });
        let ((robot, world), course) = ways.next()?;
        if course.track.len() <= of.poses || ways.next().is_some() {
            return None;
        }
        let note = format!(
            "{}; the transforms on {} that give `{world}` in `{robot}` are taken for it, the other way round",
            of.why(),
            course.topic
        );
        let turned = Course {
            track: course.track.clone().turned_round(),
            ..(*course).clone()
        };
        let edge = (world.clone(), robot.clone());
        self.chosen(of, (&edge, &turned), note, [].iter())
    }

    /// A transform's track, with what is told of others that say where the same frame was.
    fn chosen<'a>(
        &self,
        of: &Circumstances<'_>,
        (edge, course): One<'_>,
        note: String,
        rivals: impl Iterator<Item = &'a One<'a>>,
    ) -> Option<Chosen> {
        let stamps = course.track.stamps();
        let start_ns = of.start_ns.or(stamps.first().copied()).unwrap_or_default();
        let told = |(world, robot): &Edge, stamps: &[i64]| {
            let at = |end: Option<&i64>| seconds_between(start_ns, *end.unwrap_or(&start_ns), 1);
            format!(
                "`{robot}` in `{world}` by {} from {} s to {} s",
                counted(stamps.len() as u64, "transform"),
                at(stamps.first()),
                at(stamps.last())
            )
        };
        let mut chosen = course.track.clone().choose(course.topic.clone())?;
        chosen.messages = 0; // those that carried the transforms are counted with these
        chosen.notes.insert(0, note);
        for (rival, course) in rivals {
            let theirs = course.track.stamps();
            let alone = theirs.iter().filter(|stamp| is_alone(**stamp, &stamps));
            let alone = alone.count();
            let text = format!(
                "the robot moves as {}, which are used, and as {}, which are left out, {alone} of them at times that \
                 the former lack; `input.world_frame = {}` takes the latter instead",
                told(edge, &stamps),
                told(rival, &theirs),
                toml::Value::from(rival.0.as_str())
            );
            match alone {
                0 => chosen.notes.push(text),
                _ => chosen.losses.push(text),
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

/// Whether none of some stamps, in order, is near another one.
fn is_alone(stamp: i64, known: &[i64]) -> bool {
    let next = known.partition_point(|other| other.saturating_add(SOON) < stamp);
    known
        .get(next)
        .is_none_or(|other| other.saturating_sub(stamp) > SOON)
}

#[cfg(test)]
mod tests;
