//! What the points of sonar rings say, once it is known where the sonars are.

use std::collections::BTreeMap;

use super::Gatherer;
use crate::config::Config;
use crate::log::channels::ChannelReport;
use crate::log::messages::RangeMessage;
use crate::log::notes;
use crate::log::rings::Ring;
use crate::log::sonars::SourceKey;

impl Gatherer {
    /// Turns the points of sonar rings into the ranges of the sonars whose mounts the configuration
    /// has.
    pub(super) fn take_hits(
        &mut self,
        config: &Config,
        robot_frame: &str,
        world_frame: &str,
        channels: &mut [ChannelReport],
    ) {
        let hits = std::mem::take(&mut self.hits);
        let keys: Vec<&SourceKey> = self.sources.iter().map(|s| &s.key).collect();
        let ring = Ring::new(config, &|name| {
            keys.iter()
                .any(|key| key.frame == name || key.topic == name)
        });
        let mut strays = BTreeMap::<String, u64>::new();
        for (topic, logged_ns, cloud) in hits {
            let robot_frame = if robot_frame.is_empty() {
                self.transforms
                    .carrier(&cloud.frame_id, world_frame)
                    .unwrap_or(&cloud.frame_id)
            } else {
                robot_frame
            };
            let known = self.transforms.between(robot_frame, &cloud.frame_id);
            let (Some((robot_from_cloud, _)), false) = (known, ring.is_empty()) else {
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
                        "{count} points on {topic} lie in no sonar's beam, or in one that has another; look \
                         at the mounts in the configuration"
                    )
                }),
        );
    }
}
