//! Key poses: where the robot is estimated, and what lies between two of them.

use crate::core::frames::Frame;
use crate::core::geometry::{Pose2, angle_between};
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

#[cfg(test)]
pub mod tests {
    use super::*;

    pub fn frame(index: u32, x: f64, yaw: f64) -> Frame {
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
}
