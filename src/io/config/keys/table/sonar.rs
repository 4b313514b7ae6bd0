//! What holds for all sonars, and for one.

use super::key;
use crate::io::config::keys::Bounds::{Above, Any, AtLeast, Between};
use crate::io::config::keys::Key;
use crate::io::config::keys::Unit::{Degrees, Plain};

/// Its keys.
pub const KEYS: &[Key] = &[
    key(
        "sonars.beam_width",
        Degrees,
        Between(0.0, 360.0),
        "deg, full angle; where the message has none",
    ),
    key(
        "sonar.*.x",
        Plain,
        Any,
        "m; mount in the robot frame, before the log's transforms",
    ),
    key("sonar.*.y", Plain, Any, "m"),
    key("sonar.*.yaw", Degrees, Any, "deg"),
    key(
        "sonar.*.beam_width",
        Degrees,
        Between(0.0, 360.0),
        "deg, full angle; where the message has none",
    ),
    key(
        "sonar.*.min_range",
        Plain,
        AtLeast(0.0),
        "m; before the message's",
    ),
    key(
        "sonar.*.max_range",
        Plain,
        Above(0.0),
        "m; before the message's",
    ),
];
