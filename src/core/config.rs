//! Every parameter of a replay, with its default.
//!
//! Angles are radians here, as everywhere inside; `tmam.toml` has degrees.

pub mod channel;
mod defaults;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use channel::ChannelFields;

/// How TMAM labels arcs and fuses features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// The paper's rule, with its errors corrected (`docs/algorithm.md`).
    Paper,
    /// What the readings support within their noise (`docs/algorithm.md`): the default.
    NoiseAware,
}

/// What makes a map of the frames (`core/methods`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Three measurements: the default.
    Tmam,
    /// Two measurements, the model that TMAM replaces.
    TwoMeasurement,
    /// Triangulation-based fusion, of Wijk and Christensen.
    Tbf,
    /// The arc-transversal median, of Choset and Nagatani.
    Atm,
    /// Regions of constant depth, of Leonard.
    Rcd,
    /// Three aligned readings, of Crowley.
    Crowley,
}

/// Where the robot's poses come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Poses {
    /// Odometry, as the log has it.
    Odometry,
    /// Odometry and ranges together, estimated with the features (`docs/algorithm.md`); the paper's rule
    /// stays with odometry.
    Joint,
}

/// The parameters of a replay.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// What makes a map of the frames. All but TMAM take odometry's poses, and have no map that predicts.
    pub method: Method,
    /// How TMAM labels arcs and fuses features.
    pub rule: Rule,
    /// Where the robot's poses come from.
    pub poses: Poses,
    /// What is read from the log.
    pub input: Input,
    /// How readings are grouped into frames.
    pub frames: Frames,
    /// What interrupts one sonar's sequence of readings.
    pub sequence: Sequence,
    /// How a triple of arcs is labelled.
    pub triple: Triple,
    /// How precise a reading is taken to be.
    pub noise: Noise,
    /// What a test of line against point needs.
    pub opinion: TestBounds,
    /// How features are fused into the map.
    pub map: Map,
    /// In what the noise-aware rule departs from the paper; without effect on the paper's rule.
    pub noise_aware: NoiseAwareOptions,
    /// What holds for every sonar whose messages or transforms do not say it.
    pub sonars: SonarDefaults,
    /// What is known of single sonars, by name.
    pub sonar: BTreeMap<String, SonarOverride>,
    /// Messages of unknown types, by topic.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub channel: BTreeMap<String, ChannelFields>,
}

/// What is read from the log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Input {
    /// Globs over the topics that carry ranges. Empty: every topic with a range type.
    pub range_topics: Vec<String>,
    /// Globs over the topics that carry odometry. Empty: the one topic with an odometry type.
    pub odometry_topics: Vec<String>,
    /// Globs over the topics that carry transforms and robot descriptions. Empty: those of the robot whose
    /// odometry or ranges are used, by the names of the topics.
    pub transform_topics: Vec<String>,
    /// Globs over the sonars that enter the frames. Empty: all. The others still open frames, so
    /// that frame numbers are those of the whole run.
    pub sonars: Vec<String>,
    /// Readings earlier than this after the first one are left out, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Readings later than this after the first one are left out, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end: Option<f64>,
    /// Frame that the odometry moves and the sonars are mounted in; the odometry's
    /// `child_frame_id` where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot_frame: Option<String>,
    /// Frame that the odometry is in, where messages or transforms give the robot's pose in several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world_frame: Option<String>,
    /// Another log, of which only the transforms that never move and the robot's description are taken: the
    /// first part of a split recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mounts_from: Option<String>,
    /// Which of two tracks that alternate on the odometry's topic is used: 1, with the first sample, or 2.
    /// All samples where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry_track: Option<u8>,
    /// What becomes of the odometry's jumps; they stay where not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry_jumps: Option<Jumps>,
    /// Leave out readings that merely repeat a sonar's last value while the robot moved.
    pub drop_repeats: bool,
    /// Use messages that only the data section's checksum covers where that does not agree: any of
    /// them may be damaged.
    pub trust_unchecked: bool,
    /// Most readings and odometry samples that are held in memory.
    pub max_readings: u64,
    /// What is taken for the stamps of readings.
    pub range_stamps: StampsFrom,
    /// What is taken for the stamps of odometry.
    pub odometry_stamps: StampsFrom,
    /// Make the path of the speeds that come with the odometry's poses, from the first pose on.
    pub odometry_from_speeds: bool,
    /// How long before its stamp a reading was taken, on the odometry's clock, seconds: it gets the
    /// pose of that instant. Stamps stay as the log has them.
    pub range_delay: f64,
    /// By how much the clock of the ranges runs fast against that of odometry, as a share: 0.003 gains 3 ms
    /// in a second. Counted from the first odometry sample.
    pub range_clock_rate: f64,
    /// What distances of odometry are multiplied with.
    pub odometry_scale: f64,
    /// What turns of odometry are multiplied with.
    pub odometry_turn_scale: f64,
}

