//! What a log holds, counted and measured.

use serde::Serialize;

use super::channels::{self, ChannelFacts};
use super::odometry::{self, OdometryFacts};
use super::sonars::{self, SonarFacts};
use super::trial::{Replayable, Trial};
use crate::core::event::RangeReading;
use crate::core::observer::Source;
use crate::io::log::survey::Survey;
use crate::io::log::{ClockSet, LogError};

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
    /// The facts of a surveyed log that meets these obstacles.
    pub fn new(survey: Survey, obstacles: &[LogError]) -> Self {
        let Survey {
            log,
            channels,
            clock_set,
            config,
            in_part,
            clocks,
            odometry_topic,
            ..
        } = survey;
        let channels = channels::channels(&channels, &clocks);
        let mut sonars = sonars::sonars(&log.events, &config);
        for obstacle in obstacles {
            forget_placeholder(&mut sonars, obstacle);
        }
        let odometry = odometry::odometry(
            odometry_topic.as_deref(),
            &log.events,
            clock_set.as_ref().map_or(&[], |set| &set.twice),
            &config,
        );
        let no_odometry = |o: &LogError| {
            matches!(
                o,
                LogError::NoOdometry { .. } | LogError::NoSuchFrame { .. }
            )
        };
        let replay = if sonars.is_empty() || obstacles.iter().any(no_odometry) {
            Trial::none(config)
        } else {
            let as_it_is = match (obstacles.is_empty(), in_part) {
                (true, _) => Replayable::Yes,
                (false, true) => Replayable::InPart,
                (false, false) => Replayable::WithSkeleton,
            };
            Trial::run(&log, config, odometry.as_ref(), as_it_is)
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
                file: log.file,
                messages: log.messages,
                start_ns,
                end_ns,
                complete: log.losses.is_empty() && replay.possible != Replayable::InPart,
                lost: log.losses,
                notes: Vec::new(),
            },
            replay,
            channels,
            sonars,
            odometry,
            clock_set,
        }
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

fn span(readings: &[RangeReading], channels: &[ChannelFacts]) -> (i64, i64) {
    match (readings.first(), readings.last()) {
        (Some(first), Some(last)) => (first.stamp_ns, last.stamp_ns),
        _ => (
            channels.iter().map(|c| c.first_ns).min().unwrap_or(0),
            channels.iter().map(|c| c.last_ns).max().unwrap_or(0),
        ),
    }
}
