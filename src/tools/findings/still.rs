//! A robot that does not move.

use super::facts::Facts;
use super::finding::{Finding, Weight};
use super::odometry::OdometryFacts;

pub fn check(facts: &Facts, odometry: &OdometryFacts) -> Option<Finding> {
    let frames = &facts.replay.config.frames;
    // Of times that the stamps were in twice no way is known.
    let is_still = facts.clock_set.is_none()
        && odometry.distance < frames.step
        && odometry.turning < frames.step_angle;
    is_still.then(|| {
        Finding::new(
            Weight::Serious,
            "still",
            format!(
                "the robot does not move: {:.2} m and {:.1} deg in all",
                odometry.distance,
                odometry.turning.to_degrees()
            ),
            "arcs from one place tell nothing of walls and corners: they all fall into one frame",
            "look whether the odometry is the right one; lower frames.step for a crawling robot",
        )
    })
}
