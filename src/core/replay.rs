//! Runs a log through the machine and shows every step to the observers.

mod error;
mod growing;
mod outcome;
mod stretch;

pub use error::ReplayError;
pub use outcome::{CauseTold, Outcome};
pub use stretch::Stretch;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc as Shared, OnceLock};

use crate::core::config::{Config, Method, Poses, Rule, SIGMA_UNKNOWN, Triple};
use crate::core::digest::sha256;
use crate::core::event::{Events, OdometrySample, RangeReading, Readings, name_of};
use crate::core::frames::{Frame, Framer, Tally};
use crate::core::geometry::{Pose2, Vec2};
use crate::core::joint::path::CorrectedPath;
use crate::core::joint::{self, Evidence, JointEstimate, OdometryKept};
use crate::core::log::Log;
use crate::core::methods;
use crate::core::noise_estimate::{NoiseEstimator, VarianceFrom};
use crate::core::observer::{Observer, Setting, Source};
use crate::core::odometry::Track;
use crate::core::pattern::glob_set;
use crate::core::tmam::Tmam;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::MapFeature;
use crate::core::tmam::hearing::Hearing;
use crate::core::tmam::map::rough::{self, RoughWall};
use crate::core::tmam::prediction::{MapPrediction, Reach};
use crate::core::tmam::step::{Extraction, Step};

/// Replays from which poses are estimated, at most; where these do not settle, the last ones are shown.
const MOST_PASSES: usize = 3;

/// A path that moves by less is settled, metres.
const SETTLED: f64 = 1e-3;

/// A replay that nobody sees: each frame's step, the last one, and the map.
struct Pass {
    steps: Vec<Step>,
    last: Step,
    map: Vec<MapFeature>,
}

/// What became of the poses, and the replay at these, where there was one on the way to them.
#[derive(Default)]
struct SettledPoses {
    found: Option<Result<JointEstimate, OdometryKept>>,
    replayed: Option<Pass>,
}

/// The frames of what is replayed.
#[derive(Debug, Default)]
struct Framing {
    /// Stamps of the frames before them, which are not replayed.
    before: Vec<i64>,
    frames: Vec<Frame>,
    tally: Tally,
}

/// A log made ready.
#[derive(Debug)]
pub struct Replay<'a> {
    log: &'a Log,
    config: Config,
    variance_from: VarianceFrom,
    source: Source,
    /// The places of the readings in the window among those of the log.
    window: Range<usize>,
    selected: Vec<bool>,
    framing: Framing,
    // Once asked for.
    events_sha256: OnceLock<String>,
}

impl<'a> Replay<'a> {
    /// Makes a log ready: selects the readings in the window and the sonars asked for.
    ///
    /// # Errors
    /// A selection without sonars, or a gate that does not fit their beams.
    pub fn new(log: &'a Log, config: &'a Config) -> Result<Self, ReplayError> {
        let all = &log.events.readings;
        let window = window(all, config.input.start, config.input.end);
        let readings = || all.range(window.clone());
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
        let is_selected = |r: &RangeReading| selected.get(r.sonar.index()) == Some(&true);
        let narrowest = readings()
            .filter(is_selected)
            .min_by(|a, b| a.beam_width.total_cmp(&b.beam_width));
        // Where angles do not decide, a gate that nobody asked for is no reason to refuse a log.
        let gamma = config.triple.gamma;
        let by_angles = config.method == Method::Tmam && !config.departures().label_by_opinion;
        let gated = by_angles || gamma != Triple::default().gamma;
        let too_narrow = |r: &RangeReading| gated && r.beam_width <= gamma;
        if let Some(reading) = narrowest.filter(too_narrow) {
            return Err(ReplayError::GammaBeyondBeam {
                gamma: config.triple.gamma,
                beam_width: reading.beam_width,
                sonar: name_of(sonars, reading.sonar).to_owned(),
            });
        }
        let source = Source {
            file: log.file.clone(),
            messages: log.messages,
            start_ns: readings().next().map_or(0, |r| r.stamp_ns),
            end_ns: readings().next_back().map_or(0, |r| r.stamp_ns),
            complete: log.losses.is_empty(),
            lost: log.losses.clone(),
            notes: log.told(),
        };
        let mut config = config.clone();
        let mut variance_from = VarianceFrom::of(readings().filter(is_selected), &config);
        // The noise is that of the whole log, so that what is looked at does not change what is seen.
        let mut whole = None;
        if variance_from == VarianceFrom::Ranges {
            let framing = Framing::new(
                &log.events,
                &config,
                0..all.len(),
                &vec![true; sonars.len()],
            );
            let noise = noise_of(&framing.frames, &config).overall();
            if noise.is_none() {
                variance_from = VarianceFrom::Nothing;
            }
            let of_pose = config.noise.sigma_pose * config.noise.sigma_pose;
            let sigma = noise.map_or(SIGMA_UNKNOWN, |noise| noise.believed(of_pose));
            config.noise.sigma_abs = Some(sigma);
            whole = Some(framing);
        }
        let is_whole = window.len() == all.len() && !selected.contains(&false);
        let framing = whole
            .filter(|_| is_whole)
            .unwrap_or_else(|| Framing::new(&log.events, &config, window.clone(), &selected));
        Ok(Self {
            log,
            config,
            variance_from,
            source,
            window,
            selected,
            framing,
            events_sha256: OnceLock::new(),
        })
    }

