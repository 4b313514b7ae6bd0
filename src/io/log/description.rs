//! The robot's description (URDF): where its fixed joints put the sensors.

use nalgebra::UnitQuaternion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::message::TransformMessage;
use super::poses::placed;
use crate::core::legible::name;

/// Why a description is of no use.
#[derive(Debug, thiserror::Error)]
pub enum DescriptionError {
    #[error("it is no XML: {0}")]
    Xml(#[from] quick_xml::Error),
    #[error("it is no XML: {0}")]
    Attribute(#[from] quick_xml::events::attributes::AttrError),
    #[error("it ends early")]
    Early,
    #[error("it has no element <robot> around all others")]
    NoRobot,
    #[error(
        "a fixed joint lacks its parent or its child, or its origin is not of three numbers each"
    )]
    Joint,
}

#[derive(Default)]
struct Joint {
    parent: Option<String>,
    child: Option<String>,
    xyz: [f64; 3],
    rpy: [f64; 3],
}

/// The transforms of all fixed joints. Where the others stand is not in the description.
///
/// # Errors
/// Text that is no URDF.
pub fn fixed_joints(urdf: &str) -> Result<Vec<TransformMessage<'static>>, DescriptionError> {
    let mut reader = Reader::from_str(urdf);
    let (mut depth, mut is_robot) = (0_usize, false);
    let mut fixed: Option<Joint> = None;
    let mut joints = Vec::new();
    loop {
        let event = reader.read_event()?;
        match &event {
            Event::Start(tag) | Event::Empty(tag) => match (depth, tag.name().as_ref()) {
                (0, b"robot") => is_robot = true,
                (0, _) => return Err(DescriptionError::NoRobot),
                (1, b"joint") => {
                    let is_fixed = attribute(tag, "type")?.as_deref() == Some("fixed");
                    fixed = is_fixed.then(Joint::default);
                }
                (2, _) => {
                    if let Some(joint) = &mut fixed {
                        joint.take(tag)?;
                    }
                }
                _ => {}
            },
            _ => {}
        }
        match event {
            Event::Start(_) => depth += 1,
            Event::End(_) => depth = depth.saturating_sub(1),
            Event::Eof if depth > 0 => return Err(DescriptionError::Early),
            Event::Eof if is_robot => return Ok(joints),
            Event::Eof => return Err(DescriptionError::NoRobot),
            _ => {}
        }
        if depth < 2
            && let Some(joint) = fixed.take()
        {
            joints.push(joint.transform().ok_or(DescriptionError::Joint)?);
        }
    }
}

impl Joint {
    fn take(&mut self, tag: &BytesStart<'_>) -> Result<(), DescriptionError> {
        match tag.name().as_ref() {
            b"parent" => self.parent = attribute(tag, "link")?,
            b"child" => self.child = attribute(tag, "link")?,
            b"origin" => {
                for (key, place) in [("xyz", &mut self.xyz), ("rpy", &mut self.rpy)] {
                    if let Some(text) = attribute(tag, key)? {
                        let numbers = text.split_whitespace().map(str::parse);
                        let numbers: Result<Vec<f64>, _> = numbers.collect();
                        let three = numbers.ok().and_then(|numbers| numbers.try_into().ok());
                        *place = three.ok_or(DescriptionError::Joint)?;
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn transform(self) -> Option<TransformMessage<'static>> {
        let [roll, pitch, yaw] = self.rpy;
        let is_turn = self.rpy.iter().all(|n| n.is_finite());
        let turn = is_turn.then(|| UnitQuaternion::from_euler_angles(roll, pitch, yaw));
        let pose = turn.and_then(|turn| placed(self.xyz.into(), turn));
        Some(TransformMessage {
            parent: name(&self.parent?).into_owned().into(),
            child: name(&self.child?).into_owned().into(),
            parent_from_child: pose,
            ..TransformMessage::default()
        })
    }
}

fn attribute(tag: &BytesStart<'_>, key: &str) -> Result<Option<String>, DescriptionError> {
    let attribute = tag.try_get_attribute(key)?;
    let text = attribute.map(|attribute| attribute.unescape_value().map(Into::into));
    Ok(text.transpose()?)
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
    fn a_joint_beyond_the_earth_holds_no_pose() {
        let joint = |x: &str| {
            let urdf = format!(
                r#"<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">
                <origin xyz="{x} 0 0"/><parent link="a"/><child link="b"/></joint></robot>"#
            );
            fixed_joints(&urdf).unwrap().remove(0).parent_from_child
        };
        assert!(joint("1e3").is_some());
        assert_eq!(joint("1e308"), None);
    }

    #[test]
    fn what_is_no_description_is_refused() {
        let joint = "<robot name='r'><joint type='fixed'/></robot>";
        for text in ["", "hello", "<robot>", "<robot></a>", "<a/>", joint] {
            assert!(fixed_joints(text).is_err(), "{text}");
        }
        let deep = "<a>".repeat(1_000_000);
        assert!(fixed_joints(&deep).is_err());
        let deep = format!("<robot>{deep}{}</robot>", "</a>".repeat(1_000_000));
        assert!(fixed_joints(&deep).unwrap().is_empty());
    }
}
