//! What a log holds and whether it can be replayed.
//!
//! [`Info`] goes as far as the log does: what stands in the way of a replay becomes a [`Finding`],
//! and what a configuration can mend becomes a line of the [`skeleton`]. It reads events, not
//! files, and is shown as [`text`] for people or as [`json`] for machines.

pub mod channels;
pub mod findings;
pub mod json;
pub mod motion;
pub mod resolution;
pub mod skeleton;
pub mod sonars;
mod statistics;
pub(crate) mod tables;
pub mod text;
pub mod trial;

use crate::core::event::SonarId;
use crate::io::log::survey::Survey;
use crate::io::log::{ClockSet, LogError};
use channels::ChannelFacts;
use findings::Finding;
use motion::OdometryFacts;
use sonars::SonarFacts;
use trial::Trial;

/// Everything that is told of a log.
#[derive(Debug)]
pub struct Info {
    /// Its file name, without directories.
    pub file: String,
    /// Messages that were used.
    pub messages: u64,
    /// Stamp of the first reading, or recording of the first message without one, nanoseconds.
    pub start_ns: i64,
    /// Of the last one, nanoseconds.
    pub end_ns: i64,
    /// What could not be read; empty for a whole log.
    pub losses: Vec<String>,
    /// How the clock of its stamps was set while it was recorded.
    pub clock_set: Option<ClockSet>,
    /// Its channels, by topic.
    pub channels: Vec<ChannelFacts>,
    /// Its sonars, by name.
    pub sonars: Vec<SonarFacts>,
    /// Where the robot was.
    pub odometry: Option<OdometryFacts>,
    /// What a replay comes to.
    pub trial: Trial,
    /// Whether it can be replayed.
    pub verdict: Verdict,
    /// What a person should know, the weightiest first.
    pub findings: Vec<Finding>,
    /// What the configuration lacks.
    pub skeleton: Option<String>,
}

/// Whether a log can be replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// As it is.
    Yes,
    /// Without some of its sonars; with the keys of the skeleton whole.
    InPart,
    /// With the keys of the skeleton.
    WithSkeleton,
    /// Not by any configuration.
    No,
}

impl Info {
    /// Tells all of a surveyed log.
    pub fn new(survey: Survey) -> Self {
        let Survey {
            log,
            channels,
            clock_set,
            config,
            obstacles,
            in_part,
            clocks,
            odometry_topic,
        } = survey;
        let channels = channels::channels(&channels, &clocks);
        let mut sonars = sonars::sonars(&log.events, &config);
        for obstacle in &obstacles {
            forget_placeholder(&mut sonars, obstacle);
        }
        let no_odometry = |o: &LogError| {
            matches!(
                o,
                LogError::NoOdometry { .. } | LogError::NoSuchFrame { .. }
            )
        };
        let blind = sonars.is_empty() || obstacles.iter().any(no_odometry);
        let odometry = motion::odometry(
            odometry_topic.as_deref(),
            &log.events,
            clock_set.as_ref().map_or(&[], |set| &set.twice),
            &config,
        );
        let trial = if blind {
            Trial::none(config)
        } else {
            Trial::run(&log, config, odometry.as_ref())
        };
        if let Some(outcome) = &trial.outcome {
            for sonar in &mut sonars {
                let id = (log.events.sonars.iter()).position(|s| s.name == sonar.name);
                let id = id.and_then(|id| u16::try_from(id).ok()).map(SonarId);
                let scatter = id.and_then(|id| outcome.scattering.of(id));
                sonar.scatter = scatter.map(|scatter| scatter.sigma);
            }
        }
        let verdict = match (
            &trial.outcome,
            obstacles.is_empty(),
            trial.refused.is_empty(),
        ) {
            (Some(_), true, true) => Verdict::Yes,
            (Some(_), false, true) if in_part => Verdict::InPart,
            (Some(_), ..) => Verdict::WithSkeleton,
            (None, ..) => Verdict::No,
        };
        let (start_ns, end_ns) = span(&log.events.readings, &channels);
        let mut info = Self {
            file: log.file,
            messages: log.messages,
            start_ns,
            end_ns,
            losses: log.losses,
            clock_set,
            channels,
            sonars,
            odometry,
            trial,
            verdict,
            findings: Vec::new(),
            skeleton: None,
        };
        info.skeleton = skeleton::skeleton(&info, &obstacles);
        info.findings = findings::findings(&info, &obstacles, &log.notes);
        info
    }

    /// Whether all of it could be read and is used.
    pub fn is_complete(&self) -> bool {
        self.losses.is_empty() && self.verdict != Verdict::InPart
    }

    /// Whether the log is whole, can be replayed as it is, and holds an echo.
    pub fn is_fine(&self) -> bool {
        let echoes = self.trial.outcome.as_ref().map_or(0, |o| o.tally.echoes);
        self.verdict == Verdict::Yes && self.losses.is_empty() && echoes > 0
    }
}

/// What a placeholder stands for is not known.
fn forget_placeholder(sonars: &mut [SonarFacts], obstacle: &LogError) {
    let (name, is_mount) = match obstacle {
        LogError::NoMount(missing) => (&missing.sonar, true),
        LogError::NoBeamWidth { sonar, .. } => (sonar, false),
        _ => return,
    };
    for sonar in sonars.iter_mut().filter(|sonar| sonar.name == *name) {
        if is_mount {
            sonar.mount = None;
        } else {
            sonar.beam_width = None;
        }
    }
}

fn span(readings: &[crate::core::event::RangeReading], channels: &[ChannelFacts]) -> (i64, i64) {
    match readings {
        [first, .., last] => (first.stamp_ns, last.stamp_ns),
        [only] => (only.stamp_ns, only.stamp_ns),
        [] => (
            channels.iter().map(|c| c.first_ns).min().unwrap_or(0),
            channels.iter().map(|c| c.last_ns).max().unwrap_or(0),
        ),
    }
}

#[cfg(test)]
mod tests;
