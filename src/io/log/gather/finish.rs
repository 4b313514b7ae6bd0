//! Puts together what was said.

use super::Gatherer;
use super::track::Chosen;
use crate::core::config::Config;
use crate::core::event::Events;
use crate::core::legible::one_line;
use crate::core::log::Log;
use crate::core::wording::{counted, counted_with};
use crate::io::log::channels::ChannelReport;
use crate::io::log::container::Loss;
use crate::io::log::messages::Role;
use crate::io::log::sonars::Placing;
use crate::io::log::stamps::{self, Clock, ClockSet};
use crate::io::log::{LogError, leaps, notes, outliers, repeats, strays};

/// A log that can be replayed.
#[derive(Debug)]
pub struct Finished {
    /// It; what was left out is among its losses.
    pub log: Log,
    /// What its channels are.
    pub channels: Vec<ChannelReport>,
    /// How the clock of its stamps was set while it was recorded.
    pub clock_set: Option<ClockSet>,
    /// What kept sonars out.
    pub left_out: Vec<LogError>,
    /// The topic that says where the robot was.
    pub odometry_topic: String,
}

/// Why a log cannot be replayed.
#[derive(Debug)]
pub struct Stopped {
    /// What is missing.
    pub error: LogError,
    /// What a person should know of the log all the same.
    notes: Vec<String>,
}

impl Stopped {
    /// The error with all that was found before it.
    pub fn into_error(self, losses: &[Loss]) -> LogError {
        self.error.noting(in_lines(self.notes)).after(losses)
    }
}

/// Each as one line: a name in it cannot look like another one.
fn in_lines(texts: Vec<String>) -> Vec<String> {
    let lines = texts.iter().map(|text| one_line(text).into_owned());
    lines.collect()
}

impl Gatherer {
    /// Puts everything together.
    ///
    /// # Errors
    /// When something is missing without which nothing can be replayed.
    pub fn finish(
        self,
        file: String,
        config: &Config,
        channels: Vec<ChannelReport>,
        losses: Vec<Loss>,
    ) -> Result<Finished, Box<Stopped>> {
        let mut notes = Vec::new();
        self.put_together(file, config, channels, losses, &mut notes)
            .map_err(|error| Box::new(Stopped { error, notes }))
    }

