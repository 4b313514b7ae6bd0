//! What is said of sonars whose place is not known.

use super::lists::list;

/// A sonar whose place on the robot is unknown.
#[derive(Debug, thiserror::Error)]
#[error(
    "no mounting pose for sonar frame `{frame}` (topic {topic}): {why}. {} Give the mount in the \
     configuration:\n\n    [sonar.\"{sonar}\"]\n    x = 0.0    # m, in `{robot_frame}`\n    y = 0.0    # m\n    \
     yaw = 0.0  # deg\n\nor leave its topic out with --range-topic",
    list("Frames with a transform:", .frames)
)]
pub struct MissingMount {
    /// The sonar's name.
    pub sonar: String,
    /// Its topic.
    pub topic: String,
    /// Its frame.
    pub frame: String,
    /// The robot's frame.
    pub robot_frame: String,
    /// What stands in the way.
    pub why: String,
    /// Every frame of the transform tree.
    pub frames: Vec<String>,
}

/// Points of a sonar ring, without the mounts of its sonars.
#[derive(Debug, thiserror::Error)]
#[error(
    "the points on {topic} do not say where the sonars are that they come from. Give the mount of each of the \
     {} in the configuration, under any name (`tmam info --skeleton` prints all of it):\n\n    \
     [sonar.\"{}\"]\n    x = 0.0          # m, in the robot's frame\n    y = 0.0          # m\n    \
     yaw = {:.1}  # deg: where the beam looks\n    beam_width = 22.5\n    max_range = 5.0  # m: a point at it is no echo",
    directions.len(),
    self.name(0),
    directions.first().copied().unwrap_or_default().to_degrees()
)]
pub struct UnplacedRing {
    /// The topic.
    pub topic: String,
    /// Where the points of each sonar lie, seen from the robot: radians.
    pub directions: Vec<f64>,
}

impl UnplacedRing {
    /// What the sonar of the `index`-th point may be called.
    pub fn name(&self, index: usize) -> String {
        format!("sonar_{index:02}")
    }
}
