//! A look at a log that goes past what would stop a replay.
//!
//! Whatever [`read`](super::read) would refuse is noted, a placeholder put in its place, and the
//! rest put together all the same. So the placeholders are exactly what a configuration has to
//! give, and it is known that a replay can begin with them.

use std::collections::BTreeMap;
use std::path::Path;

use super::assemble::{Finished, assemble};
use super::channels::{ChannelReport, Channels};
use super::container::{self, Loss};
use super::error::LogError;
use super::gather::{Gatherer, STAND_IN};
use super::message::{Content, Role};
use super::read::{file_name, take_mounts_from, unchecked};
use super::sonars::UNUSED;
use super::stamps::ClockSet;
use super::traits::Traits;
use super::truth::RecordedTruth;
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
    /// What the log says besides.
    pub traits: Traits,
}

/// Looks at a log.
///
/// # Errors
/// A file that cannot be read or is no MCAP file, and a configuration that is not allowed.
pub fn survey(path: &Path, config: &Config) -> Result<Survey, LogError> {
    let (gathered, channels, losses, clocks) = look(path, config, None, false)?;
    let mending = Mending {
        file: file_name(path),
        config: config.clone(),
        gatherer: gathered,
        obstacles: Vec::new(),
        odometry_topic: odometry_topic(&channels),
        no_ranges: false,
        no_odometry: false,
        in_part: false,
        has_described: !config.sonar.is_empty(),
    };
    mending.finish(&channels, &losses, clocks)
}

/// Looks at a log as [`read`](super::read) reads it, past nothing that stops a replay.
///
/// # Errors
/// As [`read`](super::read).
pub fn as_it_is(path: &Path, config: &Config) -> Result<Survey, LogError> {
    as_it_is_with(path, config, None, false)
}

/// The same, and the truth that the log carries; with `ahead`, the next part of the file is unpacked on a thread while
/// the last one is decoded.
///
/// # Errors
/// As [`read`](super::read).
pub fn as_it_is_with(
    path: &Path,
    config: &Config,
    truth: Option<&mut RecordedTruth>,
    ahead: bool,
) -> Result<Survey, LogError> {
    let (gathered, channels, losses, clocks) = look(path, config, truth, ahead)?;
    let finished = assemble(gathered, file_name(path), config, channels, &losses);
    let finished = finished.map_err(|stopped| stopped.into_error(&losses))?;
    Ok(Survey {
        log: finished.log,
        channels: finished.channels,
        clock_set: finished.clock_set,
        config: config.clone(),
        in_part: !finished.left_out.is_empty(),
        obstacles: finished.left_out,
        clocks,
        odometry_topic: Some(finished.odometry_topic),
        traits: finished.traits,
    })
}

/// What a log says, its channels, what is lost of it, and its clocks.
type Looked = (Gatherer, Vec<ChannelReport>, Vec<Loss>, Vec<ChannelClock>);

fn look(
    path: &Path,
    config: &Config,
    mut truth: Option<&mut RecordedTruth>,
    ahead: bool,
) -> Result<Looked, LogError> {
    let mut channels = Channels::new(config)?;
    let mut gatherer = Gatherer::new(config);
    take_mounts_from(config, &mut gatherer)?;
    let mut clocks = Clocks::default();
    let losses = container::walk_with(path, unchecked(config), ahead, &mut |channel, message| {
        let read = channels.read(channel, message);
        let stamp = read.as_ref().and_then(|read| stamp(&read.content));
        clocks.take(channel.id, message.log_time, stamp);
        if let Some(truth) = &mut truth {
            truth.take(channel, message);
        }
        if let Some(read) = read {
            gatherer.take(read, message.log_time);
        }
    })
    .map_err(|error| LogError::open(path, error))?;
    let file = file_name(path);
    let (channels, clocks) = together(channels.into_reports(&file)?, clocks);
    Ok((gatherer, channels, losses, clocks))
}

