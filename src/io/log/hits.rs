//! What the points of sonar rings say, once it is known where the sonars are: ranges from the points where
//! beams ended, as RosAria publishes them. Each point is the hit of the sonar whose axis it lies on.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};

use super::channels::{self, ChannelReport};
use super::error::{LogError, UnplacedRing};
use super::gather::Gatherer;
use super::message::{HitsMessage, RangeMessage};
use super::sonars::SourceKey;
use super::transforms::TransformTree;
use crate::core::config::Config;
use crate::core::geometry::{Pose2, Vec2, direction};
use crate::core::wording::counted_with;

/// A point further than this off an axis is not that sonar's, where its beam width is not known:
/// radians.
const OFF_AXIS: f64 = std::f64::consts::FRAC_PI_8;

/// A point this near to a sonar's largest range lies at it, metres: coordinates are rounded, and
/// drivers put a point there when nothing echoed.
const AT_LIMIT: f64 = 1e-3;

/// The sonars that a point can come from.
#[derive(Debug)]
pub struct Ring {
    sonars: Vec<Candidate>,
}

#[derive(Debug)]
struct Candidate {
    name: String,
    robot_from_sensor: Pose2,
    half_width: f64,
    max_range: f64,
}

impl Ring {
    /// The sonars whose mount the configuration has, without those that have messages of their own.
    pub fn new(config: &Config, has_messages: &dyn Fn(&str) -> bool) -> Self {
        let sonars = config.sonar.iter().filter(|(name, _)| !has_messages(name));
        let mounted = sonars.filter_map(|(name, known)| {
            let mount = Pose2::new(known.x?, known.y?, known.yaw?);
            let width = known.beam_width.or(config.sonars.beam_width);
            Some(Candidate {
                name: name.clone(),
                robot_from_sensor: mount,
                half_width: width.map_or(OFF_AXIS, |w| w / 2.0),
                max_range: known.max_range.unwrap_or(f64::INFINITY),
            })
        });
        Self {
            sonars: mounted.collect(),
        }
    }

    /// Whether there is no sonar to choose from.
    pub fn is_empty(&self) -> bool {
        self.sonars.is_empty()
    }

    /// The range of each sonar that a point lies on the axis of, metres, and how many points lie
    /// on none.
    pub fn ranges(
        &self,
        points: &[Point3<f64>],
        robot_from_cloud: &Isometry3<f64>,
    ) -> (BTreeMap<&str, f64>, u64) {
        let (mut ranges, mut strays) = (BTreeMap::new(), 0);
        // RosAria fills its clouds up with points at the origin.
        let is_padding = |point: &&Point3<f64>| point.x == 0.0 && point.y == 0.0;
        for point in points.iter().filter(|point| !is_padding(point)) {
            let hit = (robot_from_cloud * point).xy().coords;
            match self.nearest(hit) {
                Some((name, range)) if !ranges.contains_key(name) => {
                    ranges.insert(name, range);
                }
                _ => strays += 1,
            }
        }
        (ranges, strays)
    }

    /// The sonar whose axis a point lies nearest to in angle, and its distance; +inf at the limit.
    fn nearest(&self, hit: Vec2) -> Option<(&str, f64)> {
        let seen = self.sonars.iter().filter_map(|sonar| {
            let point = sonar.robot_from_sensor.inverse_transform(hit);
            let off_axis = direction(point).abs();
            (off_axis <= sonar.half_width).then(|| (off_axis, sonar, point.norm()))
        });
        let (_, sonar, distance) = seen.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let range = if distance > sonar.max_range - AT_LIMIT {
            f64::INFINITY
        } else {
            distance
        };
        Some((&sonar.name, range))
    }
}

