//! Writes a ROS 2 MCAP log: ranges, odometry and transforms in CDR, the truth in JSON.
//!
//! Equal calls give equal bytes: the compressor runs on the calling thread, because its output
//! depends on the number of threads, and nothing in the file names the machine, the time or
//! the version.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use nalgebra::Matrix3;
use re_cdr::{CdrWriter, LittleEndian};
use serde::Serialize;

use super::truth::{POSE_SCHEMA, READING_SCHEMA, WORLD_SCHEMA};
use crate::core::geometry::Pose2;
use crate::core::truth::{PoseTruth, ReadingTruth};
use crate::core::world::World;

/// The odometry frame: poses are the robot's in it.
pub const ODOM_FRAME: &str = "odom";
/// The robot's frame: sonars are mounted on it.
pub const ROBOT_FRAME: &str = "base_link";
/// Topic of the path that a replay used, [`nav_msgs/Odometry`](LogWriter::path_pose).
pub const PATH_TOPIC: &str = "/tmam/odom";
/// Topic of the truth about each reading, a [`ReadingTruth`] in JSON.
pub const TRUTH_TOPIC: &str = "/truth";
/// Topic of the world that the sonars looked at, a [`World`] in JSON.
pub const WORLD_TOPIC: &str = "/truth/world";

/// Topic of the truth about each odometry sample, a [`PoseTruth`] in JSON: no message that a reader could
/// take for odometry.
pub const POSE_TOPIC: &str = "/truth/pose";

/// `sensor_msgs/msg/Range`: `ULTRASOUND`.
const ULTRASOUND: u8 = 0;

/// Why a log could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The output or the container refused.
    #[error("cannot write the log: {0}")]
    Mcap(#[from] mcap::McapError),
    /// A value that JSON cannot hold.
    #[error("cannot write the truth: {0}")]
    Json(#[from] serde_json::Error),
    /// ROS 2 stamps hold 31 bits of seconds since 1970.
    #[error(
        "stamp {stamp_ns} ns is not between 1970 and 2038, where ROS 2 stamps end; make the log shorter"
    )]
    Stamp {
        /// The stamp, nanoseconds.
        stamp_ns: i64,
    },
}

/// One range measurement as `sensor_msgs/msg/Range` holds it (32-bit floats).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeMessage<'a> {
    /// Stamp, nanoseconds.
    pub stamp_ns: i64,
    /// The sonar's frame id; its topic is `/sonar/<sonar>`.
    pub sonar: &'a str,
    /// Full opening angle of the beam, radians.
    pub field_of_view: f32,
    /// Closest distance the sonar can measure, metres.
    pub min_range: f32,
    /// Farthest, metres.
    pub max_range: f32,
    /// Measured distance, metres; REP-117: +inf for no echo, -inf for too close.
    pub range: f32,
    /// Variance of `range`, square metres; 0 for unknown.
    pub variance: f32,
}

/// The robot's velocity in its own frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Twist {
    /// Forward, metres per second.
    pub linear: f64,
    /// Counter-clockwise, radians per second.
    pub angular: f64,
}

/// A frame in another: `parent_from_child`, in the plane at a height.
#[derive(Debug, Clone, PartialEq)]
pub struct Transform<'a> {
    /// The frame id that the pose is in.
    pub parent: &'a str,
    /// The frame id that the pose is of.
    pub child: &'a str,
    /// Where the child is in the parent.
    pub parent_from_child: Pose2,
    /// How high, metres.
    pub height: f64,
}

/// Writes one log; [`finish`](Self::finish) completes it.
pub struct LogWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    channels: BTreeMap<String, u16>,
    buffer: Vec<u8>,
}

