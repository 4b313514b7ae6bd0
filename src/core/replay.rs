//! Runs a log through the machine and shows every step to the observers.

mod error;
mod outcome;

pub use error::ReplayError;
pub use outcome::Outcome;

use crate::core::config::{Config, Rule, SIGMA_UNKNOWN, Triple};
use crate::core::event::RangeReading;
use crate::core::frames::{Frame, Framer, Tally};
use crate::core::geometry::Vec2;
use crate::core::log::Log;
use crate::core::noise_estimate::{NoiseEstimator, VarianceFrom};
use crate::core::observer::{Observer, ObserverError, Setting, Source};
use crate::core::odometry::Track;
use crate::core::pattern::glob_set;
use crate::core::tmam::Tmam;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::prediction::{MapPrediction, Reach};
use outcome::associated;

/// A log made ready.
#[derive(Debug)]
pub struct Replay<'a> {
    log: &'a Log,
    config: Config,
    variance_from: VarianceFrom,
    source: Source,
    readings: &'a [RangeReading],
    selected: Vec<bool>,
}

impl<'a> Replay<'a> {
    /// Makes a log ready: selects the readings in the window and the sonars asked for.
    ///
    /// # Errors
    /// A selection without sonars, or a gate that does not fit their beams.
    pub fn new(log: &'a Log, config: &'a Config) -> Result<Self, ReplayError> {
        let all = log.events.readings.as_slice();
        let readings = window(all, config.input.start, config.input.end);
        let names = glob_set(&config.input.sonars)?;
        let sonars = &log.events.sonars;
        let selected: Vec<bool> = sonars
            .iter()
            .map(|sonar| names.is_empty() || names.is_match(&sonar.name))
            .collect();
        if !selected.contains(&true) {
            return Err(ReplayError::NoSuchSonar {
                asked: config.input.sonars.clone(),
                sonars: sonars.iter().map(|s| s.name.clone()).collect(),
            });
        }
        let is_selected = |r: &&RangeReading| selected.get(r.sonar.index()) == Some(&true);
        let narrowest = readings
            .iter()
            .filter(is_selected)
            .min_by(|a, b| a.beam_width.total_cmp(&b.beam_width));
        // Where angles do not decide, a gate that nobody asked for is no reason to refuse a log.
        let gamma = config.triple.gamma;
        let gated = !config.departures().label_by_opinion || gamma != Triple::default().gamma;
        let too_narrow = |r: &&RangeReading| gated && r.beam_width <= gamma;
        if let Some(reading) = narrowest.filter(too_narrow) {
            return Err(ReplayError::GammaBeyondBeam {
                gamma: config.triple.gamma,
                beam_width: reading.beam_width,
                sonar: sonars
                    .get(reading.sonar.index())
                    .map_or_else(String::new, |sonar| sonar.name.clone()),
            });
        }
        let source = Source {
            file: log.file.clone(),
            messages: log.messages,
            start_ns: readings.first().map_or(0, |r| r.stamp_ns),
            end_ns: readings.last().map_or(0, |r| r.stamp_ns),
            complete: log.losses.is_empty(),
            lost: log.losses.clone(),
            notes: log.told(),
        };
        let mut replay = Self {
            log,
            config: config.clone(),
            variance_from: VarianceFrom::of(readings.iter().filter(is_selected), config),
            source,
            readings,
            selected,
        };
        if replay.variance_from == VarianceFrom::Ranges {
            let scatter = replay.scattering().overall();
            if scatter.is_none() {
                replay.variance_from = VarianceFrom::Nothing;
            }
            let of_pose = config.noise.sigma_pose * config.noise.sigma_pose;
            let sigma = scatter.map_or(SIGMA_UNKNOWN, |scatter| scatter.believed(of_pose));
            replay.config.noise.sigma_abs = Some(sigma);
        }
        Ok(replay)
    }

    /// How far the ranges scatter: those of the whole log, so that what is looked at does not change
    /// what is seen.
    fn scattering(&self) -> NoiseEstimator {
        let mut scattering = NoiseEstimator::default();
        let events = &self.log.events;
        let every = vec![true; events.sonars.len()];
        // Nothing here can fail.
        let _ = self.frames_of(&events.readings, &every, |frame| {
            let arcs = (frame.entries.iter())
                .filter_map(|entry| Arc::of_entry(frame.index, entry, &self.config.noise));
            arcs.for_each(|arc| scattering.push(&arc));
            Ok(())
        });
        scattering
    }