    fn put_together(
        mut self,
        file: String,
        config: &Config,
        mut channels: Vec<ChannelReport>,
        losses: Vec<Loss>,
        notes: &mut Vec<String>,
    ) -> Result<Finished, LogError> {
        notes.append(&mut self.notes);
        let no_ranges = |channels: &[ChannelReport]| LogError::NoRanges {
            file: file.clone(),
            asked: config.input.range_topics.clone(),
            found: notes::candidates(channels, &[Role::Range]),
        };
        if self.crowded {
            return Err(LogError::TooManySonars { file });
        }
        if self.readings.is_empty() && self.hits.is_empty() {
            for channel in channels.iter_mut() {
                let is_empty = channel.used && channel.role == Some(Role::Range);
                if is_empty && channel.problem.is_none() {
                    channel.problem = Some(notes::NO_RANGE.to_owned());
                }
            }
            return Err(no_ranges(&channels));
        }
        let mut odometry = self.choose_odometry(&file, config, &mut channels)?;
        let robot_frame = config
            .input
            .robot_frame
            .clone()
            .unwrap_or_else(|| odometry.robot_frame.clone());
        let unplaced = self.take_hits(config, &robot_frame, &odometry.world_frame, &mut channels);
        if self.crowded {
            return Err(LogError::TooManySonars { file });
        }
        if self.readings.is_empty() {
            return Err(unplaced.unwrap_or_else(|| no_ranges(&channels)));
        }
        notes.append(&mut self.notes);
        notes.extend(notes::on_channels(&channels));
        self.note(config, &channels, &odometry, notes);
        let mut lost = notes::on_losses(&losses, &channels);
        lost.append(&mut odometry.losses);
        lost.extend(strays::take_out(
            &mut self.sources,
            &mut self.readings,
            &self.transforms,
            config,
        ));
        lost.extend(outliers::readings(&self.sources, &mut self.readings));
        let placing = Placing {
            file: &file,
            odometry_topic: &odometry.topic,
            world_frame: &odometry.world_frame,
            robot_frame: &robot_frame,
            transforms: &self.transforms,
            config,
        };
        let placed = match placing.place(&self.sources, self.readings, notes) {
            Ok(placed) => placed,
            Err(error) => {
                // Messages that could not be read may have held what is missing.
                notes.extend(lost.into_iter().skip(losses.len()));
                return Err(error);
            }
        };
        let (sonars, mut readings) = (placed.sonars, placed.readings);
        lost.extend(placed.left_out.iter().map(ToString::to_string));
        let mut left_out: Vec<LogError> = placed.left_out.into_iter().map(|l| l.why).collect();
        left_out.extend(unplaced);
        let mut samples = odometry.samples;
        lost.extend(outliers::samples(
            &mut samples,
            &odometry.clock,
            &odometry.topic,
        ));
        notes.extend(stamps::twins(&readings));
        let ranges: Vec<&Clock> = self.sources.iter().map(|source| &source.clock).collect();
        let clock_set = stamps::jump(&ranges, &odometry.clock)
            .or_else(|| stamps::returned(&ranges, &odometry.clock));
        let mut time_notes: Vec<String> = clock_set.iter().map(ClockSet::text).collect();
        // Delays to a clock that was set say nothing of another clock.
        if clock_set.is_none() {
            time_notes.extend(stamps::skew(&ranges, &odometry.clock));
        }
        time_notes.extend(stamps::backward(&ranges, &odometry.clock));
        time_notes.extend(stamps::uncovered(&readings, &samples, &config.frames));
        time_notes.extend(leaps::note(
            leaps::window(&samples, &readings, config.input.start, config.input.end),
            &readings,
            clock_set.as_ref().map_or(&[], |set| &set.twice),
        ));
        let repeating = repeats::find(&readings, &samples, config.input.range_delay, sonars.len());
        let dropped = config.input.drop_repeats;
        notes.extend(repeats::note(&readings, &repeating, &sonars, dropped));
        if dropped {
            let mut repeating = repeating.into_iter();
            readings.retain(|_| repeating.next() != Some(true));
        }
        let mut events = Events {
            sonars,
            readings,
            odometry: samples,
        };
        events.sort();
        let log = Log {
            file,
            events,
            messages: self.messages + odometry.messages,
            losses: in_lines(lost),
            time_notes,
            notes: in_lines(std::mem::take(notes)),
        };
        Ok(Finished {
            log,
            channels,
            clock_set,
            left_out,
            odometry_topic: odometry.topic,
        })
    }

    /// What a person should know of what is used.
    fn note(
        &self,
        config: &Config,
        channels: &[ChannelReport],
        odometry: &Chosen,
        notes: &mut Vec<String>,
    ) {
        let unused = config
            .channel
            .keys()
            .filter(|topic| !channels.iter().any(|c| c.topic == **topic));
        notes.extend(unused.map(|topic| {
            format!("the configuration describes channel `{topic}`, which the log does not have")
        }));
        let unstamped = self.unstamped + odometry.unstamped;
        if unstamped > 0 {
            notes.push(format!(
                "{} no stamp in the header; the time of recording is taken",
                counted_with(unstamped, "message", "has", "have")
            ));
        }
        if odometry.unusable > 0 {
            notes.push(format!(
                "{} on {} without a pose (NaN, farther off than 100,000 km, or a quaternion of zero) left out",
                counted(odometry.unusable, "odometry message"),
                odometry.topic
            ));
        }
        notes.extend(self.transforms.note());
        if odometry.role == Role::Pose && config.input.odometry_topics.is_empty() {
            notes.push(format!(
                "the log has no odometry; the poses on {} are taken for it",
                odometry.topic
            ));
        }
        notes.extend(odometry.notes.iter().cloned());
    }
}