/// How the messages of a topic are described and encoded: the type's name, its definition, and the encodings
/// of that and of the messages.
type Format = (&'static str, &'static str, [&'static str; 2]);

const ROS_2: [&str; 2] = ["ros2msg", "cdr"];
const JSON: [&str; 2] = ["jsonschema", "json"];

const RANGE: Format = (
    "sensor_msgs/msg/Range",
    include_str!("schemas/Range.msg"),
    ROS_2,
);
const ODOMETRY: Format = (
    "nav_msgs/msg/Odometry",
    include_str!("schemas/Odometry.msg"),
    ROS_2,
);
const TRANSFORMS: Format = (
    "tf2_msgs/msg/TFMessage",
    include_str!("schemas/TFMessage.msg"),
    ROS_2,
);
const TRUTH: Format = (
    READING_SCHEMA,
    include_str!("schemas/ReadingTruth.json"),
    JSON,
);
const POSE: Format = (POSE_SCHEMA, include_str!("schemas/PoseTruth.json"), JSON);
const WORLD: Format = (WORLD_SCHEMA, include_str!("schemas/World.json"), JSON);

impl<W: Write + Seek> LogWriter<W> {
    /// Starts a log on `output`.
    pub fn new(output: W) -> Result<Self, WriteError> {
        let mcap = WriteOptions::new()
            .profile("ros2")
            .library(env!("CARGO_PKG_NAME"))
            .compression(Some(Compression::Zstd))
            .compression_threads(0)
            .create(output)?;
        Ok(Self {
            mcap,
            channels: BTreeMap::new(),
            buffer: Vec::new(),
        })
    }

    /// A reading, on `/sonar/<sonar>`.
    pub fn range(&mut self, message: &RangeMessage) -> Result<(), WriteError> {
        self.buffer.clear();
        let mut cdr = Cdr::new(&mut self.buffer);
        cdr.header(message.stamp_ns, message.sonar)?;
        cdr.0.write_u8(ULTRASOUND);
        for value in [
            message.field_of_view,
            message.min_range,
            message.max_range,
            message.range,
            message.variance,
        ] {
            cdr.0.write_f32(value);
        }
        let topic = format!("/sonar/{}", message.sonar);
        self.write(&topic, RANGE, message.stamp_ns)
    }

    /// Where the robot thinks it is, on `/odom`, and as a transform on `/tf`.
    pub fn odometry(
        &mut self,
        stamp_ns: i64,
        odom_from_robot: Pose2,
        twist: Twist,
    ) -> Result<(), WriteError> {
        let unknown = Matrix3::zeros();
        self.moving("/odom", stamp_ns, odom_from_robot, &unknown, twist)?;

        let transform = Transform {
            parent: ODOM_FRAME,
            child: ROBOT_FRAME,
            parent_from_child: odom_from_robot,
            height: 0.0,
        };
        self.transforms("/tf", stamp_ns, &[transform])
    }

    /// Where the robot was, on [`PATH_TOPIC`], with the covariance over (x, y, yaw): all zeros where it is
    /// not known. How fast it was is not said.
    pub fn path_pose(
        &mut self,
        stamp_ns: i64,
        odom_from_robot: Pose2,
        covariance: &Matrix3<f64>,
    ) -> Result<(), WriteError> {
        let standing = Twist::default();
        self.moving(PATH_TOPIC, stamp_ns, odom_from_robot, covariance, standing)
    }

    /// `nav_msgs/Odometry`.
    fn moving(
        &mut self,
        topic: &str,
        stamp_ns: i64,
        odom_from_robot: Pose2,
        covariance: &Matrix3<f64>,
        twist: Twist,
    ) -> Result<(), WriteError> {
        self.buffer.clear();
        let mut cdr = Cdr::new(&mut self.buffer);
        cdr.header(stamp_ns, ODOM_FRAME)?;
        cdr.0.write_string(ROBOT_FRAME);
        cdr.pose(odom_from_robot, 0.0);
        cdr.covariance(covariance);
        cdr.vector([twist.linear, 0.0, 0.0]);
        cdr.vector([0.0, 0.0, twist.angular]);
        cdr.covariance(&Matrix3::zeros());
        self.write(topic, ODOMETRY, stamp_ns)
    }

    /// Frames that never move, on `/tf_static`.
    pub fn static_transforms(
        &mut self,
        stamp_ns: i64,
        transforms: &[Transform],
    ) -> Result<(), WriteError> {
        self.transforms("/tf_static", stamp_ns, transforms)
    }

    /// What really echoed, on [`TRUTH_TOPIC`].
    pub fn truth(&mut self, truth: &ReadingTruth) -> Result<(), WriteError> {
        self.json(TRUTH_TOPIC, TRUTH, truth.stamp_ns, truth)
    }

    /// Where the robot really was, on [`POSE_TOPIC`].
    pub fn true_pose(&mut self, truth: &PoseTruth) -> Result<(), WriteError> {
        self.json(POSE_TOPIC, POSE, truth.stamp_ns, truth)
    }

    /// The world that the truth counts in, on [`WORLD_TOPIC`].
    pub fn world(&mut self, stamp_ns: i64, world: &World) -> Result<(), WriteError> {
        self.json(WORLD_TOPIC, WORLD, stamp_ns, world)
    }

    /// Completes the log and gives its output back.
    pub fn finish(mut self) -> Result<W, WriteError> {
        self.mcap.finish()?;
        Ok(self.mcap.into_inner())
    }

    fn transforms(
        &mut self,
        topic: &str,
        stamp_ns: i64,
        transforms: &[Transform],
    ) -> Result<(), WriteError> {
        self.buffer.clear();
        let mut cdr = Cdr::new(&mut self.buffer);
        cdr.0.write_sequence_length(transforms.len());
        for transform in transforms {
            cdr.header(stamp_ns, transform.parent)?;
            cdr.0.write_string(transform.child);
            cdr.pose(transform.parent_from_child, transform.height);
        }
        self.write(topic, TRANSFORMS, stamp_ns)
    }

    fn json(
        &mut self,
        topic: &str,
        format: Format,
        stamp_ns: i64,
        value: &impl Serialize,
    ) -> Result<(), WriteError> {
        self.buffer.clear();
        serde_json::to_writer(&mut self.buffer, value)?;
        self.write(topic, format, stamp_ns)
    }

    /// Appends what is in the buffer to a topic, whose channel its first message opens.
    fn write(&mut self, topic: &str, format: Format, stamp_ns: i64) -> Result<(), WriteError> {
        let channel_id = match self.channels.get(topic) {
            Some(id) => *id,
            None => {
                let (name, text, [schema_encoding, encoding]) = format;
                let schema = (self.mcap).add_schema(name, schema_encoding, text.as_bytes())?;
                let metadata = BTreeMap::new();
                let id = (self.mcap).add_channel(schema, topic, encoding, &metadata)?;
                self.channels.insert(topic.to_owned(), id);
                id
            }
        };
        let time = u64::try_from(stamp_ns).map_err(|_| WriteError::Stamp { stamp_ns })?;
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: time,
            publish_time: time,
        };
        Ok(self.mcap.write_to_known_channel(&header, &self.buffer)?)
    }
}

/// CDR encapsulation header: plain CDR, little-endian.
const CDR_LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];
const NANOSECONDS: i64 = 1_000_000_000;