    /// What stands fixed before the first frame.
    pub fn setting(&self) -> Setting<'_> {
        Setting {
            sonars: &self.log.events.sonars,
            config: &self.config,
            source: &self.source,
            start: (self.log.events.odometry.first())
                .map_or_else(Vec2::zeros, |sample| sample.world_from_robot.position()),
        }
    }

    /// Stamp of the log's first reading, in the window or not: what times are counted from.
    pub fn origin_ns(&self) -> i64 {
        let first = self.log.events.readings.first();
        first.map_or(0, |reading| reading.stamp_ns)
    }

    /// Every parameter in use, measured ones included.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The log.
    pub fn log(&self) -> &'a Log {
        self.log
    }

    /// The readings in the window of the sonars asked for.
    pub fn readings(&self) -> impl Iterator<Item = &'a RangeReading> {
        self.readings
            .iter()
            .filter(|reading| self.selected.get(reading.sonar.index()) == Some(&true))
    }

    /// Steps the machine over every frame.
    ///
    /// # Errors
    /// When an observer cannot write, or no frame could be opened.
    pub fn run(&self, observers: &mut [&mut dyn Observer]) -> Result<Outcome, ReplayError> {
        self.run_with_prediction(self.prediction(), observers)
    }

    /// [`Self::run`] with the prediction that judges the labels.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn run_with_prediction(
        &self,
        prediction: MapPrediction,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Outcome, ReplayError> {
        let mut tmam = Tmam::new(&self.config).with_prediction(prediction);
        let mut outcome = Outcome {
            variance_from: self.variance_from,
            ..Outcome::default()
        };
        let mut position = None;
        outcome.tally = self.frames(|frame| {
            let step = tmam.step(frame);
            outcome.take(&step);
            outcome.frames = frame.index + 1;
            let here = frame.world_from_robot.position();
            outcome.distance += position
                .replace(here)
                .map_or(0.0, |last| (here - last).norm());
            observers
                .iter_mut()
                .try_for_each(|observer| observer.frame(frame, &step))
        })?;
        if outcome.frames == 0 {
            return Err(self.no_frames(&outcome.tally));
        }
        let step = tmam.finish();
        outcome.take(&step);
        outcome.map = tmam.map().features().to_vec();
        outcome.associated_readings = associated(&outcome.extractions);
        for observer in observers {
            observer.finish(&step)?;
        }
        Ok(outcome)
    }

    /// Hands over every frame, in order.
    fn frames(
        &self,
        take: impl FnMut(&Frame) -> Result<(), ObserverError>,
    ) -> Result<Tally, ObserverError> {
        self.frames_of(self.readings, &self.selected, take)
    }

    fn frames_of(
        &self,
        readings: &[RangeReading],
        selected: &[bool],
        mut take: impl FnMut(&Frame) -> Result<(), ObserverError>,
    ) -> Result<Tally, ObserverError> {
        let events = &self.log.events;
        let track = Track::new(&events.odometry, &self.config.frames)
            .with_range_delay(self.config.input.range_delay);
        let mut framer = Framer::new(track, &events.sonars, selected, &self.config.frames);
        for reading in readings {
            if let Some(frame) = framer.push(reading) {
                take(&frame)?;
            }
        }
        let (last, tally) = framer.finish();
        last.iter().try_for_each(take)?;
        Ok(tally)
    }

    /// The map that the noise-aware rule makes of the whole log, to judge labels by.
    pub fn prediction(&self) -> MapPrediction {
        let config = Config {
            rule: Rule::NoiseAware,
            ..self.config.clone()
        };
        let mut tmam = Tmam::new(&config);
        // Nothing here can fail.
        let _ = self.frames(|frame| {
            tmam.step(frame);
            Ok(())
        });
        tmam.finish();
        MapPrediction::new(tmam.map().features(), &Reach::of(config.map.max_wall_gap))
    }

    fn no_frames(&self, tally: &Tally) -> ReplayError {
        let all = &self.log.events.readings;
        if let (Some(first), Some(last), true) = (all.first(), all.last(), self.readings.is_empty())
        {
            return ReplayError::EmptyWindow {
                readings: all.len(),
                seconds: last.stamp_ns.saturating_sub(first.stamp_ns) as f64 * 1e-9,
            };
        }
        let stamps = |of: &[i64]| match (of.first(), of.last()) {
            (Some(first), Some(last)) => format!(
                "{:.3} s to {:.3} s",
                *first as f64 * 1e-9,
                *last as f64 * 1e-9
            ),
            _ => "none".to_owned(),
        };
        let odometry: Vec<i64> = self
            .log
            .events
            .odometry
            .iter()
            .map(|s| s.stamp_ns)
            .collect();
        let readings: Vec<i64> = self.readings.iter().map(|r| r.stamp_ns).collect();
        let gaps = tally.dropped.contains_key("odometry-gap");
        ReplayError::NoFrames {
            readings: tally.readings,
            ranges: stamps(&readings),
            samples: odometry.len(),
            odometry: stamps(&odometry),
            advice: if gaps {
                "The odometry is too sparse: raise frames.max_odometry_gap in the configuration"
            } else {
                "The two do not overlap in time: check the clocks of the robot's computers"
            },
        }
    }
}

/// The readings from `start` to `end` seconds after the first one.
fn window(readings: &[RangeReading], start: Option<f64>, end: Option<f64>) -> &[RangeReading] {
    let Some(first) = readings.first().map(|r| r.stamp_ns) else {
        return readings;
    };
    let seconds = |r: &RangeReading| r.stamp_ns.saturating_sub(first) as f64 * 1e-9;
    let from = start.map_or(0, |start| readings.partition_point(|r| seconds(r) < start));
    let to = end.map_or(readings.len(), |end| {
        readings.partition_point(|r| seconds(r) <= end)
    });
    readings.get(from..to).unwrap_or_default()
}
