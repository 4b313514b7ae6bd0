//! The message types that are read: which fields are wanted of each, and what makes them a message.
//!
//! A new type is a row in [`TYPES`], and a function beside those in [`ranges`] or [`poses`].

use super::message::{Content, Role};
use super::ros::short;
use super::value::{FieldError, Fields};
use super::{poses, ranges};

/// Makes a message of the wanted fields.
pub type Read = for<'m> fn(&Fields<'_, 'm>) -> Result<Content<'m>, FieldError>;

/// A type that is read.
#[derive(Debug)]
pub struct MessageType {
    /// Its ROS 1 or Foxglove name.
    pub name: &'static str,
    pub role: Role,
    pub read: Read,
    paths: &'static str,
}

/// The paths of the wanted fields, with blanks between them; `:xyz` stands for three that end so.
const fn of(name: &'static str, role: Role, read: Read, paths: &'static str) -> MessageType {
    MessageType {
        name,
        role,
        read,
        paths,
    }
}

pub const TYPES: &[MessageType] = &[
    of(
        "sensor_msgs/Range",
        Role::Range,
        ranges::range,
        "header.stamp header.frame_id range min_range max_range field_of_view variance radiation_type",
    ),
    of(
        "sensor_msgs/LaserScan",
        Role::Range,
        ranges::laser_scan,
        "header.stamp header.frame_id ranges angle_min angle_max angle_increment time_increment \
         range_min range_max",
    ),
    of(
        "foxglove.LaserScan",
        Role::Range,
        ranges::foxglove_scan,
        "timestamp frame_id ranges start_angle end_angle pose pose.position:xyz pose.orientation:xyzw",
    ),
    of(
        "sensor_msgs/PointCloud",
        Role::Range,
        ranges::point_cloud,
        "header.stamp header.frame_id points:xyz",
    ),
    of(
        "sensor_msgs/PointCloud2",
        Role::Range,
        ranges::point_cloud_2,
        "header.stamp header.frame_id fields.name fields.offset fields.datatype is_bigendian point_step data",
    ),
    of(
        "nav_msgs/Odometry",
        Role::Odometry,
        poses::odometry,
        "header.stamp header.frame_id child_frame_id pose.pose.position:xyz pose.pose.orientation:xyzw \
         twist.twist.linear:xy twist.twist.angular.z",
    ),
    of(
        "foxglove.Odometry",
        Role::Odometry,
        poses::foxglove_odometry,
        "timestamp frame_id body_frame_id pose pose.position:xyz pose.orientation:xyzw",
    ),
    of(
        "foxglove.PoseInFrame",
        Role::Pose,
        poses::foxglove_pose,
        "timestamp frame_id pose pose.position:xyz pose.orientation:xyzw",
    ),
    of(
        "geometry_msgs/PoseStamped",
        Role::Pose,
        poses::pose,
        "header.stamp header.frame_id pose.position:xyz pose.orientation:xyzw",
    ),
    of(
        "geometry_msgs/PoseWithCovarianceStamped",
        Role::Pose,
        poses::pose,
        "header.stamp header.frame_id pose.pose.position:xyz pose.pose.orientation:xyzw",
    ),
    of(
        "geometry_msgs/TransformStamped",
        Role::Pose,
        poses::transform_stamped,
        "header.stamp header.frame_id child_frame_id transform.translation:xyz transform.rotation:xyzw",
    ),
    of(
        "tf2_msgs/TFMessage",
        Role::Transform,
        poses::transforms,
        TRANSFORMS,
    ),
    of(
        "tf/tfMessage",
        Role::Transform,
        poses::transforms,
        TRANSFORMS,
    ),
    of(
        "foxglove.FrameTransforms",
        Role::Transform,
        poses::foxglove_transforms,
        "transforms.timestamp transforms.parent_frame_id transforms.child_frame_id \
         transforms.translation:xyz transforms.rotation:xyzw",
    ),
    of(
        "foxglove.FrameTransform",
        Role::Transform,
        poses::foxglove_transform,
        "timestamp parent_frame_id child_frame_id translation:xyz rotation:xyzw",
    ),
    of("std_msgs/String", Role::Description, description, "data"),
];

const TRANSFORMS: &str = "transforms.header.stamp transforms.header.frame_id transforms.child_frame_id \
                          transforms.transform.translation:xyz transforms.transform.rotation:xyzw";

impl MessageType {
    /// The paths of the wanted fields, in the order in which `read` takes them.
    pub fn paths(&self) -> Vec<String> {
        let paths = self
            .paths
            .split(' ')
            .flat_map(|path| match path.split_once(':') {
                Some((path, ends)) => ends.chars().map(|end| format!("{path}.{end}")).collect(),
                None => vec![path.to_owned()],
            });
        paths.collect()
    }
}

/// How a message type is read; `None` for types that are not. Text is a robot's description only on a topic
/// of that name.
pub fn known(type_name: &str, topic: &str) -> Option<&'static MessageType> {
    let mut name = short(type_name);
    if name == "std_msgs/String" && !topic.ends_with("robot_description") {
        return None;
    }
    if let Some(foxglove) = name.strip_prefix("foxglove_msgs/") {
        name = format!("foxglove.{foxglove}");
    }
    TYPES.iter().find(|known| known.name == name)
}

/// Whether messages of a type hold ranges and nothing but a sonar's; others may be a lidar's or a camera's.
pub fn is_one_sonar(type_name: &str) -> bool {
    short(type_name) == "sensor_msgs/Range"
}

fn description<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [data] = fields.all();
    Ok(Content::Description(data.text()?.to_owned()))
}

/// Reads a message of a known type from JSON.
#[cfg(test)]
pub fn read_json(name: &str, text: &str) -> Result<Content<'static>, FieldError> {
    let known = known(name, "").unwrap();
    let paths = known.paths().into_iter().map(super::value::Path::from);
    let paths: &Vec<_> = &paths.collect();
    let values = super::json::decode(text.as_bytes(), paths).unwrap();
    (known.read)(&Fields { paths, values })
}
