//! How arcs are labelled, and features fitted and fused.

use super::key;
use crate::io::config::keys::Bounds::{Above, Any, AtLeast, Between};
use crate::io::config::keys::Key;
use crate::io::config::keys::Unit::{Degrees, Plain};

/// Its keys.
pub const KEYS: &[Key] = &[
    key(
        "sequence.max_gap",
        Plain,
        Above(0.0),
        "s between neighbouring readings of a sonar",
    ),
    key(
        "sequence.max_baseline",
        Plain,
        Above(0.0),
        "m between neighbouring readings of a sonar",
    ),
    key(
        "triple.alpha",
        Plain,
        Between(0.0, 1.0),
        "contact: theta_c < alpha * theta_i",
    ),
    key(
        "triple.beta",
        Plain,
        Above(1.0),
        "intersection: theta_c > beta * theta_i",
    ),
    key(
        "triple.gamma",
        Degrees,
        Between(0.0, 360.0),
        "deg; gate on the smaller angle, below the beam width",
    ),
    key(
        "triple.turn_tolerance",
        Degrees,
        AtLeast(0.0),
        "deg of heading change between neighbours",
    ),
    key(
        "triple.bend_tolerance",
        Degrees,
        AtLeast(0.0),
        "deg between the two base lines",
    ),
    key(
        "noise.trust_variance",
        Plain,
        Any,
        "take a message's variance where it gives one",
    ),
    key(
        "noise.sigma_abs",
        Plain,
        Above(0.0),
        "m; where a message gives no variance; default: measured from the ranges",
    ),
    key(
        "noise.sigma_rel",
        Plain,
        AtLeast(0.0),
        "fraction of the range, added in squares",
    ),
    key(
        "noise.sigma_pose",
        Plain,
        AtLeast(0.0),
        "m; how far odometry and clock put a sensor off from reading to reading",
    ),
    key(
        "opinion.gate",
        Plain,
        Between(0.0, 1000.0),
        "chi2 below which a line or a point explains a triple",
    ),
    key(
        "opinion.decisive",
        Plain,
        AtLeast(0.0),
        "lead in chi2 of line over point, or the other way, that decides",
    ),
    key(
        "opinion.max_half_width",
        Plain,
        AtLeast(1.0),
        "readings to either side of an arc that are looked at, at most",
    ),
    key(
        "map.match_distance",
        Plain,
        Above(0.0),
        "m; points nearer than this are one point",
    ),
    key(
        "map.gate",
        Plain,
        Above(0.0),
        "noise-aware: squared Mahalanobis distance of what is the same",
    ),
    key(
        "map.max_wall_gap",
        Plain,
        AtLeast(0.0),
        "noise-aware: m without readings between segments of one wall",
    ),
    key(
        "map.confirm_runs",
        Plain,
        AtLeast(1.0),
        "noise-aware: runs that agree confirm a feature",
    ),
    key(
        "map.confirm_readings",
        Plain,
        AtLeast(3.0),
        "noise-aware: readings that confirm a feature of fewer runs",
    ),
    key(
        "noise_aware.label_by_opinion",
        Plain,
        Any,
        "label by what the readings support, widened until decided",
    ),
    key(
        "noise_aware.converge",
        Plain,
        Any,
        "iterate fits to their end",
    ),
    key(
        "noise_aware.reject_misfits",
        Plain,
        Any,
        "a run counts only if all its readings fit, but for outliers",
    ),
    key(
        "noise_aware.break_runs",
        Plain,
        Any,
        "a run that does not fit is broken where its parts fit best",
    ),
    key(
        "noise_aware.reject_mirrored",
        Plain,
        Any,
        "nothing whose mirror image at the path fits as well",
    ),
    key(
        "noise_aware.fuse_by_information",
        Plain,
        Any,
        "inverse covariances and Mahalanobis gates",
    ),
    key(
        "noise_aware.merge",
        Plain,
        Any,
        "map features that turn out to be the same become one",
    ),
    key(
        "noise_aware.confirm",
        Plain,
        Any,
        "a feature with too little support stays tentative",
    ),
    key(
        "noise_aware.end_at_corners",
        Plain,
        Any,
        "walls end at the corners that they run across",
    ),
    key(
        "noise_aware.gather",
        Plain,
        Any,
        "at the end, features from all readings that they alone explain",
    ),
    key(
        "noise_aware.join_corners",
        Plain,
        Any,
        "at the end, walls and the corners in which they meet together",
    ),
];
