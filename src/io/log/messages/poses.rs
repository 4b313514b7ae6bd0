//! Messages that say where a frame is.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

use super::{Content, OdometryMessage, TransformMessage, frame, optional_time};
use crate::io::log::value::{FieldError, Value};

/// `nav_msgs/Odometry`.
pub fn odometry(message: &Value) -> Result<Content, FieldError> {
    Ok(Content::Odometry(OdometryMessage {
        stamp_ns: message.time("header.stamp")?,
        world_frame: frame(message, "header.frame_id")?,
        robot_frame: frame(message, "child_frame_id")?,
        world_from_robot: isometry(message, "pose.pose.position", "pose.pose.orientation")?,
    }))
}

/// `geometry_msgs/PoseStamped`.
pub fn pose(message: &Value) -> Result<Content, FieldError> {
    stamped_pose(message, "pose")
}

/// `geometry_msgs/PoseWithCovarianceStamped`.
pub fn pose_with_covariance(message: &Value) -> Result<Content, FieldError> {
    stamped_pose(message, "pose.pose")
}

fn stamped_pose(message: &Value, path: &str) -> Result<Content, FieldError> {
    let (position, orientation) = (format!("{path}.position"), format!("{path}.orientation"));
    Ok(Content::Odometry(OdometryMessage {
        stamp_ns: message.time("header.stamp")?,
        world_frame: frame(message, "header.frame_id")?,
        robot_frame: String::new(),
        world_from_robot: isometry(message, &position, &orientation)?,
    }))
}

/// `geometry_msgs/TransformStamped` on a topic of its own.
pub fn transform_as_pose(message: &Value) -> Result<Content, FieldError> {
    let transform = transform(message)?;
    Ok(Content::Odometry(OdometryMessage {
        stamp_ns: message.time("header.stamp")?,
        world_frame: transform.parent,
        robot_frame: transform.child,
        world_from_robot: transform.parent_from_child,
    }))
}

/// `foxglove.Odometry`.
pub fn foxglove_odometry(message: &Value) -> Result<Content, FieldError> {
    let robot_frame = frame(message, "body_frame_id")?;
    foxglove_stamped(message, robot_frame)
}

/// `foxglove.PoseInFrame`.
pub fn foxglove_pose(message: &Value) -> Result<Content, FieldError> {
    foxglove_stamped(message, String::new())
}

fn foxglove_stamped(message: &Value, robot_frame: String) -> Result<Content, FieldError> {
    Ok(Content::Odometry(OdometryMessage {
        stamp_ns: optional_time(message, "timestamp")?,
        world_frame: frame(message, "frame_id")?,
        robot_frame,
        world_from_robot: match message.get("pose") {
            None => None,
            Some(pose) => foxglove_isometry(pose, "position", "orientation")?,
        },
    }))
}

/// `tf2_msgs/TFMessage`.
pub fn transforms(message: &Value) -> Result<Content, FieldError> {
    let transforms = message.list("transforms")?.iter().map(transform);
    Ok(Content::Transforms(transforms.collect::<Result<_, _>>()?))
}

fn transform(item: &Value) -> Result<TransformMessage, FieldError> {
    Ok(TransformMessage {
        stamp_ns: optional_time(item, "header.stamp")?,
        parent: frame(item, "header.frame_id")?,
        child: frame(item, "child_frame_id")?,
        parent_from_child: isometry(item, "transform.translation", "transform.rotation")?,
    })
}

/// `foxglove.FrameTransforms`.
pub fn foxglove_transforms(message: &Value) -> Result<Content, FieldError> {
    let transforms = message.list("transforms")?.iter().map(frame_transform);
    Ok(Content::Transforms(transforms.collect::<Result<_, _>>()?))
}

/// `foxglove.FrameTransform`.
pub fn foxglove_transform(message: &Value) -> Result<Content, FieldError> {
    Ok(Content::Transforms(vec![frame_transform(message)?]))
}

fn frame_transform(item: &Value) -> Result<TransformMessage, FieldError> {
    Ok(TransformMessage {
        stamp_ns: optional_time(item, "timestamp")?,
        parent: frame(item, "parent_frame_id")?,
        child: frame(item, "child_frame_id")?,
        parent_from_child: foxglove_isometry(item, "translation", "rotation")?,
    })
}

/// The pose made of a position and a quaternion; `None` where a number is not finite or the
/// quaternion is zero.
///
/// # Errors
/// A field that is not there.
pub fn isometry(
    message: &Value,
    position: &str,
    orientation: &str,
) -> Result<Option<Isometry3<f64>>, FieldError> {
    let position = vector(message, position)?;
    let orientation = quaternion(message, orientation)?;
    Ok(usable(position, orientation))
}