/// Writes one message.
struct Cdr<'a>(CdrWriter<'a, LittleEndian>);

impl<'a> Cdr<'a> {
    /// A message that starts in `buffer`.
    fn new(buffer: &'a mut Vec<u8>) -> Self {
        buffer.extend_from_slice(&CDR_LITTLE_ENDIAN);
        Self(CdrWriter::new(buffer))
    }

    /// `std_msgs/Header`.
    fn header(&mut self, stamp_ns: i64, frame: &str) -> Result<(), WriteError> {
        let out_of_range = |_| WriteError::Stamp { stamp_ns };
        let seconds = i32::try_from(stamp_ns.div_euclid(NANOSECONDS)).map_err(out_of_range)?;
        let rest = u32::try_from(stamp_ns.rem_euclid(NANOSECONDS)).map_err(out_of_range)?;
        self.0.write_i32(seconds);
        self.0.write_u32(rest);
        self.0.write_string(frame);
        Ok(())
    }

    /// `geometry_msgs/Vector3` or `geometry_msgs/Point`.
    fn vector(&mut self, vector: [f64; 3]) {
        for value in vector {
            self.0.write_f64(value);
        }
    }

    /// `geometry_msgs/Pose` and `geometry_msgs/Transform` are laid out alike.
    fn pose(&mut self, pose: Pose2, height: f64) {
        self.vector([pose.x, pose.y, height]);
        let (sin, cos) = libm::sincos(pose.yaw / 2.0);
        for value in [0.0, 0.0, sin, cos] {
            self.0.write_f64(value);
        }
    }

    /// A covariance over (x, y, yaw) as one over (x, y, z, roll, pitch, yaw). All zeros is how ROS says
    /// that it is not known.
    fn covariance(&mut self, covariance: &Matrix3<f64>) {
        let c = covariance;
        let rows = [
            [c.m11, c.m12, 0.0, 0.0, 0.0, c.m13],
            [c.m21, c.m22, 0.0, 0.0, 0.0, c.m23],
            [0.0; 6],
            [0.0; 6],
            [0.0; 6],
            [c.m31, c.m32, 0.0, 0.0, 0.0, c.m33],
        ];
        for value in rows.as_flattened() {
            self.0.write_f64(*value);
        }
    }
}

#[cfg(test)]
mod tests;
