//! The pose's part in a decision: how far an arc's sensor was moved from where odometry has it.

use serde::Serialize;

use crate::core::geometry::wrap_angle;
use crate::core::replay::Outcome;
use crate::core::rounding::number;
use crate::core::tmam::arc::Arc;

/// How the pose of an arc was corrected. SI units and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PoseStory {
    /// How far the sensor is from where odometry has it.
    #[serde(serialize_with = "number")]
    pub moved: f64,
    /// By how much it is turned against it; left is positive.
    #[serde(serialize_with = "number")]
    pub turned: f64,
    /// Standard deviation of the robot's position, the root of both variances.
    #[serde(serialize_with = "number")]
    pub sigma: f64,
    /// Standard deviation of its heading.
    #[serde(serialize_with = "number")]
    pub sigma_heading: f64,
}

impl PoseStory {
    /// Of an arc at a corrected pose.
    pub fn new(arc: &Arc, outcome: &Outcome) -> Option<Self> {
        let joint = outcome.joint()?;
        let odometry = joint.odom_from_sensor.get(&arc.id)?;
        let used = arc.world_from_sensor;
        let covariance = joint.path.covariance(arc.stamp_ns);
        Some(Self {
            moved: (used.position() - odometry.position()).norm(),
            turned: wrap_angle(used.yaw - odometry.yaw),
            sigma: (covariance.m11 + covariance.m22).max(0.0).sqrt(),
            sigma_heading: covariance.m33.max(0.0).sqrt(),
        })
    }

    pub fn text(&self) -> String {
        format!(
            "  Its pose: odometry's, moved by {:.1} mm and turned by {:.2} deg; sigma {:.1} mm, {:.2} deg.\n",
            self.moved * 1e3,
            self.turned.to_degrees(),
            self.sigma * 1e3,
            self.sigma_heading.to_degrees()
        )
    }
}
