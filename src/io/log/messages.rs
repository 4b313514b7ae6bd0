//! What the known message types say, read from decoded values.

mod clouds;
mod poses;
mod ranges;

use nalgebra::{Isometry3, Point3};

pub use poses::rotation;

use super::msg_schema::short;
use super::value::{FieldError, Value};

/// No more sonars than this are told apart.
pub const MOST_SONARS: usize = 4096;

/// What the messages of a type are good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Range readings.
    Range,
    /// Odometry samples.
    Odometry,
    /// Poses: odometry samples where a log has no odometry, or where they are asked for.
    Pose,
    /// Transforms between frames.
    Transform,
    /// The robot's description, with its fixed joints.
    Description,
}

/// What one message says.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Range readings, one or a ring of them.
    Ranges(Vec<RangeMessage>),
    /// So many ranges that they are not even looked at.
    Crowd(usize),
    /// Where the robot was.
    Odometry(OdometryMessage),
    /// Where frames are.
    Transforms(Vec<TransformMessage>),
    /// Where the beams of a sonar ring ended.
    Hits(HitsMessage),
    /// A URDF.
    Description(String),
}

impl Content {
    /// How many sonars it has a range of.
    pub fn sonars(&self) -> usize {
        match self {
            Self::Ranges(ranges) => ranges.len(),
            Self::Hits(hits) => hits.points.len(),
            Self::Crowd(count) => *count,
            _ => 0,
        }
    }
}

/// One reading of one sonar.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeMessage {
    /// Of the message; 0 where the driver did not stamp it.
    pub stamp_ns: i64,
    /// How much later than the message's stamp it was taken, nanoseconds.
    pub delay_ns: i64,
    /// Frame of the sensor, without a leading slash.
    pub frame_id: String,
    /// Which of a message's sonars, where it has more than one.
    pub element: Option<usize>,
    /// The beam in the sensor's frame: its axis is x.
    pub frame_from_beam: Isometry3<f64>,
    /// Metres, as everything below; infinite or NaN as the driver wrote it.
    pub range: f64,
    /// See `range`.
    pub min_range: f64,
    /// See `range`.
    pub max_range: f64,
    /// Full angle, radians; 0 or NaN where the message does not say it.
    pub beam_width: f64,
    /// Full angle that is taken where neither message nor configuration says it, radians; 0 or NaN
    /// for none.
    pub likely_beam_width: f64,
    /// Square metres; 0 where the driver, or this form of the message, does not give it.
    pub variance: f64,
}

impl RangeMessage {
    /// A reading of which nothing is known but its value, metres.
    pub fn plain(stamp_ns: i64, frame_id: &str, range: f64) -> Self {
        Self {
            stamp_ns,
            delay_ns: 0,
            frame_id: frame_id.to_owned(),
            element: None,
            frame_from_beam: Isometry3::identity(),
            range,
            min_range: 0.0,
            max_range: f64::INFINITY,
            beam_width: 0.0,
            likely_beam_width: 0.0,
            variance: 0.0,
        }
    }
}

/// One odometry message.
#[derive(Debug, Clone, PartialEq)]
pub struct OdometryMessage {
    /// 0 where the driver did not stamp it.
    pub stamp_ns: i64,
    /// Frame that the pose is in, without a leading slash.
    pub world_frame: String,
    /// Frame that it moves, without a leading slash; empty where the message does not name it.
    pub robot_frame: String,
    /// Pose of the robot's frame in the odometry frame; `None` where a number is not finite or the
    /// quaternion is zero.
    pub world_from_robot: Option<Isometry3<f64>>,
}

/// One transform.
#[derive(Debug, Clone, PartialEq)]
pub struct TransformMessage {
    /// 0 where it is not stamped.
    pub stamp_ns: i64,
    /// Frame that the pose is given in, without a leading slash.
    pub parent: String,
    /// Frame that the pose is of.
    pub child: String,
    /// `None` where a number is not finite or the quaternion is zero.
    pub parent_from_child: Option<Isometry3<f64>>,
}

/// Where the beams of a sonar ring ended; which sonar a point is of is not said.
#[derive(Debug, Clone, PartialEq)]
pub struct HitsMessage {
    /// 0 where the driver did not stamp it.
    pub stamp_ns: i64,
    /// Frame that the points are in, without a leading slash.
    pub frame_id: String,
    /// Metres.
    pub points: Vec<Point3<f64>>,
}

/// Reads a decoded message.
pub type Read = fn(&Value) -> Result<Content, FieldError>;

/// Every type that is read, under its ROS 1 or Foxglove name.
pub const TYPES: &[(&str, Role, Read)] = &[
    ("sensor_msgs/Range", Role::Range, ranges::range),
    ("sensor_msgs/LaserScan", Role::Range, ranges::laser_scan),
    ("foxglove.LaserScan", Role::Range, ranges::foxglove_scan),
    ("sensor_msgs/PointCloud", Role::Range, clouds::point_cloud),
    (
        "sensor_msgs/PointCloud2",
        Role::Range,
        clouds::point_cloud_2,
    ),
    ("nav_msgs/Odometry", Role::Odometry, poses::odometry),
    (
        "foxglove.Odometry",
        Role::Odometry,
        poses::foxglove_odometry,
    ),
    ("foxglove.PoseInFrame", Role::Pose, poses::foxglove_pose),
    ("geometry_msgs/PoseStamped", Role::Pose, poses::pose),
    (
        "geometry_msgs/PoseWithCovarianceStamped",
        Role::Pose,
        poses::pose_with_covariance,
    ),
    (
        "geometry_msgs/TransformStamped",
        Role::Pose,
        poses::transform_as_pose,
    ),
    ("tf2_msgs/TFMessage", Role::Transform, poses::transforms),
    ("tf/tfMessage", Role::Transform, poses::transforms),
    (
        "foxglove.FrameTransforms",
        Role::Transform,
        poses::foxglove_transforms,
    ),
    (
        "foxglove.FrameTransform",
        Role::Transform,
        poses::foxglove_transform,
    ),
    ("std_msgs/String", Role::Description, description),
];

/// What a message type is good for and how it is read; `None` for types that are not. Text is a
/// robot's description only on a topic of that name.
pub fn known(type_name: &str, topic: &str) -> Option<(Role, Read)> {
    let mut name = short(type_name);
    if name == "std_msgs/String" && !topic.ends_with("robot_description") {
        return None;
    }
    if let Some(foxglove) = name.strip_prefix("foxglove_msgs/") {
        name = format!("foxglove.{foxglove}");
    }
    TYPES
        .iter()
        .find_map(|(known, role, read)| (**known == name).then_some((*role, *read)))
}

/// Whether messages of a type hold ranges and nothing but a sonar's; others may be a lidar's or a camera's.
pub fn is_one_sonar(type_name: &str) -> bool {
    short(type_name) == "sensor_msgs/Range"
}

fn description(message: &Value) -> Result<Content, FieldError> {
    let text = message.text("data")?;
    Ok(Content::Description(text.to_owned()))
}

/// The frame named at a path, without a leading slash.
fn frame(message: &Value, path: &str) -> Result<String, FieldError> {
    message
        .text(path)
        .map(|name| name.trim_start_matches('/').to_owned())
}

/// The time at a path, nanoseconds; 0 where the field is absent, as protobuf leaves out what is
/// zero.
fn optional_time(message: &Value, path: &str) -> Result<i64, FieldError> {
    match message.get(path) {
        None => Ok(0),
        Some(_) => message.time(path),
    }
}
