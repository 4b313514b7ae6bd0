//! What a log holds, counted and measured.

use serde::Serialize;

use super::odometry::{self, OdometryFacts};
use super::sonars::{self, SonarFacts};
use super::trial::{Replayable, Trial};
use crate::core::event::Readings;
use crate::core::observer::Source;
use crate::core::pattern::is_chosen;
use crate::core::replay::Outcome;
use crate::core::rounding::optional;
use crate::io::log::channels::ChannelReport;
use crate::io::log::survey::{ChannelClock, Survey};
use crate::io::log::{ClockSet, LogError, MissingMount, Role};

/// What a log holds.
#[derive(Debug, Serialize)]
pub struct Facts {
    /// From its first to its last reading, or from its first to its last message without any.
    pub source: Source,
    pub replay: Trial,
    /// By topic.
    pub channels: Vec<ChannelFacts>,
    /// By name.
    pub sonars: Vec<SonarFacts>,
    pub odometry: Option<OdometryFacts>,
    /// How the clock of its stamps was set while it was recorded.
    #[serde(skip)]
    pub clock_set: Option<ClockSet>,
}

impl Facts {
    /// The facts of a surveyed log, with what a replay of it came to where there was one already.
    pub fn new(survey: &Survey, outcome: Option<Outcome>) -> Self {
        let Survey {
            log,
            clock_set,
            config,
            in_part,
            odometry_topic,
            obstacles,
            ..
        } = survey;
        let channels = self::channels(&survey.channels, &survey.clocks);
        let mut sonars = sonars::sonars(&log.events, config);
        sonars.retain(|sonar| is_chosen(&config.input.sonars, &sonar.name));
        // What a placeholder stands for is not known.
        let (mounts, beams) = (missing_mounts(obstacles), without_beam(obstacles));
        for sonar in &mut sonars {
            let has_mount = mounts.iter().all(|missing| missing.sonar != sonar.name);
            sonar.mount = sonar.mount.filter(|_| has_mount);
            let has_beam = !beams.contains(&sonar.name.as_str());
            sonar.beam_width = sonar.beam_width.filter(|_| has_beam);
        }
        let odometry = odometry::odometry(
            odometry_topic.as_deref(),
            &log.events,
            clock_set.as_ref().map_or(&[], |set| &set.twice),
            config,
        );
        let no_odometry = |o: &LogError| {
            matches!(
                o,
                LogError::NoOdometry { .. } | LogError::NoSuchFrame { .. }
            )
        };
        let as_it_is = match (obstacles.is_empty(), in_part) {
            (true, _) => Replayable::Yes,
            (false, true) => Replayable::InPart,
            (false, false) => Replayable::WithSkeleton,
        };
        let replay = match outcome {
            Some(outcome) => Trial {
                possible: as_it_is,
                outcome: Some(outcome),
                ..Trial::none(config.clone())
            },
            None if sonars.is_empty() || obstacles.iter().any(no_odometry) => {
                Trial::none(config.clone())
            }
            None => Trial::run(log, config.clone(), odometry.as_ref(), as_it_is),
        };
        if let Some(outcome) = &replay.outcome {
            for sonar in &mut sonars {
                let scatter = outcome.scattering.of(sonar.id);
                sonar.scatter = scatter.map(|scatter| scatter.sigma);
            }
        }
        let (start_ns, end_ns) = span(&log.events.readings, &channels);
        Self {
            source: Source {
                file: log.file.clone(),
                messages: log.messages,
                start_ns,
                end_ns,
                complete: log.losses.is_empty() && replay.possible != Replayable::InPart,
                lost: log.losses.clone(),
                notes: Vec::new(),
            },
            replay,
            channels,
            sonars,
            odometry,
            clock_set: clock_set.clone(),
        }
    }
}

/// The mounts that sonars lack.
pub fn missing_mounts(obstacles: &[LogError]) -> Vec<&MissingMount> {
    let missing = obstacles.iter().filter_map(|obstacle| match obstacle {
        LogError::NoMount(missing) => Some(&**missing),
        _ => None,
    });
    missing.collect()
}

/// The sonars that lack a beam width.
pub fn without_beam(obstacles: &[LogError]) -> Vec<&str> {
    let sonars = obstacles.iter().filter_map(|obstacle| match obstacle {
        LogError::NoBeamWidth { sonar, .. } => Some(sonar.as_str()),
        _ => None,
    });
    sonars.collect()
}

