//! The robot's path in key poses, and how a correction of these corrects every pose between.

use nalgebra::Matrix3;

use super::drift::Drift;
use super::key_pose::{Between, KeyPose, between};
use crate::core::frames::{Correction, Frame};
use crate::core::geometry::{Pose2, Vec2, wrap_angle};

/// The path of a robot as it is estimated from its odometry and from what its sonars saw.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CorrectedPath {
    /// The key poses as odometry has them; two or more.
    pub keys: Vec<KeyPose>,
    /// The same as estimated.
    pub world_from_robot: Vec<Pose2>,
    /// Their covariances over (x, y, yaw) in the world, the first pose being exact.
    pub covariances: Vec<Matrix3<f64>>,
    /// The noise of odometry: as configured, or found.
    pub drift: Drift,
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
        corrected.correction = Some(Box::new(Correction {
            odom_from_robot,
            covariance: self.covariance(frame.stamp_ns),
        }));
        for entry in &mut corrected.entries {
            entry.pose_variance = (self.drift).between_key_poses(
                &self.keys,
                entry.stamp_ns,
                entry.world_from_sensor.yaw,
            );
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
    use crate::core::joint::key_pose::{key_poses, tests::frame};

    #[test]
    fn a_path_that_is_not_moved_corrects_nothing() {
        let frames: Vec<Frame> = (0..9).map(|k| frame(k, 0.2 * f64::from(k), 0.1)).collect();
        let keys = key_poses(&frames);
        let path = CorrectedPath {
            world_from_robot: keys.iter().map(|key| key.odom_from_robot).collect(),
            covariances: vec![Matrix3::zeros(); keys.len()],
            drift: Drift::NONE,
            keys,
        };
        for (corrected, frame) in frames.iter().map(|frame| path.frame(frame)).zip(&frames) {
            let (a, b) = (corrected.world_from_robot, frame.world_from_robot);
            assert!((a.position() - b.position()).norm() < 1e-12);
        }
        assert!(path.end_correction() < 1e-12);
    }
}