/// What becomes of jumps in the odometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Jumps {
    /// They are how the robot moved.
    Keep,
    /// Behind each the robot goes on as it drove before: a node or a gyro was set anew.
    TakeOut,
    /// Each is laid over the time since the one before: a localisation corrected its drift.
    Spread,
}

/// What is taken for the stamps of messages.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StampsFrom {
    /// The messages' own.
    #[default]
    Message,
    /// When the messages were recorded.
    Recording,
}

/// How readings are grouped into frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Frames {
    /// Distance driven that opens a new frame, metres; 0 opens one at every reading stamp.
    pub step: f64,
    /// Turn that opens a new frame, radians.
    pub step_angle: f64,
    /// Widest pair of odometry samples to interpolate between, seconds.
    pub max_odometry_gap: f64,
    /// How far beyond the first and last odometry sample a pose is extrapolated, seconds.
    pub max_extrapolation: f64,
}

/// What interrupts one sonar's sequence of readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sequence {
    /// Longest time between neighbouring readings, seconds.
    pub max_gap: f64,
    /// Longest way between the sensor centres of neighbouring readings, metres.
    pub max_baseline: f64,
}

/// How a triple of arcs is labelled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Triple {
    /// `theta_c < alpha * theta_i` for a contact arc; in (0, 1).
    pub alpha: f64,
    /// `theta_c > beta * theta_i` for an intersection arc; above 1.
    pub beta: f64,
    /// Gate on the smaller of the two angles, radians; below the beam width.
    pub gamma: f64,
    /// Largest heading change between neighbouring arcs, radians.
    pub turn_tolerance: f64,
    /// Largest bend between the two base lines, radians.
    pub bend_tolerance: f64,
}

/// Standard deviation of ranges of which nothing is known, metres.
pub const SIGMA_UNKNOWN: f64 = 0.01;

/// How precise a reading is taken to be: `sigma^2 = sigma_abs^2 + (sigma_rel r)^2` where its message
/// gives no variance (or one that is not trusted), and on top of either what the pose adds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Noise {
    /// Whether a message's variance is taken where it gives one.
    pub trust_variance: bool,
    /// Metres; measured from the ranges where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_abs: Option<f64>,
    /// Fraction of the range.
    pub sigma_rel: f64,
    /// What the sensor's place from reading to reading is off by, metres: odometry and the clock.
    pub sigma_pose: f64,
    /// By how much odometry is off after a metre, as a standard deviation that grows with the square root:
    /// metres. For poses that are estimated with the features; found by these where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry_distance: Option<f64>,
    /// The same of the heading after a metre, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry_heading: Option<f64>,
    /// The same of the heading after turning by a radian, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry_turn: Option<f64>,
}

/// When readings support a line or a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TestBounds {
    /// A line or a point explains three readings when its chi2, with one degree of freedom, is
    /// below this; more readings have a gate that lets through the same share.
    pub gate: f64,
    /// By how much chi2 of the one must exceed that of the other for readings to decide.
    pub decisive: f64,
    /// How many readings to either side of an arc are looked at, at most.
    pub max_half_width: usize,
}

/// How features are fused into the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Map {
    /// Points nearer than this are the same point, metres.
    pub match_distance: f64,
    /// Features are the same when their Mahalanobis distance, squared, is below this.
    pub gate: f64,
    /// Longest stretch without readings between two segments of one wall, metres.
    pub max_wall_gap: f64,
    /// This many runs that agree confirm a feature.
    pub confirm_runs: u32,
    /// This many readings confirm a feature that comes from fewer runs.
    pub confirm_readings: u32,
}

/// In what the noise-aware rule departs from the paper, each to be switched off by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NoiseAwareOptions {
    /// Arcs are labelled by what their readings support, widened until it is decided; not by
    /// comparing theta_c with theta_i.
    pub label_by_opinion: bool,
    /// Fits are iterated to their end, not until a step is below a centimetre.
    pub converge: bool,
    /// A run is accepted only if all its readings fit, but for a few outliers.
    pub reject_misfits: bool,
    /// A run that does not fit as a whole is broken where its parts fit best.
    pub break_runs: bool,
    /// A feature whose mirror image at the robot's path fits as well is not registered.
    pub reject_mirrored: bool,
    /// Features are fused by their information, matched by their Mahalanobis distance; not by means
    /// weighted with numbers of readings, matched by (24) to (26).
    pub fuse_by_information: bool,
    /// Features of the map that turn out to be the same become one.
    pub merge: bool,
    /// A feature with too little support stays tentative.
    pub confirm: bool,
    /// Walls end at the corners that they run across.
    pub end_at_corners: bool,
    /// At the end of the log, features are fitted anew to all readings that they alone explain.
    pub gather: bool,
    /// After that, walls and the corners in which they meet are estimated together.
    pub join_corners: bool,
    /// At the end of the log, points in which arcs of several sonars cross that no feature explains. In files
    /// where it is not so, as it came later.
    #[serde(skip_serializing_if = "is_on")]
    pub crossings: bool,
    /// Rough walls seen at an angle support walls of the map, and extend them.
    pub oblique_walls: bool,
    /// Circles are a third hypothesis beside lines and points. In files where it is so, as it came later.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub circles: bool,
}

