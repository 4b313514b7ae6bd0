//! What a log says besides readings and poses in the plane, for those who hold it against physics.

use super::message::{TransformMessage, norm};
use crate::core::event::OdometrySample;
use crate::core::geometry::{Pose2, Vec2, angle_between, wrap_angle};

/// What a log says besides readings and poses in the plane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Traits {
    pub poses: PoseTraits,
    /// Of each sonar, in the order of [`Events::sonars`](crate::core::event::Events::sonars).
    pub mounts: Vec<MountTraits>,
    /// Frames whose transforms have a quaternion of zero and are taken for not turned.
    pub unturned: Vec<String>,
    /// Frame that the odometry is in; may be empty.
    pub world_frame: String,
    /// Frame that the odometry moves; may be empty.
    pub robot_frame: String,
}

/// Where a sonar's mount comes from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MountTraits {
    pub frame: String,
    /// Whether its messages say that it measures with light.
    pub infrared: bool,
    /// Whether the angles of its scans were in degrees.
    pub in_degrees: bool,
    /// Whether transforms on the way to it move.
    pub moved: bool,
    /// Whether its frame has y pointing down, as the frames of cameras have.
    pub is_optical: bool,
    /// Where it would be by what else is said of a frame on the way to it.
    pub contradicted: Option<Contradicted>,
    /// The top of the transforms that do not move between it and the robot, if that is not the robot's frame.
    pub carrier: Option<String>,
}

/// A mount of which transforms say two things.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradicted {
    /// The frame of which they do.
    pub frame: String,
    /// How often what is said goes from one to the other.
    pub turns: u64,
    /// By what is not used.
    pub robot_from_sensor: Pose2,
}

/// A quaternion whose length is off by more than this is none.
const OFF_UNIT: f64 = 0.01;
/// A robot on a floor leans less, radians.
const LEANING: f64 = 30.0 * std::f64::consts::PI / 180.0;

/// What the messages that say where the robot was say besides.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseTraits {
    pub poses: u64,
    /// Those whose quaternion does not have the length 1.
    pub off_unit: u64,
    /// The shortest and the longest quaternion.
    pub lengths: [f64; 2],
    /// Those with a quaternion whose x and y are 0 and whose w is 0 or 1, and that does not have the length 1.
    pub heading_for_quaternion: u64,
    /// Those in which the robot's z axis leans by more than 30 deg.
    pub leaning: u64,
    /// Those of them in which it points down.
    pub upside_down: u64,
    /// Where the robot was at the least and at the most: x, y, z, metres.
    pub extent: [[f64; 2]; 3],
    /// Whether the robot ever moved.
    pub has_moved: bool,
    /// Whether the poses are made of the speeds.
    pub are_of_twist: bool,
    /// Way by the poses and by the speeds where both are said, metres.
    pub ways: [f64; 2],
    /// Way by the poses in the direction of the speeds, metres.
    pub way_along: f64,
    /// Turns by the poses times those by the rates of turn, and the squares of these, radians squared.
    pub turns: [f64; 2],
    last: Option<(OdometrySample, [f64; 3])>,
}

impl Default for PoseTraits {
    fn default() -> Self {
        Self {
            poses: 0,
            off_unit: 0,
            lengths: [f64::INFINITY, 0.0],
            heading_for_quaternion: 0,
            leaning: 0,
            upside_down: 0,
            extent: [[f64::INFINITY, f64::NEG_INFINITY]; 3],
            has_moved: false,
            are_of_twist: false,
            ways: [0.0; 2],
            way_along: 0.0,
            turns: [0.0; 2],
            last: None,
        }
    }
}

impl PoseTraits {
    /// Forgets what speeds say of poses that have been changed.
    pub fn forget_speeds(&mut self) {
        (self.ways, self.way_along, self.turns) = ([0.0; 2], 0.0, [0.0; 2]);
    }

