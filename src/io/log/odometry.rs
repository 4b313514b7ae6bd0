//! What one topic says of where the robot was.

use super::message::{Role, TransformMessage};
use super::stamps::Clock;
use crate::core::event::OdometrySample;
use crate::core::geometry::Pose2;
use crate::core::wording::few;
use nalgebra::Isometry3;

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
}

#[derive(Debug, Clone)]
struct Named {
    world_frame: String,
    robot_frame: String,
    samples: Vec<OdometrySample>,
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
    pub messages: u64,
    pub unstamped: u64,
    pub unusable: u64,
    pub clock: Clock,
    /// What else says where the robot was and is not used.
    pub losses: Vec<String>,
    /// That it names several frames and all are used, or what it was taken from.
    pub notes: Vec<String>,
}

impl Odometry {
    /// A topic of which no message was taken yet.
    pub fn new(role: Role) -> Self {
        Self {
            role,
            poses: Vec::new(),
            messages: 0,
            unstamped: 0,
            unusable: 0,
            clock: Clock::default(),
        }
    }

    /// Takes what a message says, recorded at `logged_ns`, of one frame in another.
    pub fn take(&mut self, logged_ns: i64, pose: &TransformMessage) {
        self.messages += 1;
        self.clock.take(pose.stamp_ns, logged_ns);
        self.unstamped += u64::from(pose.stamp_ns == 0);
        let is_same = |n: &Named| n.world_frame == pose.parent && n.robot_frame == pose.child;
        let place = self.poses.iter().position(is_same);
        let Some(sample) = (pose.parent_from_child.as_ref())
            .filter(|_| place.is_some() || self.poses.len() < MOST_NAMES)
            .map(|place| in_plane(stamp(pose.stamp_ns, logged_ns), place))
        else {
            self.unusable += 1;
            return;
        };
        match place.and_then(|place| self.poses.get_mut(place)) {
            Some(known) => known.samples.push(sample),
            None => self.poses.push(Named {
                world_frame: pose.parent.clone(),
                robot_frame: pose.child.clone(),
                samples: vec![sample],
            }),
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
    /// other names.
    pub fn choose(self, topic: String) -> Option<Chosen> {
        let mut poses = self.poses;
        // Of equally many the first.
        let most = (0..poses.len())
            .rev()
            .max_by_key(|i| poses.get(*i).map(|n| n.samples.len()))?;
        let mut named = poses.remove(most);
        let names = |n: &Named| format!("`{}` in `{}`", n.robot_frame, n.world_frame);
        let others: Vec<String> = poses.iter().map(names).collect();
        let note = (!others.is_empty()).then(|| {
            format!(
                "messages on {topic} give the pose of {} and of {}; all are taken for one track",
                names(&named),
                few(&others)
            )
        });
        for other in poses {
            named.samples.extend(other.samples);
        }
        Some(Chosen {
            losses: Vec::new(),
            notes: note.into_iter().collect(),
            topic,
            role: self.role,
            world_frame: named.world_frame,
            robot_frame: named.robot_frame,
            samples: named.samples,
            messages: self.messages,
            unstamped: self.unstamped,
            unusable: self.unusable,
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
