//! Poses whose z axis does not point up, and headings that are not counted counter-clockwise from x.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Unit, UnitQuaternion, Vector3};

use crate::core::config::channel::{ChannelFields, Heading, Up};

/// What is done to the poses of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Axes {
    up: Option<Up>,
    heading: Option<Heading>,
}

impl Axes {
    pub fn of(described: &ChannelFields) -> Self {
        Self {
            up: described.up,
            heading: described.heading,
        }
    }

    /// The pose with z up and its heading counted counter-clockwise from x.
    pub fn lay(self, pose: &mut Isometry3<f64>) {
        let about_x = |angle| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle);
        let laid = match self.up {
            None | Some(Up::Z) => None,
            Some(Up::Y) => Some((about_x(FRAC_PI_2), about_x(FRAC_PI_2))),
            Some(Up::MinusY) => {
                let thirds = Unit::new_normalize(Vector3::new(-1.0, 1.0, -1.0));
                let laid = UnitQuaternion::from_axis_angle(&thirds, 2.0 * PI / 3.0);
                Some((laid, laid))
            }
            Some(Up::MinusZ) => {
                let north_east = Unit::new_normalize(Vector3::new(1.0, 1.0, 0.0));
                let world = UnitQuaternion::from_axis_angle(&north_east, PI);
                Some((world, about_x(PI)))
            }
        };
        if let Some((world, robot)) = laid {
            *pose = world * *pose;
            // The robot's own axes may be laid so, too.
            let as_robot = pose.rotation * robot.inverse();
            let up = |turn: UnitQuaternion<f64>| (turn * Vector3::z()).z;
            if up(as_robot) > up(pose.rotation) {
                pose.rotation = as_robot;
            }
        }
        let from = match self.heading {
            None | Some(Heading::Counterclockwise) => return,
            Some(Heading::Clockwise) => 0.0,
            Some(Heading::Compass) => FRAC_PI_2,
        };
        let forward = pose.rotation * Vector3::x();
        let yaw = from - libm::atan2(forward.y, forward.x);
        pose.rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid(up: Option<Up>, heading: Option<Heading>, turn: UnitQuaternion<f64>) -> [f64; 4] {
        let mut pose = Isometry3::from_parts(Vector3::new(1.0, 2.0, 3.0).into(), turn);
        Axes { up, heading }.lay(&mut pose);
        let forward = pose.rotation * Vector3::x();
        let [x, y, z] = pose.translation.vector.into();
        [x, y, z, libm::atan2(forward.y, forward.x).to_degrees()]
    }

    fn about(axis: Vector3<f64>, degrees: f64) -> UnitQuaternion<f64> {
        let axis = Unit::new_normalize(axis);
        UnitQuaternion::from_axis_angle(&axis, degrees.to_radians())
    }

    fn near(found: [f64; 4], expected: [f64; 4]) {
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{found:?} {expected:?}");
    }

    #[test]
    fn y_up_becomes_z_up_whichever_axes_the_robot_has() {
        let robot_y_up = about(Vector3::y(), 30.0);
        near(laid(Some(Up::Y), None, robot_y_up), [1.0, -3.0, 2.0, 30.0]);
        let robot_z_up = about(Vector3::x(), -90.0) * about(Vector3::z(), 30.0);
        near(laid(Some(Up::Y), None, robot_z_up), [1.0, -3.0, 2.0, 30.0]);
    }

    #[test]
    fn what_a_camera_says_of_itself() {
        // It looks along z, and turned to the left about -y.
        let turn = about(Vector3::y(), -30.0);
        near(laid(Some(Up::MinusY), None, turn), [3.0, -1.0, -2.0, 30.0]);
    }

    #[test]
    fn north_east_down_becomes_east_north_up() {
        let turn = about(Vector3::z(), 30.0);
        near(laid(Some(Up::MinusZ), None, turn), [2.0, 1.0, -3.0, 60.0]);
    }

    #[test]
    fn headings_of_a_compass() {
        let turn = about(Vector3::z(), 30.0);
        let compass = Some(Heading::Compass);
        near(laid(None, compass, turn), [1.0, 2.0, 3.0, 60.0]);
        near(
            laid(None, Some(Heading::Clockwise), turn),
            [1.0, 2.0, 3.0, -30.0],
        );
        near(laid(None, None, turn), [1.0, 2.0, 3.0, 30.0]);
    }
}
