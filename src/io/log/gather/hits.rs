//! What the points of sonar rings say, once it is known where the sonars are.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use super::Gatherer;
use crate::core::config::Config;
use crate::core::geometry::{Vec2, direction};
use crate::core::wording::counted_with;
use crate::io::log::channels::ChannelReport;
use crate::io::log::error::UnplacedRing;
use crate::io::log::message::{HitsMessage, RangeMessage};
use crate::io::log::rings::Ring;
use crate::io::log::sonars::SourceKey;
use crate::io::log::{LogError, notes};

impl Gatherer {
    /// Turns the points of sonar rings into the ranges of the sonars whose mounts the configuration
    /// has. What is missing where it has none is returned.
    pub(super) fn take_hits(
        &mut self,
        config: &Config,
        robot_frame: &str,
        world_frame: &str,
        channels: &mut [ChannelReport],
    ) -> Option<LogError> {
        let hits = std::mem::take(&mut self.hits);
        let keys: Vec<&SourceKey> = self.sources.iter().map(|s| &s.key).collect();
        let ring = Ring::new(config, &|name| {
            keys.iter()
                .any(|key| key.frame == name || key.topic == name)
        });
        let unplaced = ring.is_empty().then(|| directions(&hits)).flatten();
        let owners = owners(&hits, &ring, |frame| {
            self.robot_from(frame, robot_frame, world_frame)
        });
        let mut strays = BTreeMap::<String, u64>::new();
        let mut doubled = BTreeMap::<String, u64>::new();
        for (topic, logged_ns, cloud) in hits {
            let (robot_frame, known) = self.robot_from(&cloud.frame_id, robot_frame, world_frame);
            let (Some(robot_from_cloud), false) = (known, ring.is_empty()) else {
                let problem = if ring.is_empty() {
                    "the points do not say where the sonars are that they come from; give x, y and yaw of \
                     each under [sonar.\"name\"] in the configuration"
                        .to_owned()
                } else {
                    format!(
                        "no transform joins its frame `{}` to `{robot_frame}`; if they are the same, set \
                         input.robot_frame",
                        cloud.frame_id
                    )
                };
                notes::refuse(channels, &topic, problem);
                continue;
            };
            self.messages += 1;
            self.unstamped += u64::from(cloud.stamp_ns == 0);
            let (ranges, unmatched) = ring.ranges(&cloud.points, &robot_from_cloud);
            *strays.entry(topic.clone()).or_default() += unmatched;
            for (sonar, range) in ranges {
                if owners.get(sonar).is_some_and(|owner| *owner != topic) {
                    *doubled.entry(topic.clone()).or_default() += 1;
                    continue;
                }
                let range = RangeMessage::plain(cloud.stamp_ns, sonar, range);
                self.take_range(&topic, logged_ns, range);
            }
        }
        self.notes.extend(
            strays
                .into_iter()
                .filter(|(_, count)| *count > 0)
                .map(|(topic, count)| {
                    format!(
                        "{} on {topic} in no sonar's beam, or in one that has another; look at the mounts in \
                         the configuration",
                        counted_with(count, "point", "lies", "lie")
                    )
                }),
        );
        self.notes.extend(doubled.into_iter().map(|(topic, count)| {
            format!(
                "{} on {topic} left out: of sonars that another topic has more points of; --range-topic chooses",
                counted_with(count, "point", "is", "are")
            )
        }));
        unplaced.map(|ring| LogError::UnplacedRing(Box::new(ring)))
    }

    /// The robot's frame, which carries the cloud's where nothing names it, and the cloud in it.
    fn robot_from(
        &self,
        cloud: &str,
        robot_frame: &str,
        world_frame: &str,
    ) -> (String, Option<Isometry3<f64>>) {
        let robot_frame = if robot_frame.is_empty() {
            let carrier = self.transforms.carrier(cloud, world_frame);
            carrier.unwrap_or(cloud)
        } else {
            robot_frame
        };
        let known = self.transforms.between(robot_frame, cloud);
        (robot_frame.to_owned(), known.map(|(pose, _)| pose))
    }
}

/// The topic that has most points of each sonar, where there are several topics.
fn owners<'r>(
    hits: &[(String, i64, HitsMessage)],
    ring: &'r Ring,
    place: impl Fn(&str) -> (String, Option<Isometry3<f64>>),
) -> BTreeMap<String, String> {
    let mut counts = BTreeMap::<&'r str, BTreeMap<&str, u64>>::new();
    if hits
        .windows(2)
        .all(|pair| matches!(pair, [a, b] if a.0 == b.0))
    {
        return BTreeMap::new();
    }
    for (topic, _, cloud) in hits {
        let Some(robot_from_cloud) = place(&cloud.frame_id).1 else {
            continue;
        };
        for (sonar, _) in ring.ranges(&cloud.points, &robot_from_cloud).0 {
            *counts.entry(sonar).or_default().entry(topic).or_default() += 1;
        }
    }
    let most = |topics: BTreeMap<&str, u64>| {
        // Of equally many the first by name.
        let most = topics.into_iter().rev().max_by_key(|(_, count)| *count);
        most.map(|(topic, _)| topic.to_owned())
    };
    counts
        .into_iter()
        .filter_map(|(sonar, topics)| Some((sonar.to_owned(), most(topics)?)))
        .collect()
}

/// Where the points of each sonar lie, on the topic that has most of them.
fn directions(hits: &[(String, i64, HitsMessage)]) -> Option<UnplacedRing> {
    let (topic, _, fullest) = hits
        .iter()
        .rev()
        .max_by_key(|(_, _, cloud)| cloud.points.len())?;
    let mut sums = vec![Vec2::zeros(); fullest.points.len()];
    for (_, _, cloud) in hits.iter().filter(|(of, ..)| of == topic) {
        for (sum, point) in sums.iter_mut().zip(&cloud.points) {
            if point.iter().all(|x| x.is_finite()) {
                *sum += point.xy().coords;
            }
        }
    }
    Some(UnplacedRing {
        topic: topic.clone(),
        directions: sums.into_iter().map(direction).collect(),
    })
}