    /// What stands fixed before the first frame.
    pub fn setting(&self) -> Setting<'_> {
        Setting {
            sonars: &self.log.events.sonars,
            config: &self.config,
            source: &self.source,
            events: &self.log.events,
            events_sha256: (self.events_sha256).get_or_init(|| sha256(&self.log.events)),
            origin_ns: self.origin_ns(),
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

    /// Every frame of them.
    pub fn frames(&self) -> &[Frame] {
        &self.framing.frames
    }

    /// The readings in the window of the sonars asked for.
    pub fn readings(&self) -> impl Iterator<Item = RangeReading> {
        (self.log.events.readings.range(self.window.clone()))
            .filter(|reading| self.selected.get(reading.sonar.index()) == Some(&true))
    }

    /// Steps the machine over every frame, once, and shows every step to the observers.
    ///
    /// # Errors
    /// When an observer cannot write, or no frame could be opened.
    pub fn run(&self, observers: &mut [&mut dyn Observer]) -> Result<Outcome, ReplayError> {
        if self.framing.frames.is_empty() {
            return Err(self.no_frames());
        }
        let SettledPoses {
            found: mut poses,
            replayed,
        } = self.poses();
        let path = poses
            .as_ref()
            .and_then(|found| Some(&found.as_ref().ok()?.path));
        let frames = self.frames_at(path);
        let of_tmam = self.config.method == Method::Tmam;
        let mut predicting =
            (of_tmam && self.config.rule == Rule::Paper).then(|| Tmam::new(&self.noise_aware()));
        let mut outcome = Outcome::new(self.variance_from, self.framing.tally.clone(), &frames);
        let before = self.framing.before.iter().copied();
        outcome.frame_stamps.splice(0..0, before);
        let mut show = |frame: &Frame, step: &Step| {
            if let Some(beside) = &mut predicting {
                beside.step(frame);
            }
            outcome.take(step);
            let mut observers = observers.iter_mut();
            observers.try_for_each(|observer| observer.frame(frame, step))
        };
        let (mut step, features) = match replayed {
            Some(Pass { steps, last, map }) => {
                for (frame, step) in frames.iter().zip(steps) {
                    show(frame, &step)?;
                }
                (last, map)
            }
            None => {
                let mut mapper = methods::of(&self.config);
                for frame in frames.iter() {
                    show(frame, &mapper.step(frame))?;
                }
                let last = mapper.finish();
                outcome.lacking = mapper.lacking();
                (last, mapper.features().to_vec())
            }
        };
        if let Some(beside) = &mut predicting {
            beside.finish();
        }
        if let Some(Ok(joint)) = &mut poses
            && self.config.noise_aware.oblique_walls
        {
            let rough = RoughWall::all(&step.reports, &joint.features, &self.config);
            for map in [&mut joint.features, &mut joint.features_given_path] {
                *map = rough::extended(map, &rough, self.config.map.max_wall_gap);
            }
        }
        let joint = poses.as_ref().and_then(|found| found.as_ref().ok());
        if let Some(joint) = joint {
            step.absorbed.extend(&joint.absorbed);
            step.settled.extend(&joint.features);
            step.closures.extend(&joint.closures);
        }
        // What a rival maps does not say what should have echoed.
        let map = of_tmam.then(|| match joint {
            Some(joint) => joint.features_given_path.as_slice(),
            None => (predicting.as_ref()).map_or(&*features, |beside| beside.map().features()),
        });
        step.predicting.extend(map.into_iter().flatten());
        let reach = Reach::of(self.config.map.max_wall_gap);
        let prediction = map.map(|map| MapPrediction::new(map, &reach));
        for report in Shared::make_mut(&mut step.reports) {
            let predict = |prediction: &MapPrediction| prediction.predict(&report.arc);
            report.map = prediction.as_ref().map(predict);
        }
        for observer in observers {
            observer.finish(&step)?;
        }
        outcome.end(step, &features, prediction, poses);
        Ok(outcome)
    }

    /// The path that a run used, by stamp: odometry's, corrected where that was. Of a part of the log the
    /// poses from its first reading to its last.
    pub fn path(&self, outcome: &Outcome) -> Vec<(i64, Pose2)> {
        let path = outcome.joint().map(|joint| &joint.path);
        let samples = self.log.events.odometry.iter();
        let used = |sample: &OdometrySample| {
            let odom_from_robot = sample.world_from_robot;
            path.map_or(odom_from_robot, |path| {
                path.correct(sample.stamp_ns, &odom_from_robot)
            })
        };
        let input = &self.config.input;
        let is_part = input.start.is_some() || input.end.is_some();
        let part = self.source.start_ns..=self.source.end_ns;
        samples
            .filter(|sample| !is_part || part.contains(&sample.stamp_ns))
            .map(|sample| (sample.stamp_ns, used(sample)))
            .collect()
    }

    /// Poses and features estimated together, from replays at ever better poses; nothing where the poses
    /// are to be those of odometry.
    fn poses(&self) -> SettledPoses {
        let config = &self.config;
        let asked = (config.method, config.rule, config.poses);
        if asked != (Method::Tmam, Rule::NoiseAware, Poses::Joint) {
            return SettledPoses::default();
        }
        // Rough walls that are seen at an angle say nothing of poses.
        let mut plain = config.clone();
        plain.noise_aware.oblique_walls = false;
        let as_shown = |pass| (plain == *config).then_some(pass);
        let mut before: Option<JointEstimate> = None;
        for number in 1.. {
            let pass = self.pass(before.as_ref().map(|joint| &joint.path), &plain);
            let mut found = match self.estimate(&pass, before.as_ref()) {
                Ok(found) => found,
                Err(kept) => {
                    return SettledPoses {
                        found: Some(Err(kept)),
                        replayed: as_shown(pass).filter(|_| before.is_none()),
                    };
                }
            };
            if let Some(before) = &before
                && found.path.moved(&before.path) < SETTLED
            {
                // The features are those of the replay at these poses.
                let settled = &before.path.world_from_robot;
                found.path.world_from_robot.clone_from(settled);
                return SettledPoses {
                    found: Some(Ok(found)),
                    replayed: as_shown(pass),
                };
            }
            if number == MOST_PASSES {
                return SettledPoses {
                    found: Some(Ok(found)),
                    replayed: None,
                };
            }
            before = Some(found);
        }
        SettledPoses::default()
    }

    /// A replay that nobody sees.
    fn pass(&self, path: Option<&CorrectedPath>, config: &Config) -> Pass {
        let mut tmam = Tmam::new(config);
        let frames = self.frames_at(path);
        Pass {
            steps: frames.iter().map(|frame| tmam.step(frame)).collect(),
            last: tmam.finish(),
            map: tmam.map().features().to_vec(),
        }
    }

    fn frames_at(&self, path: Option<&CorrectedPath>) -> Cow<'_, [Frame]> {
        match path {
            Some(path) => Cow::Owned(
                self.framing
                    .frames
                    .iter()
                    .map(|frame| path.frame(frame))
                    .collect(),
            ),
            None => Cow::Borrowed(self.framing.frames.as_slice()),
        }
    }

