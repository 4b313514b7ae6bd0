//! Transforms by the namespaces of their topics: of several robots in one log, each has frames of the same names
//! (turtlebot/turtlebot4#131, husarion/rosbot_xl_ros#71).

use std::collections::{BTreeMap, BTreeSet};

use super::channels::ChannelReport;
use super::message::Role;
use super::odometry::Moving;
use super::transforms::TransformTree;
use crate::core::wording::few;

/// What the topics of one namespace say of frames.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    pub transforms: TransformTree,
    /// Transforms that may say where the robot was, as long as no odometry does.
    pub moving: Moving,
}

/// More namespaces than this are not told apart.
const MOST: usize = 64;

/// The frames of a log by namespace; that of `/tf` is empty.
#[derive(Debug, Clone, Default)]
pub struct Namespaces(BTreeMap<String, Frames>);

/// The frames that are used.
#[derive(Debug, Default)]
pub struct Chosen {
    pub frames: Frames,
    /// Namespaces of other robots, of which nothing is used.
    pub others: BTreeSet<String>,
    /// What a person should know.
    pub note: Option<String>,
}

impl Namespaces {
    /// Where what is said on a topic belongs.
    pub fn of(&mut self, topic: &str) -> &mut Frames {
        let namespace = topic
            .rsplit_once('/')
            .map_or("", |(namespace, _)| namespace);
        let is_full = self.0.len() >= MOST && !self.0.contains_key(namespace);
        let namespace = if is_full { "" } else { namespace };
        self.0.entry(namespace.to_owned()).or_default()
    }

    /// Odometry says where the robot was.
    pub fn forget_motion(&mut self) {
        self.0.values_mut().for_each(|frames| frames.moving.clear());
    }

    /// Names of all frames.
    pub fn frames(&self) -> Vec<&str> {
        let all = self
            .0
            .values()
            .flat_map(|frames| frames.transforms.frames());
        all.collect()
    }

    /// The frames of the robot whose odometry is used, or whose ranges are: those of its namespace, then of
    /// none, and of others what these do not say. What has odometry of its own that is not used is another
    /// robot's.
    pub fn choose(
        self,
        channels: &[ChannelReport],
        tracks: &BTreeSet<&str>,
        are_asked_for: bool,
    ) -> Chosen {
        let topics = |role: fn(Role) -> bool| {
            let channels = channels.iter();
            channels.filter(move |channel| channel.role.is_some_and(role))
        };
        let says_where = |role| matches!(role, Role::Odometry | Role::Pose);
        let has_track = |namespace: &str| tracks.iter().any(|topic| is_in(topic, namespace));
        let has_ranges = |namespace: &str| {
            topics(|role| role == Role::Range).any(|c| c.used && is_in(&c.topic, namespace))
        };
        let is_other = |namespace: &str| {
            let mut all = topics(says_where);
            all.any(|c| is_in(&c.topic, namespace) && !tracks.contains(c.topic.as_str()))
        };
        let rank = |namespace: &str| match namespace {
            _ if are_asked_for => Some(0),
            "" => Some(2),
            _ if has_track(namespace) => Some(0),
            _ if !tracks.is_empty() && is_other(namespace) => None,
            _ if has_ranges(namespace) => Some(1),
            _ => Some(3),
        };
        let mut ranked: Vec<(Option<u8>, String, Frames)> = self
            .0
            .into_iter()
            .map(|(name, frames)| (rank(&name), name, frames))
            .collect();
        ranked.sort_by(|a, b| (a.0, &a.1).cmp(&(b.0, &b.1)));
        let mut chosen = Chosen::default();
        let mut contradicting = Vec::new();
        for (rank, name, frames) in ranked {
            if rank.is_none() {
                chosen.others.insert(name);
            } else if chosen.frames.join(frames) && !name.is_empty() {
                contradicting.push(format!("{name}/tf"));
            }
        }
        let others = chosen.others.iter().map(|name| format!("{name}/tf"));
        let left_out: Vec<String> = others.chain(contradicting).collect();
        chosen.note = (!left_out.is_empty()).then(|| {
            format!(
                "transforms on {} are another robot's by the names of the topics, and left out where they have \
                 frames of the same names; input.transform_topics chooses others",
                few(&left_out)
            )
        });
        chosen
    }
}

/// Whether a topic is in a namespace.
pub fn is_in(topic: &str, namespace: &str) -> bool {
    let rest = topic.strip_prefix(namespace);
    !namespace.is_empty() && rest.is_some_and(|rest| rest.starts_with('/'))
}

impl Frames {
    /// Takes what others say that is not known yet; whether they say something else of what is.
    fn join(&mut self, other: Self) -> bool {
        self.moving.join(other.moving);
        self.transforms.join(other.transforms)
    }
}
