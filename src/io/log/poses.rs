//! Messages that say where a frame is.

use std::borrow::Cow;

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

use super::message::{Content, FARTHEST, NO_TURN, TransformMessage};
use super::value::{Field, FieldError, Fields, Value};

/// `nav_msgs/Odometry`.
pub fn odometry<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [pose @ .., forward, left, turn] = &fields.all::<13>();
    let twist = [forward, left, turn].map(|part| part.value.as_number().filter(|n| n.is_finite()));
    Ok(Content::Odometry(TransformMessage {
        twist: match twist {
            [Some(forward), Some(left), Some(turn)] => Some([forward, left, turn]),
            _ => None,
        },
        ..transform(pose, isometry)?
    }))
}

/// `geometry_msgs/TransformStamped` on a topic of its own.
pub fn transform_stamped<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    transform(&fields.all(), isometry).map(Content::Odometry)
}

/// `geometry_msgs/PoseStamped` and `PoseWithCovarianceStamped`.
pub fn pose<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [stamp, world, pose @ ..] = fields.all::<9>();
    Ok(Content::Odometry(TransformMessage {
        stamp_ns: stamp.time()?,
        parent: world.frame()?,
        parent_from_child: isometry(&pose)?,
        quaternion: as_written(turn_of(&pose)),
        ..TransformMessage::default()
    }))
}

pub fn foxglove_odometry<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [stamp, world, robot, is_there, pose @ ..] = fields.all::<11>();
    let robot_frame = robot.frame()?;
    foxglove_stamped(&stamp, &world, robot_frame, &is_there, &pose)
}

pub fn foxglove_pose<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let [stamp, world, is_there, pose @ ..] = fields.all::<10>();
    foxglove_stamped(&stamp, &world, Cow::Borrowed(""), &is_there, &pose)
}

fn foxglove_stamped<'m>(
    stamp: &Field<'_, 'm>,
    world: &Field<'_, 'm>,
    robot_frame: Cow<'m, str>,
    is_there: &Field<'_, 'm>,
    pose: &[Field<'_, 'm>; 7],
) -> Result<Content<'m>, FieldError> {
    Ok(Content::Odometry(TransformMessage {
        stamp_ns: stamp.time_or_zero()?,
        parent: world.frame()?,
        child: robot_frame,
        parent_from_child: match is_there.is_there() {
            true => foxglove_isometry(pose)?,
            false => None,
        },
        quaternion: as_written(turn_of(pose)),
        twist: None,
    }))
}

/// `tf2_msgs/TFMessage`.
pub fn transforms<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    each(fields, isometry)
}

pub fn foxglove_transforms<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    each(fields, foxglove_isometry)
}

pub fn foxglove_transform<'m>(fields: &Fields<'_, 'm>) -> Result<Content<'m>, FieldError> {
    let transform = transform(&fields.all(), foxglove_isometry)?;
    Ok(Content::Transforms(vec![transform]))
}

type Pose = fn(&[Field<'_, '_>; 7]) -> Result<Option<Isometry3<f64>>, FieldError>;

fn each<'m>(fields: &Fields<'_, 'm>, pose: Pose) -> Result<Content<'m>, FieldError> {
    let columns = fields.all::<10>();
    let [_, parent, ..] = &columns;
    let count = parent.count().ok_or_else(|| parent.missing("a list"))?;
    let row = |row| transform(&columns.each_ref().map(|column| column.at(row)), pose);
    Ok(Content::Transforms(
        (0..count).map(row).collect::<Result<_, _>>()?,
    ))
}

fn transform<'m>(
    fields: &[Field<'_, 'm>; 10],
    pose: Pose,
) -> Result<TransformMessage<'m>, FieldError> {
    let [stamp, parent, child, place @ ..] = fields;
    Ok(TransformMessage {
        stamp_ns: stamp.time_or_zero()?,
        parent: parent.frame()?,
        child: child.frame()?,
        parent_from_child: pose(place)?,
        quaternion: as_written(turn_of(place)),
        twist: None,
    })
}

/// The pose made of a position and a quaternion; `None` where a number is not finite.
///
/// # Errors
/// A field that is not there.
fn isometry(pose: &[Field<'_, '_>; 7]) -> Result<Option<Isometry3<f64>>, FieldError> {
    let [x, y, z, turn @ ..] = pose;
    let position = Vector3::new(x.number()?, y.number()?, z.number()?);
    Ok(rotation(turn)?.and_then(|turn| placed(position, turn)))
}

/// As [`isometry`], with protobuf's way of leaving out what was never set: a part that is absent moves or
/// turns nothing.
///
/// # Errors
/// A field that is not there in a part that is.
pub fn foxglove_isometry(pose: &[Field<'_, '_>; 7]) -> Result<Option<Isometry3<f64>>, FieldError> {
    let mut pose = pose.clone();
    let (place, turn) = pose.split_at_mut(3);
    for (part, default) in [(place, &[0.0, 0.0, 0.0][..]), (turn, &[0.0, 0.0, 0.0, 1.0])] {
        if !part.iter().any(Field::is_there) {
            for (field, default) in part.iter_mut().zip(default) {
                field.value = Cow::Owned(Value::Float(*default));
            }
        }
    }
    isometry(&pose)
}