/// The stamp that a message carries; none for transforms, as those that never move are stamped in
/// every way.
fn stamp(content: &Content<'_>) -> Option<i64> {
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
        channel.used && matches!(channel.role, Some(Role::Odometry | Role::Pose))
    };
    // Odometry before poses, then the busiest; of equally busy ones the first by name.
    let rank = |channel: &&ChannelReport| {
        let read = channel.messages.saturating_sub(channel.undecoded);
        (channel.role, std::cmp::Reverse(read))
    };
    let first = channels.iter().filter(moves).min_by_key(rank);
    first.map(|channel| channel.topic.clone())
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
    /// Whether the configuration given describes sonars: placeholders are none of the user's.
    has_described: bool,
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
                Ok(mut finished) => {
                    self.in_part |= self.obstacles.is_empty() && !finished.left_out.is_empty();
                    self.odometry_topic = Some(finished.odometry_topic.clone());
                    let known = self.obstacles.len();
                    for obstacle in std::mem::take(&mut finished.left_out) {
                        // Where there is no way past it, the sonar stays out.
                        let is_known = self.config.input.robot_frame.is_some()
                            && matches!(obstacle, LogError::NoRobotFrame { .. });
                        if !is_known {
                            let _ = self.mend(obstacle);
                        }
                    }
                    if self.obstacles.len() == known {
                        return Ok(self.survey(finished, clocks));
                    }
                }
                Err(stopped) => self.mend(stopped.error)?,
            }
        }
    }

    fn survey(mut self, finished: Finished, clocks: Vec<ChannelClock>) -> Survey {
        let mut log = finished.log;
        if !self.has_described {
            log.notes.retain(|note| !note.starts_with(UNUSED));
        }
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
            channels: finished.channels,
            clock_set: finished.clock_set,
            config: self.config,
            obstacles: self.obstacles,
            in_part: self.in_part,
            clocks,
            odometry_topic: self.odometry_topic,
            traits: finished.traits,
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
                    Some(likely_robot_frame(&self.gatherer.namespaces.frames()));
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

/// The clock of one channel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChannelClock {
    /// Its messages, read or not.
    pub messages: u64,
    /// When its earliest message was recorded, nanoseconds.
    pub first_logged_ns: i64,
    /// When its latest message was recorded, nanoseconds.
    pub last_logged_ns: i64,
    /// Messages that lie in the file behind one of this channel that was recorded later.
    pub out_of_order: u64,
    /// Messages whose header has a stamp other than 0.
    pub stamped: u64,
    /// Messages whose header has the stamp 0.
    pub unstamped: u64,
    /// Messages stamped earlier than the one before them.
    pub backward: u64,
    /// Messages with the stamp of the one before them.
    pub repeated: u64,
    /// Time from stamp to recording in the middle of all, nanoseconds.
    pub median_delay_ns: Option<i64>,
    /// The time from stamp to recording that is farthest from 0, nanoseconds.
    pub extreme_delay_ns: Option<i64>,
    /// Within how much nine of ten delays lie, nanoseconds.
    pub delay_spread_ns: i64,
    /// By how much delays grow, as a share of the time that passes, and how many nanoseconds they scatter about
    /// that.
    pub delay_growth: Option<(f64, i64)>,
}

/// The clocks of a log while it is read, by the numbers of their channels.
#[derive(Debug, Default)]
pub struct Clocks(BTreeMap<u16, Running>);

#[derive(Debug, Default)]
struct Running {
    clock: ChannelClock,
    last_stamp: Option<i64>,
    delays: Vec<i64>,
    /// When each of them was recorded.
    logged: Vec<i64>,
}

impl Clocks {
    /// Takes a message: when it was recorded and, where it was read, the stamp of its header.
    pub fn take(&mut self, channel: u16, log_time: u64, stamp_ns: Option<i64>) {
        let running = self.0.entry(channel).or_default();
        running.take(i64::try_from(log_time).unwrap_or(i64::MAX), stamp_ns);
    }

    /// The clock of a channel.
    pub fn finish(&mut self, channel: u16) -> ChannelClock {
        self.0.remove(&channel).unwrap_or_default().finish()
    }
}

