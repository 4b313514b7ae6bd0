//! The robot's path in key poses, and how a correction of these corrects every pose between.

use nalgebra::Matrix3;

use crate::core::frames::{Correction, Frame};
use crate::core::geometry::{Pose2, Vec2, angle_between, wrap_angle};
use crate::core::ties;

/// A key pose follows when the robot has driven this far, metres, or turned by this, radians.
const SPACING: f64 = 0.1;
const SPACING_ANGLE: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Key poses of a path, at most; those of longer ones lie farther apart.
const MOST_KEYS: usize = 4000;

/// A pose of the robot that is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyPose {
    /// When.
    pub stamp_ns: i64,
    /// The robot as odometry has it.
    pub odom_from_robot: Pose2,
    /// Driven since the key pose before, metres.
    pub driven: f64,
    /// Turned since then, radians, either way.
    pub turned: f64,
}

/// The key poses of frames whose poses are those of odometry.
pub fn key_poses(frames: &[Frame]) -> Vec<KeyPose> {
    let mut wider = 1.0;
    loop {
        let keys = at_least_apart(frames, wider * SPACING, wider * SPACING_ANGLE);
        if keys.len() <= MOST_KEYS {
            return keys;
        }
        wider *= 2.0;
    }
}

fn at_least_apart(frames: &[Frame], spacing: f64, spacing_angle: f64) -> Vec<KeyPose> {
    let mut keys: Vec<KeyPose> = Vec::new();
    let (mut driven, mut turned) = (0.0, 0.0);
    let mut before: Option<Pose2> = None;
    for (place, frame) in frames.iter().enumerate() {
        let now = frame.world_from_robot;
        if let Some(before) = before {
            driven += (now.position() - before.position()).norm();
            turned += angle_between(now.yaw, before.yaw);
        }
        before = Some(now);
        let is_key = keys.last().is_none_or(|last| {
            let apart = (now.position() - last.odom_from_robot.position()).norm();
            frame.stamp_ns > last.stamp_ns
                && (ties::at_least(apart, spacing, ties::LENGTH)
                    || ties::at_least(turned, spacing_angle, ties::ANGLE)
                    || place + 1 == frames.len())
        });
        if is_key {
            keys.push(KeyPose {
                stamp_ns: frame.stamp_ns,
                odom_from_robot: now,
                driven,
                turned,
            });
            (driven, turned) = (0.0, 0.0);
        }
    }
    keys
}

/// Where a stamp lies among key poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    /// The earlier one of the two around it.
    pub earlier: usize,
    /// How much of the way to the later one is done, 0 to 1.
    pub share: f64,
}

/// Places a stamp among two or more key poses; before the first and after the last it is at that one.
pub fn between(keys: &[KeyPose], stamp_ns: i64) -> Between {
    let after = keys.partition_point(|key| key.stamp_ns <= stamp_ns);
    let earlier = after.saturating_sub(1).min(keys.len().saturating_sub(2));
    let share = match (keys.get(earlier), keys.get(earlier + 1)) {
        (Some(from), Some(to)) => {
            let span = to.stamp_ns.saturating_sub(from.stamp_ns) as f64;
            (stamp_ns.saturating_sub(from.stamp_ns) as f64 / span).clamp(0.0, 1.0)
        }
        _ => 0.0,
    };
    Between { earlier, share }
}

/// The path of a robot as it is estimated from its odometry and from what its sonars saw.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CorrectedPath {
    /// The key poses as odometry has them; two or more.
    pub keys: Vec<KeyPose>,
    /// The same as estimated.
    pub world_from_robot: Vec<Pose2>,
    /// Their covariances over (x, y, yaw) in the world, the first pose being exact.
    pub covariances: Vec<Matrix3<f64>>,
}

impl CorrectedPath {
    /// Where something is that odometry has at `odom_from_it` when `stamp_ns` is: moved with the robot
    /// from the key pose before and from the one after, and interpolated between the two.
    pub fn correct(&self, stamp_ns: i64, odom_from_it: &Pose2) -> Pose2 {
        let Between { earlier, share } = between(&self.keys, stamp_ns);
        let moved = |key: usize| {
            let (from, to) = (self.keys.get(key)?, self.world_from_robot.get(key)?);
            Some(to.compose(&from.odom_from_robot.inverse().compose(odom_from_it)))
        };
        match (moved(earlier), moved(earlier + 1)) {
            (Some(a), Some(b)) => Pose2::new(
                a.x + share * (b.x - a.x),
                a.y + share * (b.y - a.y),
                a.yaw + share * wrap_angle(b.yaw - a.yaw),
            ),
            _ => *odom_from_it,
        }
    }

