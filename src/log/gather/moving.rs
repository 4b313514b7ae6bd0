//! Where the robot was by the transforms that move, for a log without odometry messages.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Isometry3;

use super::Gatherer;
use super::track::{Chosen, Odometry};
use crate::config::Config;
use crate::config::file::glob_set;
use crate::event::OdometrySample;
use crate::log::LogError;
use crate::log::messages::{Role, TransformMessage};

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
type Edge = (String, String);

#[derive(Debug, Clone)]
struct Course {
    topic: String,
    track: Odometry,
    first: Isometry3<f64>,
    moved: bool,
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

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

fn sounds_like_a_robot((parent, child): &Edge) -> bool {
    child.contains("base") || parent.contains("odom")
}

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
        let asked = &config.input.odometry_topics;
        let topics = glob_set(asked)?;
        let carriers = self.carriers();
        // What the frame of the sonars moves, or what hangs on it, is a part of the robot or the way back.
        let is_below = |(edge, course): (&Edge, &Course)| {
            config.input.robot_frame.is_none()
                && course.moved
                && carriers
                    .iter()
                    .any(|carrier| self.transforms.is_below(&edge.0, carrier))
        };
        let is_candidate = |(edge, course): &(&Edge, &Course)| {
            (asked.is_empty() || topics.is_match(&course.topic))
                && (course.moved || sounds_like_a_robot(edge))
                && course.track.len() > 1
                && !is_below((edge, course))
        };
        let candidates: Vec<(&Edge, &Course)> =
            self.moving.edges.iter().filter(is_candidate).collect();
        let poses = self.tracks.values().map(Odometry::len).max().unwrap_or(0);
        let others = self
            .tracks
            .values()
            .any(|track| track.role == Role::Odometry);
        if candidates.is_empty() || others {
            return Ok(None);
        }
        let children = self.robots(config, &candidates);
        let of_robot = candidates
            .iter()
            .filter(|((_, child), _)| children.contains(child.as_str()));
        match (
            children.len(),
            of_robot.max_by_key(|(_, course)| course.track.len()),
        ) {
            (1, Some(((parent, child), course))) if course.track.len() > poses => {
                let mut chosen = course.track.clone().choose(course.topic.clone());
                if let Some(chosen) = &mut chosen {
                    chosen.note = Some(format!(
                        "{}; the transforms from `{parent}` to `{child}` on {} are taken for it",
                        if poses == 0 {
                            "the log has no odometry"
                        } else {
                            "the log has no odometry and few poses"
                        },
                        course.topic
                    ));
                }
                Ok(chosen)
            }
            (1, None) if poses == 0 && config.input.robot_frame.is_some() => {
                Err(LogError::NoSuchFrame {
                    file: file.to_owned(),
                    frame: config.input.robot_frame.clone().unwrap_or_default(),
                    moving: candidates.iter().map(|(edge, _)| (*edge).clone()).collect(),
                })
            }
            (1, _) => Ok(None),
            _ if poses > 0 => Ok(None),
            _ => Err(LogError::UnclearTransforms {
                file: file.to_owned(),
                moving: candidates.iter().map(|(edge, _)| (*edge).clone()).collect(),
            }),
        }
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

    /// The frames that may be the robot's: the one asked for; or those among the candidates' that carry
    /// sonars; or those that sound like it; or all.
    fn robots<'a>(
        &'a self,
        config: &'a Config,
        candidates: &[(&'a Edge, &Course)],
    ) -> BTreeSet<&'a str> {
        let children: BTreeSet<&str> = candidates
            .iter()
            .map(|((_, child), _)| child.as_str())
            .collect();
        if let Some(frame) = &config.input.robot_frame {
            return BTreeSet::from([frame.as_str()]);
        }
        let mut carriers = self.carriers();
        carriers.retain(|carrier| children.contains(carrier));
        let like_base = || -> BTreeSet<&str> {
            let base = children.iter().filter(|child| child.starts_with("base"));
            base.copied().collect()
        };
        match (carriers.is_empty(), like_base()) {
            (false, _) => carriers,
            (true, base) if !base.is_empty() => base,
            _ => children,
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;
    use crate::log::messages::{Content, RangeMessage};

    /// A log with a sonar on `base_link` and these transforms between frames, which all move.
    fn log(edges: &[(&str, &str)]) -> Gatherer {
        let mut gatherer = Gatherer::default();
        let transform = |parent: &str, child: &str, x: f64| TransformMessage {
            stamp_ns: 1,
            parent: parent.to_owned(),
            child: child.to_owned(),
            parent_from_child: Some(Isometry3::from_parts(
                Translation3::new(x, 0.0, 0.0),
                UnitQuaternion::identity(),
            )),
        };
        let fixed = vec![transform("base_link", "sonar", 0.1)];
        gatherer.take(Role::Transform, "/tf_static", 0, Content::Transforms(fixed));
        for step in 0..10 {
            for (parent, child) in edges {
                let moved = vec![transform(parent, child, f64::from(step))];
                gatherer.take(Role::Transform, "/tf", 1, Content::Transforms(moved));
            }
        }
        let range = RangeMessage::plain(1, "sonar", 1.0);
        gatherer.take(Role::Range, "/sonar", 1, Content::Ranges(vec![range]));
        gatherer
    }

    fn chosen(edges: &[(&str, &str)], config: &Config) -> Result<Option<String>, LogError> {
        let chosen = log(edges).by_transforms(config, "log");
        chosen.map(|chosen| chosen.map(|c| format!("{} in {}", c.robot_frame, c.world_frame)))
    }

    #[test]
    fn what_the_robot_carries_and_the_way_back_are_no_odometry() {
        let config = Config::default();
        let of = |edges: &[(&str, &str)]| chosen(edges, &config).unwrap();
        assert_eq!(of(&[("odom", "base_link")]).unwrap(), "base_link in odom");
        assert_eq!(of(&[("base_link", "head")]), None);
        assert_eq!(of(&[("base_link", "odom")]), None);
        assert_eq!(of(&[("base_link", "left"), ("base_link", "right")]), None);
        assert_eq!(of(&[("base_link", "arm"), ("arm", "hand")]), None);
        let all = [
            ("map", "odom"),
            ("odom", "base_link"),
            ("base_link", "head"),
        ];
        assert_eq!(of(&all).unwrap(), "base_link in odom");
    }

    #[test]
    fn a_robots_frame_that_nothing_moves_is_refused() {
        let mut config = Config::default();
        config.input.robot_frame = Some("nope".to_owned());
        let error = chosen(&[("odom", "base_link")], &config).unwrap_err();
        let said = error.to_string();
        assert!(said.contains("no transform moves `nope`"), "{said}");
        assert!(said.contains("`base_link` in `odom`"), "{said}");
    }
}