/// As [`isometry`], with protobuf's way of leaving out what was never set: a part that is absent
/// moves or turns nothing.
///
/// # Errors
/// A field that is not there in a part that is.
pub fn foxglove_isometry(
    message: &Value,
    position: &str,
    orientation: &str,
) -> Result<Option<Isometry3<f64>>, FieldError> {
    let position = match message.get(position) {
        None => Vector3::zeros(),
        Some(_) => vector(message, position)?,
    };
    let orientation = match message.get(orientation) {
        None => Quaternion::identity(),
        Some(_) => quaternion(message, orientation)?,
    };
    Ok(usable(position, orientation))
}

fn vector(message: &Value, path: &str) -> Result<Vector3<f64>, FieldError> {
    let number = |name: &str| message.number(&format!("{path}.{name}"));
    Ok(Vector3::new(number("x")?, number("y")?, number("z")?))
}

fn quaternion(message: &Value, path: &str) -> Result<Quaternion<f64>, FieldError> {
    let number = |name: &str| message.number(&format!("{path}.{name}"));
    Ok(Quaternion::new(
        number("w")?,
        number("x")?,
        number("y")?,
        number("z")?,
    ))
}

/// The turn that a quaternion at a path stands for; `None` where it is zero or not finite.
///
/// # Errors
/// A field that is not there.
pub fn rotation(message: &Value, path: &str) -> Result<Option<UnitQuaternion<f64>>, FieldError> {
    let orientation = quaternion(message, path)?;
    Ok(usable(Vector3::zeros(), orientation).map(|pose| pose.rotation))
}

/// A coordinate beyond this is no place that a robot was at: more than twice round the Earth, metres.
const FARTHEST: f64 = 1e8;

fn usable(position: Vector3<f64>, orientation: Quaternion<f64>) -> Option<Isometry3<f64>> {
    let norm = orientation.norm();
    let usable = position.iter().all(|x| x.abs() <= FARTHEST) && norm.is_finite() && norm > 1e-6;
    usable.then(|| {
        let turn = UnitQuaternion::from_quaternion(orientation);
        Isometry3::from_parts(position.into(), turn)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::json;

    fn odometry_of(read: super::super::Read, text: &str) -> OdometryMessage {
        match read(&json::decode(text.as_bytes()).unwrap()).unwrap() {
            Content::Odometry(odometry) => odometry,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn foxgloves_poses_name_the_robot_or_do_not() {
        let text = r#"{"timestamp":{"sec":1,"nsec":5},"frame_id":"/odom","body_frame_id":"base",
            "pose":{"position":{"x":1,"y":2,"z":0}}}"#;
        let odometry = odometry_of(foxglove_odometry, text);
        assert_eq!(
            (&*odometry.world_frame, &*odometry.robot_frame),
            ("odom", "base")
        );
        assert_eq!(odometry.world_from_robot.unwrap().translation.y, 2.0);
        let pose = odometry_of(foxglove_pose, text);
        assert_eq!(pose.robot_frame, "");
        let empty = odometry_of(foxglove_pose, r#"{"frame_id":"odom"}"#);
        assert_eq!((empty.stamp_ns, empty.world_from_robot), (0, None));
    }

    #[test]
    fn a_quaternion_of_zero_is_no_pose() {
        let text = r#"{"header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"map"},"pose":{
            "position":{"x":1,"y":2,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":0}}}"#;
        assert_eq!(odometry_of(pose, text).world_from_robot, None);
        let turned = text.replace("\"w\":0", "\"w\":3");
        assert!(odometry_of(pose, &turned).world_from_robot.is_some());
    }

    #[test]
    fn ros_poses_come_with_covariance_or_as_transforms() {
        let pose = r#"{"header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"map"},"pose":{"pose":{
            "position":{"x":1,"y":2,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}}}}"#;
        let odometry = odometry_of(pose_with_covariance, pose);
        assert_eq!(odometry.world_from_robot.unwrap().translation.x, 1.0);
        let transform = r#"{"header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"map"},
            "child_frame_id":"/body","transform":{"translation":{"x":1,"y":2,"z":0},
            "rotation":{"x":0,"y":0,"z":0,"w":1}}}"#;
        assert_eq!(
            odometry_of(transform_as_pose, transform).robot_frame,
            "body"
        );
    }
}
