//! The keys of `tmam.toml`: unit, meaning and bounds of each, in the order in which they are shown.

use toml_writer::{ToTomlKey, TomlKeyBuilder};

use Bounds::{Above, Any, AtLeast, Between, Either, From};
use Unit::{Degrees, Plain};

/// How a value is written in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// As it is inside: metres, seconds, plain numbers, text.
    Plain,
    /// Degrees in the file, radians inside.
    Degrees,
}

/// Which numbers a key takes, in the unit of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bounds {
    /// Not a number, or any finite one.
    Any,
    /// Above the first and below the second.
    Between(f64, f64),
    /// Above.
    Above(f64),
    /// Not below.
    AtLeast(f64),
    /// Not below the first and not above the second.
    From(f64, f64),
    /// One of the two.
    Either(f64, f64),
}

/// One key.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// `section.key`, or `key` at the top level; `sonar.*.key` for a single sonar's, `channel.*.key`
    /// for a topic's.
    pub path: &'static str,
    /// How its value is written.
    pub unit: Unit,
    /// Which numbers it takes.
    pub bounds: Bounds,
    /// One line for a person.
    pub doc: &'static str,
}

const fn key(path: &'static str, unit: Unit, bounds: Bounds, doc: &'static str) -> Key {
    Key {
        path,
        unit,
        bounds,
        doc,
    }
}