impl Running {
    fn take(&mut self, logged_ns: i64, stamp_ns: Option<i64>) {
        let clock = &mut self.clock;
        if clock.messages == 0 {
            (clock.first_logged_ns, clock.last_logged_ns) = (logged_ns, logged_ns);
        }
        clock.messages += 1;
        clock.out_of_order += u64::from(logged_ns < clock.last_logged_ns);
        clock.first_logged_ns = clock.first_logged_ns.min(logged_ns);
        clock.last_logged_ns = clock.last_logged_ns.max(logged_ns);
        match stamp_ns {
            None => {}
            Some(0) => clock.unstamped += 1,
            Some(stamp) => {
                clock.stamped += 1;
                clock.backward += u64::from(self.last_stamp.is_some_and(|last| stamp < last));
                clock.repeated += u64::from(self.last_stamp == Some(stamp));
                self.last_stamp = Some(stamp);
                self.delays.push(logged_ns.saturating_sub(stamp));
                self.logged.push(logged_ns);
            }
        }
    }

    fn finish(mut self) -> ChannelClock {
        let delay_growth = growth(&self.logged, &self.delays);
        let delays = &mut self.delays;
        let extremes = [delays.iter().min(), delays.iter().max()];
        let extreme_delay_ns = extremes
            .into_iter()
            .flatten()
            .copied()
            .max_by_key(|delay| delay.unsigned_abs());
        let ends = ranked(delays, 1).zip(ranked(delays, 19));
        ChannelClock {
            delay_growth,
            delay_spread_ns: ends.map_or(0, |(low, high)| high.saturating_sub(low)),
            median_delay_ns: ranked(delays, 10),
            extreme_delay_ns,
            ..self.clock
        }
    }
}

/// The value that so many twentieths of all are below. To sort them would take longer.
fn ranked(values: &mut [i64], twentieths: usize) -> Option<i64> {
    let rank = values.len() * twentieths / 20;
    (rank < values.len()).then(|| *values.select_nth_unstable(rank).1)
}

/// Fewer messages than this show no growth.
const ENOUGH: usize = 20;

/// By how much delays grow with the time of recording, from the middle of those of the first third to that of the
/// last, and how far nine of ten lie apart about that line.
fn growth(logged: &[i64], delays: &[i64]) -> Option<(f64, i64)> {
    let third = delays.len() / 3;
    if delays.len() < ENOUGH {
        return None;
    }
    let middle = |values: &[i64]| ranked(&mut values.to_vec(), 10);
    let ends = |values: &[i64]| {
        let (first, last) = (values.get(..third)?, values.get(values.len() - third..)?);
        Some((middle(first)?, middle(last)?))
    };
    let ((from, to), (low, high)) = (ends(logged)?, ends(delays)?);
    let passed = to.saturating_sub(from);
    if passed <= 0 {
        return None;
    }
    let rate = high.saturating_sub(low) as f64 / passed as f64;
    let about = logged.iter().zip(delays).map(|(logged, delay)| {
        let expected = rate * logged.saturating_sub(from) as f64;
        delay.saturating_sub(low).saturating_sub(expected as i64)
    });
    let mut about: Vec<i64> = about.collect();
    let ends = ranked(&mut about, 1).zip(ranked(&mut about, 19));
    ends.map(|(low, high)| (rate, high.saturating_sub(low)))
}

impl ChannelClock {
    /// Two channels seen as one; the median is that of the busier one.
    pub fn together(self, other: Self) -> Self {
        let busier = if other.stamped > self.stamped {
            &other
        } else {
            &self
        };
        let extremes = self
            .extreme_delay_ns
            .into_iter()
            .chain(other.extreme_delay_ns);
        Self {
            messages: self.messages + other.messages,
            first_logged_ns: self.first_logged_ns.min(other.first_logged_ns),
            last_logged_ns: self.last_logged_ns.max(other.last_logged_ns),
            out_of_order: self.out_of_order + other.out_of_order,
            stamped: self.stamped + other.stamped,
            unstamped: self.unstamped + other.unstamped,
            backward: self.backward + other.backward,
            repeated: self.repeated + other.repeated,
            median_delay_ns: busier.median_delay_ns,
            delay_spread_ns: busier.delay_spread_ns,
            delay_growth: busier.delay_growth,
            extreme_delay_ns: extremes.max_by_key(|delay| delay.unsigned_abs()),
        }
    }

    /// Messages per second of recording; `None` where no time passed.
    pub fn rate(&self) -> Option<f64> {
        let seconds = self.last_logged_ns.saturating_sub(self.first_logged_ns) as f64 * 1e-9;
        (seconds > 0.0).then(|| self.messages.saturating_sub(1) as f64 / seconds)
    }
}

#[cfg(test)]
mod tests;