/// Turns the points of sonar rings into the ranges of the sonars whose mounts the configuration has. What is
/// missing where it has none is returned.
pub fn take(
    gatherer: &mut Gatherer,
    transforms: &TransformTree,
    config: &Config,
    robot_frame: &str,
    world_frame: &str,
    reports: &mut [ChannelReport],
) -> Option<LogError> {
    let hits = std::mem::take(&mut gatherer.hits);
    let keys: Vec<&SourceKey> = gatherer.sources.iter().map(|s| &s.key).collect();
    let ring = Ring::new(config, &|name| {
        keys.iter()
            .any(|key| key.frame == name || key.topic == name)
    });
    let unplaced = ring.is_empty().then(|| directions(&hits)).flatten();
    let mut owners = BTreeMap::<String, String>::new();
    let mut strays = BTreeMap::<String, u64>::new();
    let mut doubled = BTreeMap::<String, u64>::new();
    for (topic, logged_ns, cloud) in hits {
        let (robot_frame, known) =
            robot_from(transforms, &cloud.frame_id, robot_frame, world_frame);
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
            channels::refuse(reports, &topic, problem);
            continue;
        };
        gatherer.messages += 1;
        gatherer.unstamped += u64::from(cloud.stamp_ns == 0);
        let (ranges, unmatched) = ring.ranges(&cloud.points, &robot_from_cloud);
        *strays.entry(topic.clone()).or_default() += unmatched;
        for (sonar, range) in ranges {
            let owner = owners
                .entry(sonar.to_owned())
                .or_insert_with(|| topic.clone());
            if *owner != topic {
                *doubled.entry(topic.clone()).or_default() += 1;
                continue;
            }
            let range = RangeMessage::plain(cloud.stamp_ns, sonar, range);
            gatherer.take_range(&topic, logged_ns, range, 0);
        }
    }
    for (topic, count) in strays.into_iter().filter(|(_, count)| *count > 0) {
        gatherer.notes.push(format!(
            "{} on {topic} in no sonar's beam, or in one that has another; look at the mounts in the configuration",
            counted_with(count, "point", "lies", "lie")
        ));
    }
    for (topic, count) in doubled {
        gatherer.notes.push(format!(
            "{} on {topic} left out: of sonars that another topic had points of before; --range-topic chooses",
            counted_with(count, "point", "is", "are")
        ));
    }
    unplaced.map(|ring| LogError::UnplacedRing(Box::new(ring)))
}

/// The robot's frame, which carries the cloud's where nothing names it, and the cloud in it.
fn robot_from(
    transforms: &TransformTree,
    cloud: &str,
    robot_frame: &str,
    world_frame: &str,
) -> (String, Option<Isometry3<f64>>) {
    let robot_frame = if robot_frame.is_empty() {
        transforms.carrier(cloud, world_frame).unwrap_or(cloud)
    } else {
        robot_frame
    };
    let known = transforms.between(robot_frame, cloud);
    (robot_frame.to_owned(), known.map(|(pose, _)| pose))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::config::file;

    #[test]
    fn a_point_is_the_hit_of_the_sonar_on_whose_axis_it_lies() {
        let config = file::parse(
            "[sonars]\nbeam_width = 20\n[sonar.front]\nx=0.1\ny=0\nyaw=0\n\
             [sonar.left]\nx=0\ny=0.1\nyaw=90\nmax_range=3.0005\n[sonar.rear_left]\nx=-0.2\ny=0.1\nyaw=90\n\
             [sonar.other]\nx=0\ny=0\nyaw=180\n[sonar.unmounted]\nmax_range=4",
        )
        .unwrap();
        let ring = Ring::new(&config, &|name| name == "other");
        // The cloud's frame is 5 cm ahead of the robot's.
        let robot_from_cloud = Isometry3::translation(0.05, 0.0, 0.0);
        let points = [
            Point3::new(2.05, 0.0, 0.0),
            Point3::new(-0.25, 1.1, 0.0),
            Point3::new(-0.05, 3.1, 0.0),
            Point3::new(-3.0, 0.0, 0.0), // behind: no sonar
            Point3::new(f64::NAN, 0.0, 0.0),
        ];
        let (ranges, strays) = ring.ranges(&points, &robot_from_cloud);
        let expected = [("front", 2.0), ("left", f64::INFINITY), ("rear_left", 1.0)];
        assert_eq!(ranges.len(), expected.len());
        for (name, range) in expected {
            assert!(
                ranges[name] == range || (ranges[name] - range).abs() < 1e-12,
                "{name}"
            );
        }
        assert_eq!(strays, 2);
    }
}
