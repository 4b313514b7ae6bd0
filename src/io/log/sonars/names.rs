//! What the sonars are called, and which frame they are mounted on.

use std::collections::{BTreeMap, BTreeSet};

use super::{Named, NoRobotFrame, Placing, Source, mount_of};
use crate::core::config::SonarOverride;

impl Placing<'_> {
    /// A sonar's name: its frame, or its topic where two topics share the frame; and its place in
    /// the message, where that holds several.
    pub(super) fn name<'s>(
        &self,
        sources: &'s [Source],
        notes: &mut Vec<String>,
    ) -> Vec<Named<'s>> {
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
    pub(super) fn robot_frame(
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
}
