//! An arc: one echo placed in the world.

use crate::core::config::Noise;
use crate::core::event::SonarId;
use crate::core::frames::Entry;
use crate::core::geometry::{Pose2, Vec2, angle_between, unit};

/// Slack on the edge of a beam, radians, so that rounding does not decide.
pub const BEAM_SLACK: f64 = 1e-9;

/// Names one arc of a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ArcId {
    /// The frame that holds it.
    pub frame: u32,
    /// The sonar that measured it.
    pub sonar: SonarId,
}

/// An echo in the world: all places at `range` from the sensor, inside the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Its name.
    pub id: ArcId,
    /// When it was measured.
    pub stamp_ns: i64,
    /// Sensor centre and beam axis.
    pub world_from_sensor: Pose2,
    /// Radius, metres.
    pub range: f64,
    /// Full opening angle, radians.
    pub beam_width: f64,
    /// Variance of `range`, square metres.
    pub variance: f64,
}

impl Arc {
    /// Places a sonar's entry in a frame; `None` where nothing echoed.
    pub fn of_entry(frame: u32, entry: &Entry, noise: &Noise) -> Option<Self> {
        let echo = entry.echo?;
        Some(Self {
            id: ArcId {
                frame,
                sonar: entry.sonar,
            },
            stamp_ns: entry.stamp_ns,
            world_from_sensor: entry.world_from_sensor,
            range: echo.range,
            beam_width: entry.beam_width,
            variance: noise.variance(echo.range, echo.variance) + entry.pose_variance,
        })
    }

    /// The sensor centre.
    pub fn center(&self) -> Vec2 {
        self.world_from_sensor.position()
    }

    /// Whether a bearing in the world lies within the beam.
    pub fn beam_holds(&self, bearing: f64) -> bool {
        self.beam_nearly_holds(bearing, 0.0)
    }

    /// The same with `slack` radians on either side.
    pub fn beam_nearly_holds(&self, bearing: f64, slack: f64) -> bool {
        angle_between(bearing, self.world_from_sensor.yaw)
            <= self.beam_width / 2.0 + BEAM_SLACK + slack
    }

    /// The point of the arc at a bearing in the world.
    pub fn point_at(&self, bearing: f64) -> Vec2 {
        self.center() + unit(bearing) * self.range
    }
}
