//! How far odometry is off from key pose to key pose.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Matrix3x2, Rotation2, Vector2, Vector3};

use super::key_pose::{Between, KeyPose, between};
use crate::core::geometry::{Pose2, Vec2, direction, unit, wrap_angle};

/// What no odometry is better than between two key poses: metres and radians.
const FLOOR: f64 = 1e-4;
const FLOOR_ANGLE: f64 = 1e-4;

/// The noise is changed by at most this factor in one step.
const LARGEST_STEP: f64 = 10.0;

/// Noise of odometry: random walks, so that deviations grow with the square root.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Drift {
    /// Standard deviation of the distance after a metre, metres.
    pub distance: f64,
    /// Standard deviation of the heading after a metre, radians.
    pub heading: f64,
    /// Standard deviation of the heading after turning by a radian, radians.
    pub turn: f64,
}

impl Drift {
    /// None at all.
    pub const NONE: Self = Self {
        distance: 0.0,
        heading: 0.0,
        turn: 0.0,
    };

    /// Whether it is more than noise: half a metre or half a radian after a metre, or half a radian after a
    /// radian.
    pub fn is_implausible(&self) -> bool {
        [self.distance, self.heading, self.turn]
            .iter()
            .any(|noise| *noise > 0.5)
    }

    /// Variance of a range along a bearing in the frame of odometry, square metres, by where the robot was between
    /// two key poses that are known: a random walk whose ends are fixed (a Brownian bridge).
    pub fn between_key_poses(&self, keys: &[KeyPose], stamp_ns: i64, bearing: f64) -> f64 {
        let Between { earlier, share } = between(keys, stamp_ns);
        let (Some(from), Some(to)) = (keys.get(earlier), keys.get(earlier + 1)) else {
            return 0.0;
        };
        let way = to.odom_from_robot.position() - from.odom_from_robot.position();
        let along = way
            .try_normalize(0.0)
            .map_or(0.0, |way| way.dot(&unit(bearing)));
        let distance = self.distance * along;
        distance * distance * to.driven * share * (1.0 - share)
    }

    /// From here to `other` and as often on as `stride` says, in logarithms.
    pub fn towards(&self, other: &Self, stride: f64) -> Self {
        let step = |now: f64, then: f64| {
            let factor = libm::pow(then / now, stride);
            if factor.is_finite() {
                now * factor.clamp(1.0 / LARGEST_STEP, LARGEST_STEP)
            } else {
                now
            }
        };
        Self {
            distance: step(self.distance, other.distance),
            heading: step(self.heading, other.heading),
            turn: step(self.turn, other.turn),
        }
    }
}

/// The way from one key pose to the next one as odometry has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Increment {
    /// The later pose in the frame of the earlier one.
    pub earlier_from_later: Pose2,
    /// Driven, metres.
    pub driven: f64,
    /// Turned, radians, either way.
    pub turned: f64,
}

impl Increment {
    /// Between two neighbours.
    pub fn between(earlier: &KeyPose, later: &KeyPose) -> Self {
        Self {
            earlier_from_later: relative(&earlier.odom_from_robot, &later.odom_from_robot),
            driven: later.driven,
            turned: later.turned,
        }
    }

    /// The direction of travel in the frame of the earlier pose.
    fn forward(&self) -> Rotation2<f64> {
        let forward = direction(self.earlier_from_later.position());
        let forward = unit(forward);
        Rotation2::from_matrix_unchecked(nalgebra::Matrix2::new(
            forward.x, -forward.y, forward.y, forward.x,
        ))
    }

    /// Its covariance over (x, y, yaw) in the frame of the earlier pose. A heading that swings on the way
    /// carries the later pose aside.
    pub fn covariance(&self, drift: &Drift) -> Matrix3<f64> {
        let way = self.driven;
        let heading = self.heading_variance(drift);
        let along = drift.distance * drift.distance * way + FLOOR * FLOOR;
        let aside = heading * way * way / 3.0 + FLOOR * FLOOR;
        let both = heading * way / 2.0;
        let mut turned = Matrix3::zeros();
        turned
            .fixed_view_mut::<2, 2>(0, 0)
            .copy_from(self.forward().matrix());
        turned.m33 = 1.0;
        let here = Matrix3::new(
            along, 0.0, 0.0, //
            0.0, aside, both, //
            0.0, both, heading,
        );
        turned * here * turned.transpose()
    }