/// Every key, a row each.
#[rustfmt::skip]
pub const KEYS: &[Key] = &[
    key("method", Plain, Any, "\"tmam\", or for comparison \"two-measurement\", \"tbf\", \"atm\", \"rcd\", \"crowley\""),
    key("rule", Plain, Any, "how tmam labels arcs: \"paper\" or \"noise-aware\""),
    key("poses", Plain, Any, "noise-aware: \"odometry\", or \"joint\": estimated with the features"),

    key("input.range_topics", Plain, Any, "globs; empty: every topic with a range type"),
    key("input.odometry_topics", Plain, Any, "globs; empty: the one topic with an odometry type"),
    key("input.transform_topics", Plain, Any, "globs; empty: those in the namespace of the odometry or the ranges"),
    key("input.sonars", Plain, Any, "globs over sonar names; empty: all"),
    key("input.start", Plain, AtLeast(0.0), "s after the first reading; earlier ones are left out"),
    key("input.end", Plain, AtLeast(0.0), "s after the first reading; later ones are left out"),
    key("input.robot_frame", Plain, Any, "frame the odometry moves; default: its child_frame_id"),
    key("input.world_frame", Plain, Any, "frame the odometry is in, where there are several"),
    key("input.mounts_from", Plain, Any, "another log that has the mounts: the first part of a split recording"),
    key("input.odometry_track", Plain, Either(1.0, 2.0), "1 or 2, of two tracks that alternate on the odometry's topic; default: all samples"),
    key("input.odometry_jumps", Plain, Any, "\"keep\" (default), \"take-out\": it goes on as it drove, or \"spread\": corrections of drift"),
    key("input.drop_repeats", Plain, Any, "leave out readings that repeat the last one while driving"),
    key("input.trust_unchecked", Plain, Any, "use messages of a damaged log that no checksum vouches for"),
    key("input.max_readings", Plain, AtLeast(1.0), "readings and odometry samples held, 60 bytes each"),
    key("input.range_stamps", Plain, Any, "\"message\", or \"recording\" where the sonars' clock is no good"),
    key("input.odometry_stamps", Plain, Any, "\"message\", or \"recording\" where the odometry's clock is no good"),
    key("input.odometry_from_speeds", Plain, Any, "make the path of the speeds that come with the odometry's poses"),
    key("input.range_delay", Plain, Any, "s that ranges are stamped late: their poses are so much older"),
    key("input.range_clock_rate", Plain, Between(-0.5, 0.5), "share by which the clock of the ranges runs fast: 0.003 gains 3 ms a second"),
    key("input.odometry_scale", Plain, Above(0.0), "what distances of odometry are multiplied with"),
    key("input.odometry_turn_scale", Plain, Above(0.0), "what turns of odometry are multiplied with"),

    key("frames.step", Plain, AtLeast(0.0), "m driven that open a new frame; 0: one at every stamp"),
    key("frames.step_angle", Degrees, Above(0.0), "deg turned that open a new frame"),
    key("frames.max_odometry_gap", Plain, Above(0.0), "s between samples to interpolate over"),
    key("frames.max_extrapolation", Plain, AtLeast(0.0), "s beyond the first and last sample"),

    key("sequence.max_gap", Plain, Above(0.0), "s between neighbouring readings of a sonar"),
    key("sequence.max_baseline", Plain, Above(0.0), "m between neighbouring readings of a sonar"),

    key("triple.alpha", Plain, Between(0.0, 1.0), "contact: theta_c < alpha * theta_i"),
    key("triple.beta", Plain, Above(1.0), "intersection: theta_c > beta * theta_i"),
    key("triple.gamma", Degrees, Between(0.0, 360.0), "deg; gate on the smaller angle, below the beam width"),
    key("triple.turn_tolerance", Degrees, AtLeast(0.0), "deg of heading change between neighbours"),
    key("triple.bend_tolerance", Degrees, AtLeast(0.0), "deg between the two base lines"),

    key("noise.trust_variance", Plain, Any, "take a message's variance where it gives one"),
    key("noise.sigma_abs", Plain, Above(0.0), "m; where a message gives no variance; default: measured from the ranges"),
    key("noise.sigma_rel", Plain, AtLeast(0.0), "fraction of the range, added in squares"),
    key("noise.sigma_pose", Plain, AtLeast(0.0), "m; how far odometry and clock put a sensor off from reading to reading"),
    key("noise.odometry_distance", Plain, From(0.0, 0.5), "m that odometry is off after a metre; default: found from the ranges"),
    key("noise.odometry_heading", Degrees, From(0.0, 28.0), "deg that its heading is off after a metre; default: found"),
    key("noise.odometry_turn", Degrees, From(0.0, 28.0), "deg that its heading is off after turning by a radian; default: found"),

    key("opinion.gate", Plain, Between(0.0, 1000.0), "chi2 below which a line or a point explains a triple"),
    key("opinion.decisive", Plain, AtLeast(0.0), "lead in chi2 of line over point, or the other way, that decides"),
    key("opinion.max_half_width", Plain, AtLeast(1.0), "readings to either side of an arc that are looked at, at most"),

    key("map.match_distance", Plain, Above(0.0), "m; points nearer than this are one point"),
    key("map.gate", Plain, Above(0.0), "noise-aware: squared Mahalanobis distance of what is the same"),
    key("map.max_wall_gap", Plain, AtLeast(0.0), "noise-aware: m without readings between segments of one wall"),
    key("map.confirm_runs", Plain, AtLeast(1.0), "noise-aware: runs that agree confirm a feature"),
    key("map.confirm_readings", Plain, AtLeast(3.0), "noise-aware: readings that confirm a feature of fewer runs"),

    key("noise_aware.label_by_opinion", Plain, Any, "label by what the readings support, widened until decided"),
    key("noise_aware.converge", Plain, Any, "iterate fits to their end"),
    key("noise_aware.reject_misfits", Plain, Any, "a run counts only if all its readings fit, but for outliers"),
    key("noise_aware.break_runs", Plain, Any, "a run that does not fit is broken where its parts fit best"),
    key("noise_aware.reject_mirrored", Plain, Any, "nothing whose mirror image at the path fits as well"),
    key("noise_aware.fuse_by_information", Plain, Any, "inverse covariances and Mahalanobis gates"),
    key("noise_aware.merge", Plain, Any, "map features that turn out to be the same become one"),
    key("noise_aware.confirm", Plain, Any, "a feature with too little support stays tentative"),
    key("noise_aware.end_at_corners", Plain, Any, "walls end at the corners that they run across"),
    key("noise_aware.gather", Plain, Any, "at the end, features from all readings that they alone explain"),
    key("noise_aware.join_corners", Plain, Any, "at the end, walls and the corners in which they meet together"),
    key("noise_aware.crossings", Plain, Any, "false: no points of which no single sonar tells; default: true"),
    key("noise_aware.oblique_walls", Plain, Any, "rough walls seen at an angle support walls of the map, and extend them"),
    key("noise_aware.circles", Plain, Any, "true: pillars are circles of the map; default: false"),

    key("sonars.beam_width", Degrees, Between(0.0, 360.0), "deg, full angle; where the message has none"),
    key("sonars.range_scale", Plain, Above(0.0), "what ranges are multiplied with; default: 1"),
    key("sonars.range_offset", Plain, Any, "m added to ranges after that; default: 0"),
    key("sonars.min_range", Plain, AtLeast(0.0), "m; before the messages'"),
    key("sonars.max_range", Plain, Above(0.0), "m; before the messages'"),
    key("sonars.beam_axis", Plain, Any, "of the frames that the log's transforms place: \"x\", or \"z\" (optical)"),
    key("sonars.mounts", Plain, Any, "of the log's transforms: \"as-said\", \"outward\", \"mirrored\", \"turned-left\", \"turned-right\", \"turned-round\""),
    key("sonars.no_echo", Plain, AtLeast(0.0), "m; a range that stands for no echo"),

    key("sonar.*.x", Plain, Any, "m; mount in the robot frame, before the log's transforms"),
    key("sonar.*.y", Plain, Any, "m"),
    key("sonar.*.yaw", Degrees, Any, "deg"),
    key("sonar.*.beam_width", Degrees, Between(0.0, 360.0), "deg, full angle; where the message has none"),
    key("sonar.*.min_range", Plain, AtLeast(0.0), "m; before the message's"),
    key("sonar.*.max_range", Plain, Above(0.0), "m; before the message's"),
    key("sonar.*.range_scale", Plain, Above(0.0), "what its ranges are multiplied with; default: that of all sonars"),
    key("sonar.*.range_offset", Plain, Any, "m added to its ranges after that; default: that of all sonars"),
    key("sonar.*.range_delay", Plain, Any, "s that its ranges are stamped later than those of the others"),

    key("channel.*.type", Plain, Any, "type of the messages, where the log does not say it"),
    key("channel.*.range", Plain, Any, "path of the range, or of an array of them"),
    key("channel.*.stamp", Plain, Any, "path of the stamp; default: when it was recorded"),
    key("channel.*.stamp_unit", Plain, Any, "of a stamp that is a number: \"s\" (default), \"ms\", \"us\", \"ns\""),
    key("channel.*.frame", Plain, Any, "path of the frame id of the sonar, or of the odometry"),
    key("channel.*.frame_name", Plain, Any, "the frame id, where the message has none"),
    key("channel.*.min_range", Plain, AtLeast(0.0), "path, or m; default: 0"),
    key("channel.*.max_range", Plain, Above(0.0), "path, or m; default: no limit"),
    key("channel.*.beam_width", Degrees, Between(0.0, 360.0), "path, or deg, full angle"),
    key("channel.*.variance", Plain, AtLeast(0.0), "path, or m^2; default: the noise model"),
    key("channel.*.x", Plain, Any, "path of the robot's position, for odometry"),
    key("channel.*.y", Plain, Any, "path"),
    key("channel.*.yaw", Plain, Any, "path of the robot's heading"),
    key("channel.*.position", Plain, Any, "path of a message with x, y, z, or of an array, for x and y"),
    key("channel.*.orientation", Plain, Any, "path of a quaternion, for yaw: x, y, z, w, or an array that begins with w"),
    key("channel.*.angle_unit", Plain, Any, "of angles at paths: \"rad\" (default), \"deg\""),
    key("channel.*.up", Plain, Any, "axis of the poses that points up: \"z\" (default), \"y\", \"-y\": cameras, or \"-z\": NED, which becomes ENU"),
    key("channel.*.heading", Plain, Any, "\"counterclockwise\" from x (default), \"clockwise\" from x, or \"compass\": clockwise from y"),
    key("channel.*.metres_per_unit", Plain, Above(0.0), "of lengths at paths, or without any of all that the messages hold; default: 1"),
];

