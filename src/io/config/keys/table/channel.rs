//! How messages of other types are read.

use super::key;
use crate::io::config::keys::Bounds::{Above, Any, AtLeast, Between};
use crate::io::config::keys::Key;
use crate::io::config::keys::Unit::{Degrees, Plain};

/// Its keys.
pub const KEYS: &[Key] = &[
    key(
        "channel.*.type",
        Plain,
        Any,
        "type of the messages, where the log does not say it",
    ),
    key(
        "channel.*.range",
        Plain,
        Any,
        "path of the range, or of an array of them",
    ),
    key(
        "channel.*.stamp",
        Plain,
        Any,
        "path of the stamp; default: when it was recorded",
    ),
    key(
        "channel.*.stamp_unit",
        Plain,
        Any,
        "of a stamp that is a number: \"s\" (default), \"ms\", \"us\", \"ns\"",
    ),
    key(
        "channel.*.frame",
        Plain,
        Any,
        "path of the frame id of the sonar, or of the odometry",
    ),
    key(
        "channel.*.frame_name",
        Plain,
        Any,
        "the frame id, where the message has none",
    ),
    key(
        "channel.*.min_range",
        Plain,
        AtLeast(0.0),
        "path, or m; default: 0",
    ),
    key(
        "channel.*.max_range",
        Plain,
        Above(0.0),
        "path, or m; default: no limit",
    ),
    key(
        "channel.*.beam_width",
        Degrees,
        Between(0.0, 360.0),
        "path, or deg, full angle",
    ),
    key(
        "channel.*.variance",
        Plain,
        AtLeast(0.0),
        "path, or m^2; default: the noise model",
    ),
    key(
        "channel.*.x",
        Plain,
        Any,
        "path of the robot's position, for odometry",
    ),
    key("channel.*.y", Plain, Any, "path"),
    key("channel.*.yaw", Plain, Any, "path of the robot's heading"),
    key(
        "channel.*.position",
        Plain,
        Any,
        "path of a message with x, y, z, for x and y",
    ),
    key(
        "channel.*.orientation",
        Plain,
        Any,
        "path of a quaternion x, y, z, w, for yaw",
    ),
    key(
        "channel.*.angle_unit",
        Plain,
        Any,
        "of angles at paths: \"rad\" (default), \"deg\"",
    ),
    key(
        "channel.*.metres_per_unit",
        Plain,
        Above(0.0),
        "of lengths at paths; default: 1",
    ),
];
