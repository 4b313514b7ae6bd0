//! Plane geometry: points, poses and angles.
//!
//! Metres and radians; axes as REP-103 (x forward, y left, yaw counter-clockwise). Transcendental
//! functions come from `libm`, so that a log gives the same bytes on every platform.

use std::f64::consts::{PI, TAU};

/// A point or a direction in the plane, metres.
pub type Vec2 = nalgebra::Vector2<f64>;

/// A pose in the plane, named `target_from_source`: it takes coordinates in the source frame to
/// the target frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose2 {
    /// Origin of the source frame in the target frame, metres.
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// Heading of the source frame's x axis in the target frame, radians.
    pub yaw: f64,
}

impl Pose2 {
    /// The pose that changes nothing.
    pub const IDENTITY: Self = Self {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
    };

    /// A pose from its origin (metres) and heading (radians, any turn).
    pub fn new(x: f64, y: f64, yaw: f64) -> Self {
        Self {
            x,
            y,
            yaw: wrap_angle(yaw),
        }
    }

    /// The origin of the source frame, in the target frame.
    pub fn position(&self) -> Vec2 {
        Vec2::new(self.x, self.y)
    }

    /// `a_from_c = a_from_b.compose(&b_from_c)`.
    pub fn compose(&self, other: &Self) -> Self {
        let p = self.transform(other.position());
        Self::new(p.x, p.y, self.yaw + other.yaw)
    }

    /// `b_from_a`, where this is `a_from_b`.
    pub fn inverse(&self) -> Self {
        let p = self.inverse_transform(Vec2::zeros());
        Self::new(p.x, p.y, -self.yaw)
    }

    /// A point in the source frame, expressed in the target frame.
    pub fn transform(&self, point: Vec2) -> Vec2 {
        self.position() + rotate(point, self.yaw)
    }

    /// A point in the target frame, expressed in the source frame.
    pub fn inverse_transform(&self, point: Vec2) -> Vec2 {
        rotate(point - self.position(), -self.yaw)
    }
}

/// The unit vector at `angle` from the x axis.
pub fn unit(angle: f64) -> Vec2 {
    let (sin, cos) = libm::sincos(angle);
    Vec2::new(cos, sin)
}

/// The angle of `v` from the x axis, in (-pi, pi]; zero for the zero vector.
pub fn direction(v: Vec2) -> f64 {
    wrap_angle(libm::atan2(v.y, v.x))
}

/// `v` turned counter-clockwise by `angle`.
pub fn rotate(v: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = libm::sincos(angle);
    Vec2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y)
}

/// The same angle in (-pi, pi]; an angle already there is returned unchanged.
pub fn wrap_angle(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let wrapped = angle - TAU * libm::round(angle / TAU);
    if wrapped <= -PI {
        wrapped + TAU
    } else {
        wrapped
    }
}

/// How far two angles lie apart on the circle, in [0, pi].
pub fn angle_between(a: f64, b: f64) -> f64 {
    wrap_angle(a - b).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn wrapped_angles_are_in_range_and_equal_modulo_a_turn(a in -1e4..1e4) {
            let w = wrap_angle(a);
            prop_assert!(w > -PI && w <= PI);
            prop_assert!((unit(a) - unit(w)).norm() < 1e-9);
            prop_assert_eq!(wrap_angle(w), w);
        }

        #[test]
        fn a_pose_undoes_itself(x in -9.0..9.0, y in -9.0..9.0, yaw in -4.0..4.0, px in -9.0..9.0, py in -9.0..9.0) {
            let pose = Pose2::new(x, y, yaw);
            let p = Vec2::new(px, py);
            prop_assert!((pose.inverse_transform(pose.transform(p)) - p).norm() < 1e-12);
        }

        #[test]
        fn composition_transforms_in_turn(a in -4.0..4.0, b in -4.0..4.0, x in -9.0..9.0, y in -9.0..9.0) {
            let (one, two) = (Pose2::new(x, y, a), Pose2::new(y, -x, b));
            let p = Vec2::new(1.0, 2.0);
            prop_assert!((one.compose(&two).transform(p) - one.transform(two.transform(p))).norm() < 1e-12);
        }
    }

    #[test]
    fn the_half_turn_is_positive() {
        assert_eq!(wrap_angle(-PI), PI);
        assert_eq!(wrap_angle(3.0 * PI), PI);
    }
}
