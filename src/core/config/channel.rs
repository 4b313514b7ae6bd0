//! Messages of types that are not known, described by the paths of their fields.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What the messages on one topic say and where. Paths are field names joined by dots; `[]` behind
/// a field stands for each element of an array.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChannelFields {
    /// Type of the messages, as `sensor_msgs/msg/Range`, where the log does not say it. Without a path
    /// they are read as that type.
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    pub type_name: Option<String>,
    /// Path of the range, or of an array of them: the channel carries ranges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<String>,
    /// Path of the stamp: a time of seconds and nanoseconds, or a number. None: the time the
    /// message was recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stamp: Option<String>,
    /// Unit of a stamp that is a number; seconds where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stamp_unit: Option<TimeUnit>,
    /// Path of the sonar's frame id, or of the frame that the odometry is in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// The frame id itself, where the message does not have it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame_name: Option<String>,
    /// Closest distance measured, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_range: Option<Given>,
    /// Where "no echo" begins, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_range: Option<Given>,
    /// Full opening angle of the beam, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beam_width: Option<Given>,
    /// Variance of the range, square metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variance: Option<Given>,
    /// Path of the robot's position: the channel carries odometry.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<String>,
    /// See `x`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<String>,
    /// Path of the robot's heading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw: Option<String>,
    /// Path of a message with `x`, `y`, `z`, or of an array of them: stands for `x` and `y`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<String>,
    /// Path of a message with `x`, `y`, `z`, `w`, or of an array that begins with w (px4_msgs, MAVLink): stands
    /// for `yaw`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<String>,
    /// Unit of angles at paths; radians where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_unit: Option<AngleUnit>,
    /// Metres per unit of lengths at paths; 1 where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metres_per_unit: Option<f64>,
    /// Axis of the poses that points up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// How the robot's heading is counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading: Option<Heading>,
}

/// Axis of poses that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Up {
    /// As of robots (REP 103).
    #[serde(rename = "z")]
    Z,
    /// As of cameras that follow a body.
    #[serde(rename = "y")]
    Y,
    /// As of cameras: z forward, x to the right, y down.
    #[serde(rename = "-y")]
    MinusY,
    /// North, east, down, and forward, right, down: they become east, north, up, and forward, left, up.
    #[serde(rename = "-z")]
    MinusZ,
}

/// How a heading is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Heading {
    /// From x on (REP 103).
    Counterclockwise,
    /// From x on.
    Clockwise,
    /// Clockwise from y, which is north.
    Compass,
}

/// A number, or where the message has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a number, or the path of a field as text")]
pub enum Given {
    /// The same for every message.
    Constant(f64),
    /// Path of a field.
    Path(String),
}

/// Unit of a stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeUnit {
    /// Seconds.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
}

/// Unit of an angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AngleUnit {
    /// Radians.
    Rad,
    /// Degrees.
    Deg,
}

impl ChannelFields {
    /// Whether the channel carries odometry rather than ranges.
    pub fn is_odometry(&self) -> bool {
        self.range.is_none()
    }

    /// Whether it says of what type the messages are or in which unit, and not which fields to read.
    pub fn is_of_known_type(&self) -> bool {
        let paths = [
            &self.range,
            &self.x,
            &self.y,
            &self.yaw,
            &self.position,
            &self.orientation,
        ];
        let says_something = self.type_name.is_some()
            || self.metres_per_unit.is_some()
            || self.up.is_some()
            || self.heading.is_some();
        says_something && paths.iter().all(|path| path.is_none())
    }

    /// What is contradictory or lacks.
    pub fn problem(&self) -> Option<&'static str> {
        let has_position = self.position.is_some() || (self.x.is_some() && self.y.is_some());
        let has_heading = self.orientation.is_some() || self.yaw.is_some();
        let has_part = self.x.is_some() || self.y.is_some() || self.position.is_some();
        match self.range {
            Some(_) if has_part || has_heading => {
                Some("has a range and a pose; a channel carries one or the other")
            }
            Some(_) => None,
            None if self.is_of_known_type() => None,
            None if !has_part && !has_heading => Some(
                "says neither where the range is (range) nor where a pose is (x, y and yaw, or position \
                 and orientation), nor what type its messages are of (type) or their unit (metres_per_unit)",
            ),
            None if !has_position => Some("has a pose without x and y, or position"),
            None if !has_heading => Some("has a pose without yaw or orientation"),
            None => None,
        }
    }
}

/// What is described of a topic: under its name, or else under the first pattern that fits it.
pub fn of_topic<'c>(
    described: &'c BTreeMap<String, ChannelFields>,
    topic: &str,
) -> Option<&'c ChannelFields> {
    let fits = |pattern: &str| {
        let glob = globset::Glob::new(pattern)
            .ok()
            .filter(|_| pattern.contains('*'));
        glob.is_some_and(|glob| glob.compile_matcher().is_match(topic))
    };
    let by_pattern = || described.iter().find(|(pattern, _)| fits(pattern));
    described
        .get(topic)
        .or_else(|| by_pattern().map(|(_, fields)| fields))
}

impl TimeUnit {
    /// Nanoseconds per unit.
    pub fn nanoseconds(self) -> i64 {
        match self {
            Self::S => 1_000_000_000,
            Self::Ms => 1_000_000,
            Self::Us => 1000,
            Self::Ns => 1,
        }
    }
}

impl AngleUnit {
    /// An angle of this unit in radians.
    pub fn radians(self, angle: f64) -> f64 {
        match self {
            Self::Rad => angle,
            Self::Deg => angle.to_radians(),
        }
    }
}
