//! A look at a log that goes past what would stop a replay.
//!
//! Whatever [`read`](super::read) would refuse is noted, a placeholder put in its place, and the
//! rest put together all the same. So the placeholders are exactly what a configuration has to
//! give, and it is known that a replay can begin with them.

use std::collections::BTreeMap;
use std::path::Path;

use super::assemble::assemble;
use super::budget::Budget;
use super::channels::{ChannelReport, Channels};
use super::clock::{ChannelClock, Clocks};
use super::container::{self, Loss};
use super::error::LogError;
use super::gather::{Gatherer, STAND_IN};
use super::message::{Content, Role};
use super::read::{file_name, length, unchecked};
use super::stamps::ClockSet;
use crate::core::config::{Config, SonarOverride};
use crate::core::log::Log;

/// Beam width put in the place of one that is not known, radians: the paper's.
pub const PLACEHOLDER_BEAM_WIDTH: f64 = 22.5 * std::f64::consts::PI / 180.0;

/// Farthest range put in the place of one that is not known, metres.
pub const PLACEHOLDER_MAX_RANGE: f64 = 5.0;

/// A log with more obstacles than this is shown without its sonars.
const MOST_OBSTACLES: usize = 512;

/// A log as far as it can be told what it holds.
#[derive(Debug)]
pub struct Survey {
    /// What could be put together with [`config`](Self::config); no sonars where nothing gives
    /// ranges, no odometry samples where nothing gives odometry.
    pub log: Log,
    /// What its channels are.
    pub channels: Vec<ChannelReport>,
    /// How the clock of its stamps was set while it was recorded.
    pub clock_set: Option<ClockSet>,
    /// The configuration given, and placeholders for what is missing.
    pub config: Config,
    /// What a replay with the configuration given would refuse, one after the other.
    pub obstacles: Vec<LogError>,
    /// Whether a replay goes without some of the sonars.
    pub in_part: bool,
    /// When the messages of each of the log's channels came.
    pub clocks: Vec<ChannelClock>,
    /// The topic whose odometry is used.
    pub odometry_topic: Option<String>,
}

/// Looks at a log.
///
/// # Errors
/// A file that cannot be read or is no MCAP file, and a configuration that is not allowed.
pub fn survey(path: &Path, config: &Config) -> Result<Survey, LogError> {
    let mut channels = Channels::new(config)?;
    let mut gatherer = Gatherer::default();
    let mut clocks = Clocks::default();
    let mut budget = Budget::new(config, length(path));
    let losses = container::walk(path, unchecked(config), &mut |channel, message| {
        let read = channels.read(channel, message, &mut budget);
        let stamp = read.as_ref().and_then(|read| stamp(&read.content));
        clocks.take(channel.id, message.log_time, stamp);
        if let Some(read) = read {
            gatherer.take(read, message.log_time);
        }
    })
    .map_err(|error| LogError::open(path, error))?;
    budget.check(&file_name(path))?;
    let (channels, clocks) = together(channels.into_reports(), clocks);
    let mending = Mending {
        file: file_name(path),
        config: config.clone(),
        gatherer,
        obstacles: Vec::new(),
        odometry_topic: odometry_topic(&channels),
        no_ranges: false,
        no_odometry: false,
        in_part: false,
    };
    mending.finish(&channels, &losses, clocks)
}

/// The stamp that a message carries; none for transforms, as those that never move are stamped in
/// every way.
fn stamp(content: &Content) -> Option<i64> {
    match content {
        Content::Ranges(ranges) => ranges.first().map(|range| range.stamp_ns),
        Content::Odometry(odometry) => Some(odometry.stamp_ns),
        Content::Hits(hits) => Some(hits.stamp_ns),
        Content::Transforms(_) | Content::Description(_) | Content::Crowd(_) => None,
    }
}

/// The channels with their clocks, one of each where several publishers fill one topic.
fn together(
    reports: Vec<ChannelReport>,
    mut clocks: Clocks,
) -> (Vec<ChannelReport>, Vec<ChannelClock>) {
    let mut all: Vec<(ChannelReport, ChannelClock)> = Vec::with_capacity(reports.len());
    let mut places: BTreeMap<[String; 3], usize> = BTreeMap::new();
    for report in reports {
        let clock = clocks.finish(report.id);
        let names = [&report.topic, &report.type_name, &report.encoding].map(Clone::clone);
        let place = *places.entry(names).or_insert(all.len());
        match all.get_mut(place) {
            Some((known, known_clock)) => {
                known.messages += report.messages;
                known.undecoded += report.undecoded;
                known.problem = known.problem.take().or(report.problem);
                *known_clock = std::mem::take(known_clock).together(clock);
            }
            None => all.push((report, clock)),
        }
    }
    all.into_iter().unzip()
}

fn odometry_topic(channels: &[ChannelReport]) -> Option<String> {
    let moves = |channel: &&ChannelReport| {
        channel.used && !matches!(channel.role, None | Some(Role::Range | Role::Transform))
    };
    // The busiest; of equally busy ones the first by name.
    channels
        .iter()
        .filter(moves)
        .min_by_key(|channel| std::cmp::Reverse(channel.messages.saturating_sub(channel.undecoded)))
        .map(|channel| channel.topic.clone())
}

/// A survey while one obstacle after the other is cleared away.
struct Mending {
    file: String,
    config: Config,
    gatherer: Gatherer,
    obstacles: Vec<LogError>,
    odometry_topic: Option<String>,
    no_ranges: bool,
    no_odometry: bool,
    /// Whether a log came of it before anything was mended.
    in_part: bool,
}