    fn heading_variance(&self, drift: &Drift) -> f64 {
        let [way, turn] = self.heading_variances(drift);
        way + turn + FLOOR_ANGLE * FLOOR_ANGLE
    }

    fn heading_variances(&self, drift: &Drift) -> [f64; 2] {
        [
            drift.heading * drift.heading * self.driven,
            drift.turn * drift.turn * self.turned,
        ]
    }

    /// How far the estimate is off odometry that is to be stretched by `scales` of distance and rotation,
    /// over (x, y, yaw) in the frame of the earlier pose.
    pub fn residual(&self, earlier: &Pose2, later: &Pose2, scales: &Vector2<f64>) -> Vector3<f64> {
        let estimated = relative(earlier, later);
        let odometry = &self.earlier_from_later;
        let way: Vec2 = estimated.position() - odometry.position() * (1.0 + scales.x);
        let turn = wrap_angle(estimated.yaw - odometry.yaw) - odometry.yaw * scales.y;
        Vector3::new(way.x, way.y, turn)
    }

    /// The derivatives of the residual by the two poses over (x, y, yaw) in the world.
    pub fn by_poses(&self, earlier: &Pose2, later: &Pose2) -> [Matrix3<f64>; 2] {
        let (x, y) = (unit(earlier.yaw), unit(earlier.yaw + FRAC_PI_2));
        let way = relative(earlier, later);
        [
            Matrix3::new(
                -x.x, -x.y, way.y, //
                -y.x, -y.y, -way.x, //
                0.0, 0.0, -1.0,
            ),
            Matrix3::new(
                x.x, x.y, 0.0, //
                y.x, y.y, 0.0, //
                0.0, 0.0, 1.0,
            ),
        ]
    }

    /// The derivatives of the residual by the scales of distance and rotation.
    pub fn by_scales(&self) -> Matrix3x2<f64> {
        let odometry = &self.earlier_from_later;
        Matrix3x2::new(-odometry.x, 0.0, -odometry.y, 0.0, 0.0, -odometry.yaw)
    }
}

/// `a_from_b` of two poses in one frame.
fn relative(frame_from_a: &Pose2, frame_from_b: &Pose2) -> Pose2 {
    frame_from_a.inverse().compose(frame_from_b)
}

/// Learns the noise from what an estimate leaves of the increments: expectation maximisation.
#[derive(Debug, Clone, Default)]
pub struct DriftEstimator {
    distance: (f64, f64),
    heading: (f64, f64),
    turn: (f64, f64),
}

impl DriftEstimator {
    /// Takes the residual of an increment and the covariance of the estimate of it, both over (x, y, yaw)
    /// in the frame of the earlier pose.
    pub fn push(
        &mut self,
        increment: &Increment,
        residual: Vector3<f64>,
        covariance: &Matrix3<f64>,
        drift: &Drift,
    ) {
        let expected = residual * residual.transpose() + covariance;
        let forward = increment.forward() * Vector2::x();
        let along = forward.dot(&(expected.fixed_view::<2, 2>(0, 0) * forward));
        if increment.driven > 0.0 {
            self.distance.0 += (along - FLOOR * FLOOR).max(0.0);
            self.distance.1 += increment.driven;
        }
        // Of what the heading is off, the parts that come from the way and from the turn.
        let all = increment.heading_variance(drift);
        let [way, turn] = increment.heading_variances(drift).map(|part| {
            let share = part / all;
            part * (1.0 - share) + share * share * expected.m33
        });
        self.heading.0 += way;
        self.heading.1 += increment.driven;
        self.turn.0 += turn;
        self.turn.1 += increment.turned;
    }

