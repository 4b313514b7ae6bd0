//! Where a sonar sits.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::{Named, Placing, mount_of};
use crate::core::geometry::Pose2;
use crate::io::log::transforms::{Mount, NoMount};
use crate::io::log::{LogError, MissingMount};

impl Placing<'_> {
    pub(super) fn mount(&self, sonar: &Named<'_>, robot_frame: &str) -> Result<Mount, LogError> {
        let source = sonar.source;
        let found = match (mount_of(&sonar.known), sonar.frame_mount) {
            (Some(robot_from_sensor), _) => Ok(Mount {
                robot_from_sensor,
                tilt: None,
                moved: false,
            }),
            (None, Some(robot_from_frame)) => {
                Mount::projected(&(in_space(robot_from_frame) * source.frame_from_beam))
            }
            (None, None) if sonar.ring.has_mount() => self
                .transforms
                .mount(robot_frame, &source.key.frame, &Isometry3::identity())
                .and_then(|frame| {
                    let robot_from_frame = frame.overridden(&sonar.ring).robot_from_sensor;
                    Mount::projected(&(in_space(robot_from_frame) * source.frame_from_beam))
                }),
            (None, None) => {
                self.transforms
                    .mount(robot_frame, &source.key.frame, &source.frame_from_beam)
            }
        };
        let found = found.map(|mount| mount.overridden(&sonar.known));
        found.map_err(|why| {
            LogError::NoMount(Box::new(MissingMount {
                sonar: sonar.name.clone(),
                topic: source.key.topic.clone(),
                frame: source.key.frame.clone(),
                robot_frame: robot_frame.to_owned(),
                why: self.explain(why, &source.key.frame, robot_frame),
                frames: self
                    .transforms
                    .frames()
                    .into_iter()
                    .map(Into::into)
                    .collect(),
            }))
        })
    }

    fn explain(&self, why: NoMount, frame: &str, robot_frame: &str) -> String {
        match why {
            NoMount::Unconnected if frame.is_empty() => "its messages name no frame".to_owned(),
            NoMount::Unconnected if self.transforms.is_unusable(frame) => {
                format!("the transform of `{frame}` holds no pose (NaN, or a quaternion of zero)")
            }
            NoMount::Unconnected => format!("no transform joins it to `{robot_frame}`"),
            NoMount::Vertical => "its beam points straight up or down".to_owned(),
        }
    }
}

fn in_space(pose: Pose2) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.yaw);
    Isometry3::from_parts([pose.x, pose.y, 0.0].into(), turn)
}