impl Mending {
    fn finish(
        mut self,
        channels: &[ChannelReport],
        losses: &[Loss],
        clocks: Vec<ChannelClock>,
    ) -> Result<Survey, LogError> {
        loop {
            let attempt = assemble(
                self.gatherer.clone(),
                self.file.clone(),
                &self.config,
                channels.to_vec(),
                losses,
            );
            match attempt {
                Ok(finished) => {
                    self.in_part |= self.obstacles.is_empty() && !finished.left_out.is_empty();
                    self.odometry_topic = Some(finished.odometry_topic);
                    let known = self.obstacles.len();
                    for obstacle in finished.left_out {
                        // Where there is no way past it, the sonar stays out.
                        let is_known = self.config.input.robot_frame.is_some()
                            && matches!(obstacle, LogError::NoRobotFrame { .. });
                        if !is_known {
                            let _ = self.mend(obstacle);
                        }
                    }
                    if self.obstacles.len() == known {
                        return Ok(self.survey(
                            finished.log,
                            finished.channels,
                            finished.clock_set,
                            clocks,
                        ));
                    }
                }
                Err(stopped) => self.mend(stopped.error)?,
            }
        }
    }

    fn survey(
        mut self,
        mut log: Log,
        channels: Vec<ChannelReport>,
        clock_set: Option<ClockSet>,
        clocks: Vec<ChannelClock>,
    ) -> Survey {
        if self.no_ranges {
            log.events.sonars.clear();
            log.events.readings.clear();
            self.config.sonar.remove(STAND_IN);
        }
        if self.no_odometry {
            log.events.odometry.clear();
            log.messages = log.messages.saturating_sub(1); // the one that stood in
            log.notes.retain(|note| !note.starts_with(STAND_IN));
            self.odometry_topic = None;
        }
        Survey {
            log,
            channels,
            clock_set,
            config: self.config,
            obstacles: self.obstacles,
            in_part: self.in_part,
            clocks,
            odometry_topic: self.odometry_topic,
        }
    }

    /// Clears an obstacle away and notes it.
    ///
    /// # Errors
    /// The obstacle, where there is no way past it.
    fn mend(&mut self, obstacle: LogError) -> Result<(), LogError> {
        let too_many = self.obstacles.len() >= MOST_OBSTACLES;
        match &obstacle {
            LogError::NoMount(missing) if !too_many => {
                let known = self.sonar(&missing.sonar);
                (known.x, known.y, known.yaw) = (Some(0.0), Some(0.0), Some(0.0));
            }
            LogError::UnplacedRing(ring) if !too_many => {
                for (index, direction) in ring.directions.iter().enumerate() {
                    let known = self.sonar(&ring.name(index));
                    (known.x, known.y, known.yaw) = (Some(0.0), Some(0.0), Some(*direction));
                    known.beam_width.get_or_insert(PLACEHOLDER_BEAM_WIDTH);
                    known.max_range.get_or_insert(PLACEHOLDER_MAX_RANGE);
                }
            }
            LogError::UnclearTransforms { moving, .. }
                if self.config.input.robot_frame.is_none() =>
            {
                let frame = moving.first().map(|(_, child)| child.clone());
                self.config.input.robot_frame = frame;
            }
            LogError::NoBeamWidth { sonar, .. } if !too_many => {
                self.sonar(sonar).beam_width = Some(PLACEHOLDER_BEAM_WIDTH);
            }
            LogError::ManyOdometries { topics, .. } => {
                let chosen = self.odometry_topic.clone().or(topics.first().cloned());
                let chosen = chosen.unwrap_or_default();
                self.gatherer.keep_odometry(&chosen);
                self.config.input.odometry_topics = vec![globset::escape(&chosen)];
            }
            LogError::NoRobotFrame { .. } if self.config.input.robot_frame.is_none() => {
                self.config.input.robot_frame =
                    Some(likely_robot_frame(&self.gatherer.transforms.frames()));
                if self.no_odometry {
                    return Ok(()); // follows from that
                }
            }
            LogError::NoOdometry { .. } | LogError::NoSuchFrame { .. } if !self.no_odometry => {
                self.no_odometry = true;
                self.config.input.world_frame = None; // what stands in has none
                self.gatherer.stand_in(Role::Odometry);
            }
            LogError::NoRanges { .. }
            | LogError::NoMount(_)
            | LogError::NoBeamWidth { .. }
            | LogError::UnplacedRing(_)
            | LogError::TooManySonars { .. }
                if !self.no_ranges =>
            {
                self.no_ranges = true;
                self.gatherer.stand_in(Role::Range);
                let known = self.sonar(STAND_IN);
                (known.x, known.y, known.yaw) = (Some(0.0), Some(0.0), Some(0.0));
            }
            _ => return Err(obstacle),
        }
        self.obstacles.push(obstacle);
        Ok(())
    }

    fn sonar(&mut self, name: &str) -> &mut SonarOverride {
        self.config.sonar.entry(name.to_owned()).or_default()
    }
}

fn likely_robot_frame(frames: &[&str]) -> String {
    ["base_link", "base_footprint"]
        .into_iter()
        .find(|name| frames.contains(name))
        .or_else(|| frames.iter().copied().find(|name| name.contains("base")))
        .unwrap_or("base_link")
        .to_owned()
}

#[cfg(test)]
mod tests;
