//! The transforms that move, any of which may say where the robot was.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use super::track::Odometry;
use crate::core::event::OdometrySample;
use crate::io::log::message::{Role, TransformMessage};

/// More samples than this are held only of frames that sound like a robot's.
const MOST_SAMPLES: usize = 1_000_000;
/// More pairs of frames than this are passed over.
const MOST_EDGES: usize = 256;

/// The transforms that are no fixed ones.
#[derive(Debug, Clone, Default)]
pub struct Moving {
    edges: BTreeMap<Edge, Course>,
    samples: usize,
    /// More was said than is held.
    overfull: bool,
}

/// Parent and child.
pub type Edge = (String, String);

/// How a child moved in its parent.
#[derive(Debug, Clone)]
pub struct Course {
    /// Of its first transform.
    pub topic: String,
    pub track: Odometry,
    first: Isometry3<f64>,
    /// Whether it ever did.
    pub moved: bool,
}

impl Moving {
    /// Takes a transform, and the sample that it is where its child is the robot.
    pub fn take(
        &mut self,
        topic: &str,
        logged_ns: i64,
        transform: &TransformMessage,
        sample: impl FnOnce(&Isometry3<f64>) -> OdometrySample,
    ) {
        let Some(pose) = &transform.parent_from_child else {
            return;
        };
        if self.samples == MOST_SAMPLES && !self.overfull {
            self.overfull = true;
            self.edges.retain(|edge, _| sounds_like_a_robot(edge));
            self.samples = self.edges.values().map(|course| course.track.len()).sum();
        }
        let edge = (transform.parent.clone(), transform.child.clone());
        let is_known = self.edges.contains_key(&edge);
        if self.samples >= MOST_SAMPLES
            || (self.overfull && !sounds_like_a_robot(&edge))
            || (!is_known && self.edges.len() == MOST_EDGES)
        {
            return;
        }
        let course = self.edges.entry(edge).or_insert_with(|| Course {
            topic: topic.to_owned(),
            track: Odometry::new(Role::Transform),
            first: *pose,
            moved: false,
        });
        let change = course.first.inv_mul(pose);
        course.moved |=
            change.translation.vector.norm() > 1e-3 || change.rotation.imag().norm() > 1e-3;
        course.track.clock.take(transform.stamp_ns, logged_ns);
        course.track.unstamped += u64::from(transform.stamp_ns == 0);
        let (parent, child) = (&transform.parent, &transform.child);
        course.track.take(parent, child, sample(pose));
        self.samples += 1;
    }

    /// All of them.
    pub fn courses(&self) -> impl Iterator<Item = (&Edge, &Course)> {
        self.edges.iter()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// Whether a frame and its parent have names as a robot's and its odometry's.
pub fn sounds_like_a_robot((parent, child): &Edge) -> bool {
    child.contains("base") || parent.contains("odom")
}
