//! What a replay heard and where, held against the features of its map whatever the beams hold.

use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::geometry::{Pose2, Vec2, direction, rotate, wrap_angle};
use crate::core::joint::landmark::Landmark;
use crate::core::odometry::Track;
use crate::core::replay::{Outcome, Replay};
use crate::core::tmam::feature::{MapFeature, Segment, Shape, Status};

/// The time over which a velocity is taken, seconds.
const MOMENT: f64 = 0.05;

/// The sine of the angle between lines of one direction, at most.
const ALIKE: f64 = 0.1;

/// One sonar's reading in a frame.
#[derive(Debug, Clone, Copy)]
pub struct Ping {
    /// Whose.
    pub sonar: SonarId,
    /// When.
    pub stamp_ns: i64,
    /// The sensor as the replay had it.
    pub world_from_sensor: Pose2,
    /// The sensor by odometry alone.
    pub odom_from_sensor: Pose2,
    /// The range of its echo and the variance of that; `None` without one.
    pub echo: Option<(f64, f64)>,
    /// Full opening angle, radians.
    pub beam_width: f64,
    /// The sensor's velocity in the world, metres per second.
    pub velocity: Vec2,
}

/// A feature of the map as an unknown.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Line or point.
    pub landmark: Landmark,
    /// How far a line reaches.
    pub extent: Option<Segment>,
}

/// A feature as a sensor should hear it.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Metres.
    pub range: f64,
    /// In the world, radians.
    pub bearing: f64,
    /// How far inside its ends the perpendicular meets a line, metres; of a point infinite.
    pub inside: f64,
}

/// All of it.
#[derive(Debug, Clone)]
pub struct Scene {
    /// By frame and sonar.
    pub pings: Vec<Ping>,
    /// The features.
    pub places: Vec<Place>,
    /// Where each sonar is mounted.
    pub mounts: Vec<Pose2>,
    /// The farthest echo of each sonar, metres.
    farthest: Vec<f64>,
}

impl Scene {
    /// What a replay heard, and the map that it came to.
    pub fn new(replay: &Replay<'_>, outcome: &Outcome) -> Self {
        let events = &replay.log().events;
        let config = replay.config();
        let track = Track::of_ranges(&events.odometry, config);
        let path = outcome.joint().map(|joint| &joint.path);
        let mounts: Vec<Pose2> = (events.sonars.iter())
            .map(|sonar| sonar.robot_from_sensor)
            .collect();
        let mut farthest = vec![0.0_f64; mounts.len()];
        let mut pings = Vec::new();
        let entries = |frame: &Frame| frame.entries.clone();
        for entry in replay.frames().iter().flat_map(entries) {
            let Some(mount) = mounts.get(entry.sonar.index()) else {
                continue;
            };
            let odom_from_sensor = entry.world_from_sensor;
            let world_from_sensor = path.map_or(odom_from_sensor, |path| {
                path.correct(entry.stamp_ns, &odom_from_sensor)
            });
            let turned = wrap_angle(world_from_sensor.yaw - odom_from_sensor.yaw);
            let instant = track.instant_of_ns(entry.stamp_ns);
            let at = |seconds: f64| {
                let pose = track.world_from_robot(instant.saturating_add((seconds * 1e9) as i64));
                pose.ok().map(|pose| pose.compose(mount).position())
            };
            let velocity = match (at(-MOMENT / 2.0), at(MOMENT / 2.0)) {
                (Some(before), Some(after)) => (after - before) / MOMENT,
                _ => Vec2::zeros(),
            };
            let variance = |range, reported| config.noise.variance(range, reported);
            let echo = entry.echo;
            let echo = echo.map(|echo| (echo.range, variance(echo.range, echo.variance)));
            if let (Some((range, _)), Some(farthest)) =
                (echo, farthest.get_mut(entry.sonar.index()))
            {
                *farthest = farthest.max(range);
            }
            pings.push(Ping {
                sonar: entry.sonar,
                stamp_ns: entry.stamp_ns,
                world_from_sensor,
                odom_from_sensor,
                echo,
                beam_width: entry.beam_width,
                velocity: rotate(velocity, turned),
            });
        }
        Self {
            pings,
            places: (outcome.map.iter())
                .filter(|feature| feature.status == Status::Confirmed)
                .filter_map(Place::of)
                .collect(),
            mounts,
            farthest,
        }
    }

    /// How many echoes each sonar has.
    pub fn echoes(&self) -> Vec<usize> {
        let mut echoes = vec![0; self.mounts.len()];
        for ping in self.pings.iter().filter(|ping| ping.echo.is_some()) {
            if let Some(count) = echoes.get_mut(ping.sonar.index()) {
                *count += 1;
            }
        }
        echoes
    }

    /// How far a sonar hears; of one that hears nothing as far as the others.
    pub fn reach(&self, sonar: SonarId) -> f64 {
        let own = self.farthest.get(sonar.index()).copied().unwrap_or(0.0);
        if own > 0.0 {
            return own;
        }
        self.farthest.iter().copied().fold(0.0, f64::max)
    }
}

impl Place {
    /// `None` of circles, which are no landmarks.
    fn of(feature: &MapFeature) -> Option<Self> {
        Some(Self {
            landmark: Landmark::of(&feature.shape)?,
            extent: match feature.shape {
                Shape::Line(segment) => Some(segment),
                Shape::Point(_) | Shape::Circle(_) => None,
            },
        })
    }

    /// How a sensor should hear it; `None` where it stands on it.
    pub fn expected(&self, sensor: Vec2) -> Option<Expected> {
        let predicted = self.landmark.predict(sensor)?;
        let inside = self.extent.map_or(f64::INFINITY, |segment| {
            let way = (sensor - segment.mid).dot(&segment.along());
            segment.half_length - way.abs()
        });
        Some(Expected {
            range: predicted.range,
            // The range grows where the sensor moves away from what it hears.
            bearing: direction(-predicted.by_sensor.transpose()),
            inside,
        })
    }

    /// Whether it may be the same thing, seen elsewhere: both points, or lines of one direction.
    pub fn is_like(&self, other: &Self) -> bool {
        match (self.extent, other.extent) {
            (None, None) => true,
            (Some(a), Some(b)) => a.along().perp(&b.along()).abs() < ALIKE,
            _ => false,
        }
    }

    /// Whether it stands between two places.
    pub fn hides(&self, from: Vec2, to: Vec2) -> bool {
        let Some(segment) = self.extent else {
            return false;
        };
        let [a, b] = segment.ends();
        let side = |p: Vec2, q: Vec2, r: Vec2| (q - p).perp(&(r - p));
        side(from, to, a) * side(from, to, b) < 0.0 && side(a, b, from) * side(a, b, to) < 0.0
    }
}
