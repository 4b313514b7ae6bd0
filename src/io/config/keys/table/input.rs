//! What is read of a log, and cut into frames; and the rule.

use super::key;
use crate::io::config::keys::Bounds::{Above, Any, AtLeast};
use crate::io::config::keys::Key;
use crate::io::config::keys::Unit::{Degrees, Plain};

/// Its keys.
pub const KEYS: &[Key] = &[
    key(
        "rule",
        Plain,
        Any,
        "how arcs are labelled: \"paper\" or \"noise-aware\"",
    ),
    key(
        "input.range_topics",
        Plain,
        Any,
        "globs; empty: every topic with a range type",
    ),
    key(
        "input.odometry_topics",
        Plain,
        Any,
        "globs; empty: the one topic with an odometry type",
    ),
    key(
        "input.sonars",
        Plain,
        Any,
        "globs over sonar names; empty: all",
    ),
    key(
        "input.start",
        Plain,
        AtLeast(0.0),
        "s after the first reading; earlier ones are left out",
    ),
    key(
        "input.end",
        Plain,
        AtLeast(0.0),
        "s after the first reading; later ones are left out",
    ),
    key(
        "input.robot_frame",
        Plain,
        Any,
        "frame the odometry moves; default: its child_frame_id",
    ),
    key(
        "input.world_frame",
        Plain,
        Any,
        "frame the odometry is in, where there are several",
    ),
    key(
        "input.drop_repeats",
        Plain,
        Any,
        "leave out readings that repeat the last one while driving",
    ),
    key(
        "input.trust_unchecked",
        Plain,
        Any,
        "use messages of a damaged log that no checksum vouches for",
    ),
    key(
        "input.max_readings",
        Plain,
        AtLeast(1.0),
        "readings and odometry samples held, 60 bytes each",
    ),
    key(
        "input.range_delay",
        Plain,
        Any,
        "s that ranges are stamped late: their poses are so much older",
    ),
    key(
        "frames.step",
        Plain,
        AtLeast(0.0),
        "m driven that open a new frame; 0: one at every stamp",
    ),
    key(
        "frames.step_angle",
        Degrees,
        Above(0.0),
        "deg turned that open a new frame",
    ),
    key(
        "frames.max_odometry_gap",
        Plain,
        Above(0.0),
        "s between samples to interpolate over",
    ),
    key(
        "frames.max_extrapolation",
        Plain,
        AtLeast(0.0),
        "s beyond the first and last sample",
    ),
];