fn is_on(switch: &bool) -> bool {
    *switch
}

/// An axis of a sonar's frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BeamAxis {
    /// Forward, as of frames of sensors and robots (REP 103).
    #[default]
    X,
    /// Forward in frames of cameras, called optical (REP 103).
    Z,
}

/// How the mounts that transforms give lie on the robot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MountsLie {
    /// As transforms say.
    #[default]
    AsSaid,
    /// Each sonar looks away from the robot's origin.
    Outward,
    /// Left and right are exchanged.
    Mirrored,
    /// All of them a quarter turn to the left about the robot's origin.
    TurnedLeft,
    /// A quarter turn to the right.
    TurnedRight,
    /// Half a turn.
    TurnedRound,
}

/// What holds for every sonar whose messages do not say it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SonarDefaults {
    /// Full opening angle of the beam, radians; used where the message has 0 or NaN.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beam_width: Option<f64>,
    /// What ranges are multiplied with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_scale: Option<f64>,
    /// What is added to ranges after that, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_offset: Option<f64>,
    /// Closest distance that is measured, metres; taken before the message's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_range: Option<f64>,
    /// Where "no echo" begins, metres; taken before the message's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_range: Option<f64>,
    /// Axis of the sonars' frames along which the beams look, where these frames are the log's.
    pub beam_axis: BeamAxis,
    /// How mounts lie that are the log's.
    pub mounts: MountsLie,
    /// A range that stands for no echo, to the millimetre, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_echo: Option<f64>,
}

/// What is known of one sonar.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SonarOverride {
    /// Mounting position in the robot's frame, metres; taken before any transform in the log. What
    /// of x, y and yaw is not given is the log's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// See `x`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// Direction of the beam axis in the robot's frame, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw: Option<f64>,
    /// Full opening angle of the beam, radians; used where the message has 0 or NaN.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beam_width: Option<f64>,
    /// Closest distance measured, metres; taken before the message's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_range: Option<f64>,
    /// Where "no echo" begins, metres; taken before the message's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_range: Option<f64>,
    /// What ranges are multiplied with; taken before that of all sonars.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_scale: Option<f64>,
    /// What is added to ranges after that, metres; taken before that of all sonars.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_offset: Option<f64>,
    /// How much later than those of others ranges are stamped, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_delay: Option<f64>,
}

impl SonarOverride {
    /// Whether it says anything of the mount.
    pub fn has_mount(&self) -> bool {
        self.x.is_some() || self.y.is_some() || self.yaw.is_some()
    }
}

impl Method {
    /// The word in files and for `--method`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tmam => "tmam",
            Self::TwoMeasurement => "two-measurement",
            Self::Tbf => "tbf",
            Self::Atm => "atm",
            Self::Rcd => "rcd",
            Self::Crowley => "crowley",
        }
    }
}

impl NoiseAwareOptions {
    /// None: the paper to the letter.
    pub const NONE: Self = Self {
        label_by_opinion: false,
        converge: false,
        reject_misfits: false,
        break_runs: false,
        reject_mirrored: false,
        fuse_by_information: false,
        merge: false,
        confirm: false,
        end_at_corners: false,
        gather: false,
        join_corners: false,
        crossings: false,
        oblique_walls: false,
        circles: false,
    };
}

impl Config {
    /// The defaults under one rule.
    pub fn with_rule(rule: Rule) -> Self {
        Self {
            rule,
            ..Self::default()
        }
    }

    /// In what the rule departs from the paper.
    pub fn departures(&self) -> NoiseAwareOptions {
        match self.rule {
            Rule::Paper => NoiseAwareOptions::NONE,
            Rule::NoiseAware => self.noise_aware,
        }
    }
}

impl Noise {
    /// Variance of a reading of `range` metres: the driver's where it gave one, else the model's;
    /// and the pose's.
    pub fn variance(&self, range: f64, reported: f64) -> f64 {
        let measured = if self.trust_variance && reported > 0.0 && reported.is_finite() {
            reported
        } else {
            let relative = self.sigma_rel * range;
            let absolute = self.sigma_abs.unwrap_or(SIGMA_UNKNOWN);
            absolute * absolute + relative * relative
        };
        measured + self.sigma_pose * self.sigma_pose
    }
}