    fn estimate(
        &self,
        pass: &Pass,
        start: Option<&JointEstimate>,
    ) -> Result<JointEstimate, OdometryKept> {
        let of = |frame: &Frame, entry| Arc::of_entry(frame.index, entry, &self.config.noise);
        let arcs: Vec<Arc> = (self.framing.frames.iter())
            .flat_map(|frame| frame.entries.iter().filter_map(|entry| of(frame, entry)))
            .collect();
        let evidence = Evidence {
            frames: &self.framing.frames,
            arcs: &arcs,
            hardly: &Hearing::hardly_explained(&pass.last.reports),
        };
        let steps = pass.steps.iter().chain([&pass.last]);
        let extractions: Vec<&Extraction> = steps.flat_map(|step| &step.extractions).collect();
        let found = joint::estimate(&evidence, &extractions, &pass.map, start, &self.config);
        if let (Err(OdometryKept::TooMuch { .. }), None) = (&found, start) {
            let mut grown = growing::grown(&evidence, growing::GROWN, &self.config)?;
            grown.explained[0] = joint::explained(&pass.map, &arcs, &self.config);
            return Ok(grown);
        }
        found
    }

    /// The rule whose map predicts what should have echoed, whichever rule labels.
    fn noise_aware(&self) -> Config {
        Config {
            rule: Rule::NoiseAware,
            ..self.config.clone()
        }
    }