/// The key that a path in a file names.
pub fn find(path: &[&str]) -> Option<&'static Key> {
    KEYS.iter().find(|key| {
        let parts: Vec<&str> = key.path.split('.').collect();
        parts.len() == path.len()
            && parts
                .iter()
                .zip(path)
                .all(|(part, given)| *part == "*" || part == given)
    })
}

/// The known path nearest to an unknown one, if any is near.
pub fn nearest(path: &[&str]) -> Option<String> {
    let given = path.join(".");
    KEYS.iter()
        .map(|key| match path {
            [_, name, _] => key.path.replace('*', name),
            _ => key.path.to_owned(),
        })
        .flat_map(|known| {
            // A right key in the wrong section, or without one, is near too.
            let leaf = known.rsplit('.').next().unwrap_or_default().to_owned();
            let given_leaf = path.last().copied().unwrap_or_default();
            [
                (strsim::jaro_winkler(&given, &known), known.clone()),
                (strsim::jaro_winkler(given_leaf, &leaf) - 0.05, known),
            ]
        })
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, known)| known)
}

impl Bounds {
    /// Whether a number, in the unit of the file, is allowed.
    pub fn hold(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Between(low, high) => value > low && value < high,
                Self::Above(low) => value > low,
                Self::AtLeast(low) => value >= low,
                Self::From(low, high) => (low..=high).contains(&value),
                Self::Either(one, other) => value == one || value == other,
            }
    }
}

impl std::fmt::Display for Bounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Any => write!(f, "a finite number"),
            Self::Between(low, high) => write!(f, "above {low} and below {high}"),
            Self::Above(low) => write!(f, "above {low}"),
            Self::AtLeast(low) => write!(f, "at least {low}"),
            Self::From(low, high) => write!(f, "from {low} to {high}"),
            Self::Either(one, other) => write!(f, "{one} or {other}"),
        }
    }
}
/// A part of a key in quotes, on one line whatever it holds.
pub fn quoted(part: &str) -> String {
    TomlKeyBuilder::new(part).as_basic().to_toml_key()
}

/// A part of a key as TOML has it: in quotes where it must be.
pub fn part(part: &str) -> String {
    let bare = TomlKeyBuilder::new(part).as_unquoted();
    bare.map_or_else(|| quoted(part), |bare| bare.to_toml_key())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_name_is_a_key() {
        for name in [
            "sonar_00",
            "a b",
            "a\nb",
            "\u{1b}[31m",
            "\"\\'",
            "\u{85}\t",
            "",
        ] {
            for key in [quoted(name), part(name)] {
                let text = format!("[sonar.{key}]\nx = 1");
                let table: toml::Table = text.parse().unwrap();
                let sonars = table.get("sonar").unwrap().as_table().unwrap();
                assert_eq!(sonars.keys().collect::<Vec<_>>(), [name], "{text}");
            }
        }
    }
}