    /// The poses at other key poses; after the last of its own, the path goes on as odometry does.
    pub fn at(&self, keys: &[KeyPose]) -> Vec<Pose2> {
        if self.keys == keys {
            return self.world_from_robot.clone();
        }
        let keys = keys.iter();
        keys.map(|key| self.correct(key.stamp_ns, &key.odom_from_robot))
            .collect()
    }

    /// A frame of odometry at the corrected poses.
    pub fn frame(&self, frame: &Frame) -> Frame {
        let mut corrected = frame.clone();
        let odom_from_robot = frame.world_from_robot;
        corrected.world_from_robot = self.correct(frame.stamp_ns, &odom_from_robot);
        corrected.correction = Some(Correction {
            odom_from_robot,
            covariance: self.covariance(frame.stamp_ns),
        });
        for entry in &mut corrected.entries {
            entry.world_from_sensor = self.correct(entry.stamp_ns, &entry.world_from_sensor);
        }
        corrected
    }

    /// The covariance at a stamp: that of the nearer key pose.
    pub fn covariance(&self, stamp_ns: i64) -> Matrix3<f64> {
        let Between { earlier, share } = between(&self.keys, stamp_ns);
        let nearer = earlier + usize::from(share > 0.5);
        (self.covariances.get(nearer).copied()).unwrap_or_else(Matrix3::zeros)
    }

    /// How far a key pose is from where another estimate of the path has it, at most; metres.
    pub fn moved(&self, other: &Self) -> f64 {
        let pairs = self.world_from_robot.iter().zip(&other.world_from_robot);
        let apart = pairs.map(|(a, b)| (a.position() - b.position()).norm());
        apart.fold(0.0, f64::max)
    }

    /// How far the last pose was moved, metres.
    pub fn end_correction(&self) -> f64 {
        match (self.keys.last(), self.world_from_robot.last()) {
            (Some(from), Some(to)) => {
                let moved: Vec2 = to.position() - from.odom_from_robot.position();
                moved.norm()
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(index: u32, x: f64, yaw: f64) -> Frame {
        Frame {
            index,
            stamp_ns: i64::from(index) * 1_000_000_000,
            world_from_robot: Pose2::new(x, 0.0, yaw),
            correction: None,
            entries: Vec::new(),
        }
    }

    #[test]
    fn a_key_pose_follows_where_the_robot_has_moved() {
        let places = [0.0, 0.05, 0.12, 0.13, 0.14];
        let mut frames: Vec<Frame> = places
            .iter()
            .enumerate()
            .map(|(at, x)| frame(at as u32, *x, 0.0))
            .collect();
        frames.push(frame(5, 0.14, 0.2));
        frames.push(frame(6, 0.15, 0.2));
        let keys = key_poses(&frames);
        let at: Vec<i64> = keys
            .iter()
            .map(|key| key.stamp_ns / 1_000_000_000)
            .collect();
        assert_eq!(at, [0, 2, 5, 6], "the last frame is one, too");
        assert!((keys[1].driven - 0.12).abs() < 1e-12);
        assert!((keys[2].turned - 0.2).abs() < 1e-12);
    }

    #[test]
    fn long_paths_have_key_poses_farther_apart() {
        let frames: Vec<Frame> = (0..9000)
            .map(|k| frame(k, 0.1 * f64::from(k), 0.0))
            .collect();
        let keys = key_poses(&frames);
        assert!(
            keys.len() <= MOST_KEYS && keys.len() > MOST_KEYS / 2,
            "{}",
            keys.len()
        );
    }

    #[test]
    fn a_path_that_is_not_moved_corrects_nothing() {
        let frames: Vec<Frame> = (0..9).map(|k| frame(k, 0.2 * f64::from(k), 0.1)).collect();
        let keys = key_poses(&frames);
        let path = CorrectedPath {
            world_from_robot: keys.iter().map(|key| key.odom_from_robot).collect(),
            covariances: vec![Matrix3::zeros(); keys.len()],
            keys,
        };
        for (corrected, frame) in frames.iter().map(|frame| path.frame(frame)).zip(&frames) {
            let (a, b) = (corrected.world_from_robot, frame.world_from_robot);
            assert!((a.position() - b.position()).norm() < 1e-12);
        }
        assert!(path.end_correction() < 1e-12);
    }
}