    /// The noise; what nothing tells of stays as it is.
    pub fn drift(&self, now: &Drift) -> Drift {
        let of = |(sum, weight): (f64, f64), now: f64| {
            if weight > 0.0 {
                (sum / weight).sqrt()
            } else {
                now
            }
        };
        Drift {
            distance: of(self.distance, now.distance),
            heading: of(self.heading, now.heading),
            turn: of(self.turn, now.turn),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_derivatives_are_those_of_the_residual(
            x in -5.0..5.0, y in -5.0..5.0, a in -3.0..3.0, dx in -0.3..0.3, dy in -0.3..0.3, da in -0.5..0.5,
        ) {
            const STEP: f64 = 1e-6;
            let (earlier, later) = (Pose2::new(x, y, a), Pose2::new(x + dx, y + dy, a + da));
            let increment = Increment {
                earlier_from_later: Pose2::new(0.1, 0.02, 0.1),
                driven: 0.11,
                turned: 0.1,
            };
            let scales = Vector2::new(0.01, -0.02);
            let moved = |pose: &Pose2, step: Vector3<f64>| {
                Pose2::new(pose.x + step.x, pose.y + step.y, pose.yaw + step.z)
            };
            let [by_earlier, by_later] = increment.by_poses(&earlier, &later);
            for axis in 0..3 {
                let step = Vector3::ith(axis, STEP);
                let of = |a: Vector3<f64>, b: Vector3<f64>| {
                    increment.residual(&moved(&earlier, a), &moved(&later, b), &scales)
                };
                let none = Vector3::zeros();
                let found = (of(step, none) - of(-step, none)) / (2.0 * STEP);
                prop_assert!((found - by_earlier.column(axis)).norm() < 1e-6);
                let found = (of(none, step) - of(none, -step)) / (2.0 * STEP);
                prop_assert!((found - by_later.column(axis)).norm() < 1e-6);
            }
            for axis in 0..2 {
                let step = Vector2::ith(axis, STEP);
                let of = |scales| increment.residual(&earlier, &later, &scales);
                let found = (of(scales + step) - of(scales - step)) / (2.0 * STEP);
                prop_assert!((found - increment.by_scales().column(axis)).norm() < 1e-6);
            }
        }
    }

    #[test]
    fn between_key_poses_the_robot_is_least_known_half_way_and_along_its_way() {
        let key = |stamp_ns, x, driven| KeyPose {
            stamp_ns,
            odom_from_robot: Pose2::new(x, 0.0, 0.0),
            driven,
            turned: 0.0,
        };
        let keys = [key(0, 0.0, 0.0), key(100, 0.1, 0.1)];
        let drift = Drift {
            distance: 0.03,
            ..Drift::NONE
        };
        let sigma =
            |stamp_ns, bearing| libm::sqrt(drift.between_key_poses(&keys, stamp_ns, bearing));
        assert_eq!([sigma(0, 0.0), sigma(100, 0.0)], [0.0, 0.0]);
        // Half of what a random walk of 10 cm is off at its end.
        assert!((sigma(50, 0.0) - 0.03 * libm::sqrt(0.1) / 2.0).abs() < 1e-12);
        assert!(sigma(20, 0.0) < sigma(50, 0.0));
        assert!(sigma(50, FRAC_PI_2) < 1e-12);
    }

    #[test]
    fn a_heading_that_swings_carries_the_robot_aside() {
        let increment = Increment {
            earlier_from_later: Pose2::new(0.0, 1.0, 0.0),
            driven: 1.0,
            turned: 0.0,
        };
        let drift = Drift {
            distance: 0.01,
            heading: 0.06,
            turn: 0.0,
        };
        let covariance = increment.covariance(&drift);
        // It drives along y, so that aside is x.
        assert!((covariance.m22.sqrt() - 0.01).abs() < 1e-4, "{covariance}");
        assert!((covariance.m33.sqrt() - 0.06).abs() < 1e-4, "{covariance}");
        assert!((covariance.m11.sqrt() - 0.06 / 3.0_f64.sqrt()).abs() < 1e-3);
        assert!(covariance.m13 < 0.0, "a turn to the left carries it to -x");
    }
}
