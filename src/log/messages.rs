//! What the known message types say, read from decoded values.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::value::{FieldError, Value};

/// What the messages of a type are good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Range readings.
    Range,
    /// Odometry samples.
    Odometry,
    /// Transforms between frames.
    Transform,
}

impl Role {
    /// The role of a message type; `None` for types that are not read.
    pub fn of(type_name: &str) -> Option<Self> {
        match type_name {
            "sensor_msgs/msg/Range" | "sensor_msgs/Range" => Some(Self::Range),
            "nav_msgs/msg/Odometry" | "nav_msgs/Odometry" => Some(Self::Odometry),
            "tf2_msgs/msg/TFMessage" | "tf2_msgs/TFMessage" => Some(Self::Transform),
            _ => None,
        }
    }
}

/// One range message.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeMessage {
    /// 0 where the driver did not stamp it.
    pub stamp_ns: i64,
    /// Frame of the sensor, without a leading slash.
    pub frame_id: String,
    /// Metres, as everything below; infinite or NaN as the driver wrote it.
    pub range: f64,
    /// See `range`.
    pub min_range: f64,
    /// See `range`.
    pub max_range: f64,
    /// Full angle, radians; 0 or NaN where the driver does not know it.
    pub beam_width: f64,
    /// Square metres; 0 where the driver, or this form of the message, does not give it.
    pub variance: f64,
}

/// One odometry message.
#[derive(Debug, Clone, PartialEq)]
pub struct OdometryMessage {
    /// 0 where the driver did not stamp it.
    pub stamp_ns: i64,
    /// Frame that it moves, without a leading slash.
    pub robot_frame: String,
    /// Pose of the robot's frame in the odometry frame; `None` where a number is not finite or the
    /// quaternion is zero.
    pub world_from_robot: Option<Isometry3<f64>>,
}

/// One transform.
#[derive(Debug, Clone, PartialEq)]
pub struct TransformMessage {
    /// Frame that the pose is given in, without a leading slash.
    pub parent: String,
    /// Frame that the pose is of.
    pub child: String,
    /// `None` where a number is not finite or the quaternion is zero.
    pub parent_from_child: Option<Isometry3<f64>>,
}

/// Reads `sensor_msgs/Range` in both its forms: Humble's has no `variance`.
///
/// # Errors
/// A field that is not there.
pub fn range(message: &Value) -> Result<RangeMessage, FieldError> {
    Ok(RangeMessage {
        stamp_ns: stamp(message, "header.stamp")?,
        frame_id: frame(message, "header.frame_id")?,
        range: message.number("range")?,
        min_range: message.number("min_range")?,
        max_range: message.number("max_range")?,
        beam_width: message.number("field_of_view")?,
        variance: message.number("variance").unwrap_or(0.0),
    })
}

/// Reads `nav_msgs/Odometry`.
///
/// # Errors
/// A field that is not there.
pub fn odometry(message: &Value) -> Result<OdometryMessage, FieldError> {
    Ok(OdometryMessage {
        stamp_ns: stamp(message, "header.stamp")?,
        robot_frame: frame(message, "child_frame_id")?,
        world_from_robot: isometry(message, "pose.pose.position", "pose.pose.orientation")?,
    })
}

/// Reads `tf2_msgs/TFMessage`.
///
/// # Errors
/// A field that is not there.
pub fn transforms(message: &Value) -> Result<Vec<TransformMessage>, FieldError> {
    let transform = |item: &Value| {
        Ok(TransformMessage {
            parent: frame(item, "header.frame_id")?,
            child: frame(item, "child_frame_id")?,
            parent_from_child: isometry(item, "transform.translation", "transform.rotation")?,
        })
    };
    message.list("transforms")?.iter().map(transform).collect()
}

fn stamp(message: &Value, path: &str) -> Result<i64, FieldError> {
    let seconds = message.integer(&format!("{path}.sec"))?;
    let nanoseconds = message.integer(&format!("{path}.nanosec"))?;
    Ok(seconds
        .saturating_mul(1_000_000_000)
        .saturating_add(nanoseconds))
}

fn frame(message: &Value, path: &str) -> Result<String, FieldError> {
    message
        .text(path)
        .map(|name| name.trim_start_matches('/').to_owned())
}

fn isometry(
    message: &Value,
    position: &str,
    orientation: &str,
) -> Result<Option<Isometry3<f64>>, FieldError> {
    let number = |parent: &str, name: &str| message.number(&format!("{parent}.{name}"));
    let translation = Translation3::new(
        number(position, "x")?,
        number(position, "y")?,
        number(position, "z")?,
    );
    let quaternion = Quaternion::new(
        number(orientation, "w")?,
        number(orientation, "x")?,
        number(orientation, "y")?,
        number(orientation, "z")?,
    );
    let norm = quaternion.norm();
    let usable =
        translation.vector.iter().all(|x| x.is_finite()) && norm.is_finite() && norm > 1e-6;
    Ok(usable
        .then(|| Isometry3::from_parts(translation, UnitQuaternion::from_quaternion(quaternion))))
}