    /// Takes a message that says the pose of a sample.
    pub fn take(&mut self, message: &TransformMessage<'_>, sample: OdometrySample) {
        self.poses += 1;
        if let Some([x, y, z, w]) = message.quaternion {
            let length = norm([x, y, z, w]);
            self.lengths = [self.lengths[0].min(length), self.lengths[1].max(length)];
            if (length - 1.0).abs() > OFF_UNIT {
                self.off_unit += 1;
                let of_plane = x == 0.0 && y == 0.0 && z != 0.0 && (w == 0.0 || w == 1.0);
                self.heading_for_quaternion += u64::from(of_plane);
            }
        }
        if let Some(pose) = &message.parent_from_child {
            let up = (pose.rotation * nalgebra::Vector3::z()).z;
            self.leaning += u64::from(up < libm::cos(LEANING));
            self.upside_down += u64::from(up < -libm::cos(LEANING));
            let place = pose.translation.vector;
            for ([low, high], at) in self.extent.iter_mut().zip(place.iter()) {
                (*low, *high) = (low.min(*at), high.max(*at));
            }
        }
        let Some(twist) = message.twist else {
            self.last = None;
            return;
        };
        if let Some((last, was)) = self.last.replace((sample, twist)) {
            self.compare(&last, was, &sample);
        }
    }

    /// Holds the way and the turn from one pose to the next against the speeds.
    fn compare(&mut self, last: &OdometrySample, twist: [f64; 3], next: &OdometrySample) {
        let seconds = next.stamp_ns.saturating_sub(last.stamp_ns) as f64 * 1e-9;
        if !(0.0..1.0).contains(&seconds) {
            return;
        }
        let [forward, left, turn] = twist.map(|speed| speed * seconds);
        let (from, to) = (last.world_from_robot, next.world_from_robot);
        let way = to.position() - from.position();
        let said = Pose2::new(0.0, 0.0, from.yaw).transform(Vec2::new(forward, left));
        self.has_moved |= way.norm() > 0.0 || angle_between(from.yaw, to.yaw) > 0.0;
        self.ways[0] += way.norm();
        self.ways[1] += said.norm();
        if said.norm() > 0.0 {
            self.way_along += way.dot(&said) / said.norm();
        }
        self.turns[0] += wrap_angle(to.yaw - from.yaw) * turn;
        self.turns[1] += turn * turn;
    }
}

/// The path that speeds forward, to the left and of turning lead along, from a pose on; stamps are in order.
pub fn integrated(start: Pose2, samples: &mut [(OdometrySample, [f64; 3])]) {
    let mut pose = start;
    let mut last: Option<(i64, [f64; 3])> = None;
    for (sample, twist) in samples {
        if let Some((stamp_ns, [forward, left, turn])) = last {
            let seconds = sample.stamp_ns.saturating_sub(stamp_ns) as f64 * 1e-9;
            // Along the chord of the arc that it drives.
            let middle = Pose2::new(pose.x, pose.y, pose.yaw + turn * seconds / 2.0);
            let at = middle.transform(Vec2::new(forward * seconds, left * seconds));
            pose = Pose2::new(at.x, at.y, wrap_angle(pose.yaw + turn * seconds));
        }
        last = Some((sample.stamp_ns, *twist));
        sample.world_from_robot = pose;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_a_circle_by_its_speeds() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let sample = |k: i64| OdometrySample {
            stamp_ns: k * 10_000_000,
            world_from_robot: Pose2::IDENTITY,
        };
        let mut samples: Vec<_> = (0..=100)
            .map(|k| (sample(k), [quarter, 0.0, quarter]))
            .collect();
        integrated(Pose2::IDENTITY, &mut samples);
        let end = samples[100].0.world_from_robot;
        assert!(
            (end.position() - Vec2::new(1.0, 1.0)).norm() < 1e-4,
            "{end:?}"
        );
        assert!((end.yaw - quarter).abs() < 1e-9);
    }

    #[test]
    fn a_heading_in_the_place_of_a_quaternion_is_seen() {
        let mut traits = PoseTraits::default();
        let sample = OdometrySample {
            stamp_ns: 0,
            world_from_robot: Pose2::IDENTITY,
        };
        for quaternion in [
            [0.0, 0.0, 0.6, 0.8],
            [0.0, 0.0, 1.5, 1.0],
            [0.3, 0.0, 1.0, 1.0],
        ] {
            let message = TransformMessage {
                quaternion: Some(quaternion),
                ..TransformMessage::default()
            };
            traits.take(&message, sample);
        }
        assert_eq!(
            (traits.poses, traits.off_unit, traits.heading_for_quaternion),
            (3, 2, 1)
        );
    }
}