    fn no_frames(&self) -> ReplayError {
        let all = &self.log.events.readings;
        if let (Some(first), Some(last), true) = (all.first(), all.last(), self.window.is_empty()) {
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
        let readings = all.range(self.window.clone()).map(|r| r.stamp_ns);
        let readings: Vec<i64> = readings.collect();
        let gaps = self.framing.tally.dropped.contains_key("odometry-gap");
        let alike = odometry.array_windows().filter(|[a, b]| a == b).count();
        let is_coarse = 2 * alike > odometry.len();
        ReplayError::NoFrames {
            readings: self.framing.tally.readings,
            ranges: stamps(&readings),
            samples: odometry.len(),
            odometry: stamps(&odometry),
            advice: if gaps && is_coarse {
                "Most samples of the odometry carry the stamp of another one: input.odometry_stamps = \"recording\" takes \
                 the time of recording"
            } else if gaps {
                "The odometry is too sparse: raise frames.max_odometry_gap in the configuration"
            } else {
                "The two do not overlap in time: check the clocks of the robot's computers; for this log \
                 input.range_stamps = \"recording\" and input.odometry_stamps = \"recording\" take the time of recording"
            },
        }
    }
}

impl Framing {
    /// The frames of the readings at these places, with others before them.
    fn new(events: &Events, config: &Config, window: Range<usize>, selected: &[bool]) -> Self {
        let track = Track::of_ranges(&events.odometry, config);
        let mut framer = Framer::new(track, &events.sonars, selected, &config.frames);
        let first = (events.readings.range(window.clone()).next())
            .map_or(i64::MAX, |reading| reading.stamp_ns);
        let passed = events.readings.range(0..window.start);
        let passed = passed.filter_map(|r| framer.pass(&r));
        let mut before: Vec<i64> = passed.map(|frame| frame.stamp_ns).collect();
        let readings = events.readings.range(window);
        let mut frames: Vec<Frame> = readings.filter_map(|r| framer.push(&r)).collect();
        let (last, tally) = framer.finish();
        frames.extend(last);
        // The frame that was open then is one of them if it goes on.
        let is_over = |frame: &Frame| frame.stamp_ns < first && frame.entries.is_empty();
        let over = frames.first().filter(|frame| is_over(frame));
        before.extend(over.map(|frame| frame.stamp_ns));
        frames.drain(..usize::from(frames.first().is_some_and(is_over)));
        Self {
            before,
            frames,
            tally,
        }
    }
}

/// How far the ranges scatter.
fn noise_of(frames: &[Frame], config: &Config) -> NoiseEstimator {
    let mut noise = NoiseEstimator::default();
    for frame in frames {
        let arcs = (frame.entries.iter())
            .filter_map(|entry| Arc::of_entry(frame.index, entry, &config.noise));
        arcs.for_each(|arc| noise.push(&arc));
    }
    noise
}

/// The places of the readings from `start` to `end`, seconds after the first one.
fn window(readings: &Readings, start: Option<f64>, end: Option<f64>) -> Range<usize> {
    let first = readings.first().map_or(0, |r| r.stamp_ns);
    let seconds = |r: &RangeReading| r.stamp_ns.saturating_sub(first) as f64 * 1e-9;
    let from = start.map_or(0, |start| readings.partition_point(|r| seconds(r) < start));
    let to = end.map_or(readings.len(), |end| {
        readings.partition_point(|r| seconds(r) <= end)
    });
    from..to.max(from)
}
