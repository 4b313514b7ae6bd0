//! The message parts that ROS messages share, in CDR.

use re_cdr::{CdrWriter, LittleEndian};

use super::WriteError;
use crate::core::geometry::Pose2;

/// CDR encapsulation header: plain CDR, little-endian.
const CDR_LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];
const NANOSECONDS: i64 = 1_000_000_000;

/// Writes one message.
pub(super) struct Cdr<'a>(pub(super) CdrWriter<'a, LittleEndian>);

impl<'a> Cdr<'a> {
    /// A message that starts in `buffer`.
    pub(super) fn new(buffer: &'a mut Vec<u8>) -> Self {
        buffer.extend_from_slice(&CDR_LITTLE_ENDIAN);
        Self(CdrWriter::new(buffer))
    }

    /// `std_msgs/Header`.
    pub(super) fn header(&mut self, stamp_ns: i64, frame: &str) -> Result<(), WriteError> {
        let out_of_range = |_| WriteError::Stamp { stamp_ns };
        let seconds = i32::try_from(stamp_ns.div_euclid(NANOSECONDS)).map_err(out_of_range)?;
        let rest = u32::try_from(stamp_ns.rem_euclid(NANOSECONDS)).map_err(out_of_range)?;
        self.0.write_i32(seconds);
        self.0.write_u32(rest);
        self.0.write_string(frame);
        Ok(())
    }

    /// `geometry_msgs/Vector3` or `geometry_msgs/Point`.
    pub(super) fn vector(&mut self, vector: [f64; 3]) {
        for value in vector {
            self.0.write_f64(value);
        }
    }

    /// `geometry_msgs/Pose` and `geometry_msgs/Transform` are laid out alike.
    pub(super) fn pose(&mut self, pose: Pose2, height: f64) {
        self.vector([pose.x, pose.y, height]);
        let (sin, cos) = libm::sincos(pose.yaw / 2.0);
        for value in [0.0, 0.0, sin, cos] {
            self.0.write_f64(value);
        }
    }

    /// All zeros, which is how ROS says that a covariance is not known.
    pub(super) fn unknown_covariance(&mut self) {
        for value in [0.0; 36] {
            self.0.write_f64(value);
        }
    }
}
