//! What the messages of a log say, whatever type they are of.

use std::borrow::Cow;

use nalgebra::{Isometry3, Point3};

/// No more sonars than this are told apart.
pub const MOST_SONARS: usize = 4096;

/// A coordinate beyond this is no place that a robot, or a sonar on it, was at: more than twice round the
/// Earth, metres.
pub const FARTHEST: f64 = 1e8;

/// What the messages of a type are good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    Range,
    Odometry,
    /// Poses: odometry samples where a log has no odometry, or where they are asked for.
    Pose,
    Transform,
    /// The robot's description, with its fixed joints.
    Description,
}

/// What one message says.
#[derive(Debug, Clone, PartialEq)]
pub enum Content<'m> {
    /// Range readings, one or a ring of them.
    Ranges(Vec<RangeMessage<'m>>),
    /// So many ranges that they are not even looked at.
    Crowd(usize),
    /// The world's frame is the parent, the robot's the child.
    Odometry(TransformMessage<'m>),
    Transforms(Vec<TransformMessage<'m>>),
    Hits(HitsMessage),
    /// A URDF.
    Description(String),
}

impl Content<'_> {
    /// How many sonars it has a range of.
    pub fn sonars(&self) -> usize {
        match self {
            Self::Ranges(ranges) => ranges.len(),
            Self::Hits(hits) => hits.points.len(),
            Self::Crowd(count) => *count,
            _ => 0,
        }
    }

    /// The same with lengths in another unit.
    pub fn scaled(mut self, metres_per_unit: f64) -> Self {
        let scale = |pose: &mut Isometry3<f64>| pose.translation.vector *= metres_per_unit;
        let place =
            |pose: &mut TransformMessage<'_>| pose.parent_from_child.iter_mut().for_each(scale);
        match &mut self {
            _ if metres_per_unit == 1.0 => {}
            Self::Ranges(ranges) => ranges.iter_mut().for_each(|reading| {
                reading.range *= metres_per_unit;
                reading.min_range *= metres_per_unit;
                reading.max_range *= metres_per_unit;
                reading.variance *= metres_per_unit * metres_per_unit;
            }),
            Self::Odometry(pose) => place(pose),
            Self::Transforms(poses) => poses.iter_mut().for_each(place),
            Self::Hits(hits) => {
                hits.points
                    .iter_mut()
                    .for_each(|p| p.coords *= metres_per_unit);
            }
            Self::Crowd(_) | Self::Description(_) => {}
        }
        self
    }

    /// How many readings and odometry samples of it are held in memory.
    pub fn held(&self) -> u64 {
        match self {
            Self::Odometry(_) => 1,
            other => other.sonars() as u64,
        }
    }
}

/// One reading of one sonar. Metres, radians; stamps are 0 where the driver gave none.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeMessage<'m> {
    pub stamp_ns: i64,
    /// How much later than the message's stamp it was taken, nanoseconds.
    pub delay_ns: i64,
    /// Frame of the sensor, without a leading slash, as every frame below.
    pub frame_id: Cow<'m, str>,
    /// Which of a message's sonars, where it has more than one.
    pub element: Option<usize>,
    /// The beam in the sensor's frame: its axis is x.
    pub frame_from_beam: Isometry3<f64>,
    /// Infinite or NaN as the driver wrote it, as everything below.
    pub range: f64,
    pub min_range: f64,
    pub max_range: f64,
    /// Full angle; 0 or NaN where the message does not say it.
    pub beam_width: f64,
    /// Full angle that is taken where neither message nor configuration says it; 0 or NaN for none.
    pub likely_beam_width: f64,
    /// Square metres; 0 where the driver, or this form of the message, does not give it.
    pub variance: f64,
    /// Whether the message says that it measures with light.
    pub infrared: bool,
    /// Whether the angles of its scan were in degrees.
    pub in_degrees: bool,
}

impl<'m> RangeMessage<'m> {
    /// A reading of which nothing is known but its value, metres.
    pub fn plain(stamp_ns: i64, frame_id: impl Into<Cow<'m, str>>, range: f64) -> Self {
        Self {
            stamp_ns,
            delay_ns: 0,
            frame_id: frame_id.into(),
            element: None,
            frame_from_beam: Isometry3::identity(),
            range,
            min_range: 0.0,
            max_range: f64::INFINITY,
            beam_width: 0.0,
            likely_beam_width: 0.0,
            variance: 0.0,
            infrared: false,
            in_degrees: false,
        }
    }
}

/// Where one frame is in another.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TransformMessage<'m> {
    pub stamp_ns: i64,
    pub parent: Cow<'m, str>,
    /// Empty where the message does not name it.
    pub child: Cow<'m, str>,
    /// `None` where a number is not finite or no robot can be there.
    pub parent_from_child: Option<Isometry3<f64>>,
    /// The orientation as the message has it, x, y, z and w, of whatever length; `None` where it has none.
    pub quaternion: Option<[f64; 4]>,
    /// Speed forward and to the left, metres per second, and turn, radians per second, where the message has
    /// them.
    pub twist: Option<[f64; 3]>,
}

/// A quaternion that is no longer stands for no turn.
pub const NO_TURN: f64 = 1e-6;

/// The length of a quaternion.
pub fn norm([x, y, z, w]: [f64; 4]) -> f64 {
    (x * x + y * y + z * z + w * w).sqrt()
}

impl TransformMessage<'_> {
    /// Whether its quaternion is zero, as of messages that were never given one.
    pub fn is_unturned(&self) -> bool {
        self.quaternion.is_some_and(|parts| norm(parts) <= NO_TURN)
    }
}

/// Where the beams of a sonar ring ended; which sonar a point is of is not said.
#[derive(Debug, Clone, PartialEq)]
pub struct HitsMessage {
    pub stamp_ns: i64,
    pub frame_id: String,
    /// Metres.
    pub points: Vec<Point3<f64>>,
}
