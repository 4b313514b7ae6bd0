//! Groups readings into frames: one step of the replay, at most one reading per sonar.

use crate::event::SonarId;
use crate::geometry::Pose2;

/// One step of the replay.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Counts from 0.
    pub index: u32,
    /// Stamp of the reading that opened the frame.
    pub stamp_ns: i64,
    /// The robot at that stamp.
    pub world_from_robot: Pose2,
    /// What each sonar gave, sorted by sonar; a sonar that did not fire has no entry.
    pub entries: Vec<Entry>,
}

/// The one reading that a sonar gives a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Which sonar.
    pub sonar: SonarId,
    /// When it was taken.
    pub stamp_ns: i64,
    /// The sensor at that stamp.
    pub world_from_sensor: Pose2,
    /// Full opening angle of the beam, radians.
    pub beam_width: f64,
    /// What came back; `None` where nothing echoed.
    pub echo: Option<Echo>,
}

/// What came back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// Measured distance, metres.
    pub range: f64,
    /// Its variance as the driver reports it, square metres; 0 where it does not.
    pub variance: f64,
}