fn span(readings: &Readings, channels: &[ChannelFacts]) -> (i64, i64) {
    match (readings.first(), readings.last()) {
        (Some(first), Some(last)) => (first.stamp_ns, last.stamp_ns),
        _ => (
            channels.iter().map(|c| c.first_ns).min().unwrap_or(0),
            channels.iter().map(|c| c.last_ns).max().unwrap_or(0),
        ),
    }
}

/// One channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelFacts {
    /// Its topic.
    pub topic: String,
    /// Its message type; empty for a channel without one.
    #[serde(rename = "type")]
    pub type_name: String,
    /// `cdr`, `json`, ...
    pub encoding: String,
    /// What its type is good for: `range`, `odometry`, `transform`; `None` for other types.
    pub role: Option<&'static str>,
    /// Whether its messages are used.
    pub used: bool,
    /// Its messages.
    pub messages: u64,
    /// Messages that could not be decoded.
    pub undecoded: u64,
    /// Why it, or the first message that could not be decoded, is not used.
    pub problem: Option<String>,
    /// Whether what it says is missing where it is not used.
    #[serde(skip)]
    pub wanted: bool,
    /// When its first message was recorded, nanoseconds.
    pub first_ns: i64,
    /// When its last message was recorded, nanoseconds.
    pub last_ns: i64,
    /// Messages per second of recording.
    #[serde(serialize_with = "optional")]
    pub rate: Option<f64>,
    /// Messages with a stamp other than 0.
    pub stamped: u64,
    /// Messages with the stamp 0.
    pub unstamped: u64,
    /// Messages stamped earlier than the one before them.
    pub backward_stamps: u64,
    /// Messages with the stamp of the one before them.
    pub repeated_stamps: u64,
    /// Messages that lie in the file behind a later one of their channel.
    pub out_of_order: u64,
    /// Time from stamp to recording in the middle of all, seconds.
    #[serde(serialize_with = "optional")]
    pub median_delay: Option<f64>,
    /// The time from stamp to recording that is farthest from 0, seconds.
    #[serde(serialize_with = "optional")]
    pub extreme_delay: Option<f64>,
    /// Within how much nine of ten delays lie, seconds.
    #[serde(skip)]
    pub delay_spread: f64,
    /// By how much delays grow in a second, and within how much nine of ten lie about that, seconds.
    #[serde(skip)]
    pub delay_growth: Option<(f64, f64)>,
}

/// The facts of every channel and its clock.
pub fn channels(reports: &[ChannelReport], clocks: &[ChannelClock]) -> Vec<ChannelFacts> {
    let seconds = |ns: i64| ns as f64 * 1e-9;
    reports
        .iter()
        .zip(clocks)
        .map(|(report, clock)| ChannelFacts {
            topic: report.topic.clone(),
            type_name: report.type_name.clone(),
            encoding: report.encoding.clone(),
            role: report.role.map(role_name),
            used: report.used,
            messages: report.messages,
            undecoded: report.undecoded,
            problem: report.problem.clone(),
            wanted: report.wanted,
            first_ns: clock.first_logged_ns,
            last_ns: clock.last_logged_ns,
            rate: clock.rate(),
            stamped: clock.stamped,
            unstamped: clock.unstamped,
            backward_stamps: clock.backward,
            repeated_stamps: clock.repeated,
            out_of_order: clock.out_of_order,
            median_delay: clock.median_delay_ns.map(seconds),
            extreme_delay: clock.extreme_delay_ns.map(seconds),
            delay_spread: seconds(clock.delay_spread_ns),
            delay_growth: clock
                .delay_growth
                .map(|(rate, about)| (rate, seconds(about))),
        })
        .collect()
}

fn role_name(role: Role) -> &'static str {
    match role {
        Role::Range => "range",
        Role::Odometry => "odometry",
        Role::Pose => "pose",
        Role::Description => "description",
        Role::Transform => "transform",
    }
}

impl ChannelFacts {
    /// Whether the file does not say of what type its messages are, and has to.
    pub fn is_untyped(&self) -> bool {
        self.type_name.is_empty() && self.problem.is_some()
    }

    /// A channel of a type that is read, but not in this form.
    pub fn is_unreadable(&self) -> bool {
        self.role.is_some() && !self.used && self.problem.is_some()
    }
}
