//! The robot's description (URDF): where its fixed joints put the sensors.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use urdf_rs::JointType;

use super::message::TransformMessage;

/// Elements nested deeper than this are no robot's: the parser would run out of stack.
const DEEPEST: usize = 200;

/// Why a description is of no use.
#[derive(Debug, thiserror::Error)]
pub enum DescriptionError {
    /// Beyond any use.
    #[error("its elements are nested more than {DEEPEST} deep")]
    TooDeep,
    /// Not a description.
    #[error("{0}")]
    Urdf(#[from] urdf_rs::UrdfError),
}

/// The transforms of all fixed joints. Where the others stand is not in the description.
///
/// # Errors
/// Text that is no URDF.
pub fn fixed_joints(urdf: &str) -> Result<Vec<TransformMessage>, DescriptionError> {
    if deepest(urdf) > DEEPEST {
        return Err(DescriptionError::TooDeep);
    }
    let robot = urdf_rs::read_from_string(urdf)?;
    let fixed = robot
        .joints
        .into_iter()
        .filter(|joint| matches!(joint.joint_type, JointType::Fixed));
    Ok(fixed
        .map(|joint| {
            let ([x, y, z], [roll, pitch, yaw]) = (*joint.origin.xyz, *joint.origin.rpy);
            let is_finite = [x, y, z, roll, pitch, yaw].iter().all(|n| n.is_finite());
            TransformMessage {
                stamp_ns: 0,
                parent: joint.parent.link,
                child: joint.child.link,
                parent_from_child: is_finite.then(|| {
                    Isometry3::from_parts(
                        Translation3::new(x, y, z),
                        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
                    )
                }),
            }
        })
        .collect())
}

/// How deep elements are nested; comments count as if they were none.
fn deepest(xml: &str) -> usize {
    let (mut depth, mut deepest) = (0_usize, 0);
    for tag in xml.split('<').skip(1) {
        match tag.chars().next() {
            Some('/') => depth = depth.saturating_sub(1),
            Some('!' | '?') => {}
            _ if tag.split('>').next().is_some_and(|t| t.ends_with('/')) => {}
            _ => depth += 1,
        }
        deepest = deepest.max(depth);
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_joints_are_transforms() {
        let urdf = r#"<?xml version="1.0"?><robot name="r"><!-- a <comment> -->
            <link name="base_link"/><link name="sonar"><visual><geometry><box size="1 1 1"/>
            </geometry></visual></link><link name="wheel"/>
            <joint name="mount" type="fixed"><origin xyz="0.1 0.2 0.3" rpy="0 0 1.5"/>
              <parent link="base_link"/><child link="sonar"/></joint>
            <joint name="axle" type="continuous"><parent link="base_link"/><child link="wheel"/>
              <axis xyz="0 1 0"/></joint></robot>"#;
        let joints = fixed_joints(urdf).unwrap();
        let [mount] = joints.as_slice() else { panic!() };
        assert_eq!((&*mount.parent, &*mount.child), ("base_link", "sonar"));
        let pose = mount.parent_from_child.unwrap();
        assert_eq!(pose.translation.y, 0.2);
        assert!((pose.rotation.euler_angles().2 - 1.5).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_description_is_refused() {
        for text in ["", "hello", "<robot>", "<robot name='r'><joint/></robot>"] {
            assert!(fixed_joints(text).is_err(), "{text}");
        }
        let deep = "<a>".repeat(1_000_000);
        assert!(fixed_joints(&deep).unwrap_err().to_string().contains("200"));
    }
}