/// A pose, if a robot can be there.
pub fn placed(position: Vector3<f64>, turn: UnitQuaternion<f64>) -> Option<Isometry3<f64>> {
    let is_place = position.iter().all(|x| x.abs() <= FARTHEST);
    is_place.then(|| Isometry3::from_parts(position.into(), turn))
}

pub fn turn_of<'p, 'f, 'm>([_, _, _, turn @ ..]: &'p [Field<'f, 'm>; 7]) -> &'p [Field<'f, 'm>; 4] {
    turn
}

/// A quaternion (x, y, z, w) of whatever length; `None` where it is not there.
pub fn as_written(turn: &[Field<'_, '_>; 4]) -> Option<[f64; 4]> {
    let [x, y, z, w] = turn.each_ref().map(|part| part.value.as_number());
    Some([x?, y?, z?, w?])
}

/// The turn that a quaternion (x, y, z, w) stands for; `None` where it is not finite. One that is zero was never set:
/// none, which [`TransformMessage::is_unturned`] tells.
///
/// # Errors
/// A field that is not there.
pub fn rotation(
    [x, y, z, w]: &[Field<'_, '_>; 4],
) -> Result<Option<UnitQuaternion<f64>>, FieldError> {
    let orientation = Quaternion::new(w.number()?, x.number()?, y.number()?, z.number()?);
    let norm = orientation.norm();
    Ok(norm.is_finite().then(|| match norm > NO_TURN {
        true => UnitQuaternion::from_quaternion(orientation),
        false => UnitQuaternion::identity(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::types::read_json;

    fn odometry_of(name: &str, text: &str) -> TransformMessage<'static> {
        match read_json(name, text).unwrap() {
            Content::Odometry(odometry) => odometry,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn foxgloves_poses_name_the_robot_or_do_not() {
        let text = r#"{"timestamp":{"sec":1,"nsec":5},"frame_id":"/odom","body_frame_id":"base",
            "pose":{"position":{"x":1,"y":2,"z":0}}}"#;
        let odometry = odometry_of("foxglove.Odometry", text);
        let frames = (&*odometry.parent, &*odometry.child);
        assert_eq!(frames, ("odom", "base"));
        assert_eq!(odometry.parent_from_child.unwrap().translation.y, 2.0);
        let pose = odometry_of("foxglove.PoseInFrame", text);
        assert_eq!(pose.child, "");
        let empty = odometry_of("foxglove.PoseInFrame", r#"{"frame_id":"odom"}"#);
        assert_eq!((empty.stamp_ns, empty.parent_from_child), (0, None));
    }

    #[test]
    fn a_quaternion_of_zero_is_no_turn_and_is_told() {
        let text = r#"{"header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"map"},"pose":{
            "position":{"x":1,"y":2,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":0}}}"#;
        let read = |text: &str| odometry_of("geometry_msgs/PoseStamped", text);
        let unturned = read(text);
        assert!(unturned.is_unturned());
        let pose = unturned.parent_from_child.unwrap();
        assert_eq!((pose.translation.y, pose.rotation.angle()), (2.0, 0.0));
        let turned = text.replace("\"w\":0", "\"w\":3");
        assert!(!read(&turned).is_unturned() && read(&turned).parent_from_child.is_some());
        let far = read(&turned.replace("\"x\":1", "\"x\":1e9"));
        assert_eq!(far.parent_from_child, None);
    }

    #[test]
    fn ros_poses_come_with_covariance_or_as_transforms() {
        let pose = r#"{"header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"map"},"pose":{"pose":{
            "position":{"x":1,"y":2,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}}}}"#;
        let odometry = odometry_of("geometry_msgs/PoseWithCovarianceStamped", pose);
        assert_eq!(odometry.parent_from_child.unwrap().translation.x, 1.0);
        let transform = r#"{"header":{"stamp":{"sec":1,"nanosec":0},"frame_id":"map"},
            "child_frame_id":"/body","transform":{"translation":{"x":1,"y":2,"z":0},
            "rotation":{"x":0,"y":0,"z":0,"w":1}}}"#;
        let odometry = odometry_of("geometry_msgs/TransformStamped", transform);
        assert_eq!(odometry.child, "body");
    }

    #[test]
    fn each_transform_of_a_message_is_one() {
        let text = r#"{"transforms":[{"parent_frame_id":"a","child_frame_id":"b",
            "translation":{"x":1,"y":0,"z":0}},{"parent_frame_id":"b","child_frame_id":"c"}]}"#;
        let Content::Transforms(found) = read_json("foxglove.FrameTransforms", text).unwrap()
        else {
            panic!()
        };
        let [one, other] = found.as_slice() else {
            panic!()
        };
        assert_eq!(one.parent_from_child.unwrap().translation.x, 1.0);
        assert_eq!((&*other.parent, &*other.child), ("b", "c"));
        assert!(read_json("foxglove.FrameTransforms", "{}").is_err());
    }
}
