//! Runs single cells. The log is read once, unless the way in which it is decoded is swept; what
//! its messages make together is put together once, unless mounts, beams or clocks are swept.

use std::borrow::Cow;
use std::path::Path;

use toml::Value;

use super::grid::{Axis, AxisError, Grid};
use super::score::{Score, TruthScore};
use crate::core::config::Config;
use crate::core::event::Sonar;
use crate::core::legible::one_line;
use crate::core::log::Log;
use crate::core::pattern::is_chosen;
use crate::core::replay::{Replay, ReplayError};
use crate::core::world::World;
use crate::io::config::file::{ConfigError, to_table};
use crate::io::log::truth::RecordedTruth;
use crate::io::log::{Gathered, LogError};
use crate::tools::evaluate::{Evaluation, Truth, TruthError};

/// What is asked of a sweep.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The log.
    pub log: &'a Path,
    /// What is not swept.
    pub config: &'a Config,
    /// What is swept.
    pub grid: Grid,
    /// What the truth is held to be.
    pub truth: TruthSource,
    /// A range agrees with the echo model within this, metres.
    pub agreeing_range: f64,
    /// Threads; 0 for one per processor.
    pub threads: usize,
    /// The column to rank by, before the usual ones.
    pub sort: Option<String>,
}

/// Where the truth comes from.
#[derive(Debug)]
pub enum TruthSource {
    /// From the log, where it carries one.
    Log,
    World(World),
    /// It is not to be looked at.
    None,
}

/// Why a cell could not be replayed.
#[derive(Debug, thiserror::Error)]
pub enum CellError {
    /// Its values do not go together.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The log cannot be read with them.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Nothing can be replayed with them.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The truth does not fit.
    #[error(transparent)]
    Truth(#[from] TruthError),
}

/// Why there is no sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// What is swept.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// The log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The truth in it.
    #[error("{0}, or leave the truth out of it with --no-truth")]
    Truth(#[source] TruthError),
    /// A relative value of what is not configured.
    #[error("{key} has no one value that others could be relative to: give the values themselves")]
    NothingConfigured {
        /// What was to be swept.
        key: String,
    },
    /// A sonar that the log does not have.
    #[error("{key}: the log has no sonar `{name}`; it has {}", one_line(&sonars.join(", ")))]
    NoSuchSonar {
        /// What was to be swept.
        key: String,
        /// The sonar in it.
        name: String,
        /// Those there are.
        sonars: Vec<String>,
    },
    /// A column that there is not.
    #[error("--sort {name}: there is no such column; there are {}", known.join(", "))]
    NoSuchColumn {
        /// As asked for.
        name: String,
        /// Those there are.
        known: Vec<&'static str>,
    },
    /// Nothing can be told.
    #[error("not one of {cells} cells could be replayed; the first: {source}")]
    AllFailed {
        /// How many there are.
        cells: usize,
        /// Of the first one.
        source: CellError,
    },
    /// The threads could not be started.
    #[error("cannot start {threads} threads: {source}; give fewer with --threads")]
    Threads {
        /// How many.
        threads: usize,
        /// Why.
        source: rayon::ThreadPoolBuildError,
    },
}

impl Plan<'_> {
    /// The same with values that are relative to what is configured as what they come to.
    ///
    /// # Errors
    /// A log that cannot be read as configured, and what is not configured.
    pub fn resolved(self) -> Result<Self, SweepError> {
        if !self.grid.is_of_log() {
            return Ok(self);
        }
        let log = Gathered::read(self.log, self.config)?.log(self.config)?;
        know_sonars(self.grid.axes(), &log)?;
        let sigma = Replay::new(&log, self.config).ok();
        let sigma = sigma.and_then(|replay| replay.config().noise.sigma_abs);
        let sonars = &log.events.sonars;
        let configured = |axis: &Axis| value(axis, self.config, sonars, sigma);
        let grid = self.grid.resolved(|axis| {
            let nothing = || SweepError::NothingConfigured { key: axis.key() };
            if let Some(pattern) = axis.pattern() {
                let patterns = [pattern.to_owned()];
                let names = sonars.iter().map(|sonar| sonar.name.as_str());
                let names: Vec<&str> = names.filter(|name| is_chosen(&patterns, name)).collect();
                axis.for_each(&names, &configured).ok_or_else(nothing)
            } else if axis.is_relative {
                Ok(axis.around(configured(axis).ok_or_else(nothing)?))
            } else {
                Ok(axis.clone())
            }
        })?;
        Ok(Self { grid, ..self })
    }
}

/// What the log gives without the sweep.
#[derive(Debug)]
pub struct Configured {
    /// The value on every axis, in the unit of its key; `None` where it is each message's own.
    pub values: Vec<Option<f64>>,
    /// What it comes to.
    pub score: Result<Score, CellError>,
}

/// What the log itself says.
#[derive(Debug, Default)]
pub struct About {
    /// Its file name.
    pub file: String,
    /// What a person should know of it.
    pub notes: Vec<String>,
    /// What could not be read of it.
    pub losses: Vec<String>,
}

impl About {
    /// Whether the log was read to its end without loss.
    pub fn is_complete(&self) -> bool {
        self.losses.is_empty()
    }
}

/// Runs single cells.
pub struct Runner<'a> {
    plan: &'a Plan<'a>,
    gathered: Gathered,
    /// Where every cell has the same.
    log: Option<Log>,
    /// What the ranges' noise is taken to be where no axis says it.
    sigma_abs: Option<f64>,
    /// Whether cells are held against the truth.
    pub has_truth: bool,
    pub about: About,
}

impl<'a> Runner<'a> {
    /// Reads the log.
    pub fn new(plan: &'a Plan<'a>) -> Result<Self, SweepError> {
        let axes = plan.grid.axes();
        // Any cell will do for what is the same in all.
        let first = plan.grid.configuration(plan.config, 0);
        let first = first.as_ref().unwrap_or(plan.config);
        let gathered = Gathered::read(plan.log, first)?;
        let mut about = About {
            file: gathered.file().to_owned(),
            ..About::default()
        };
        let has_truth = has_truth(plan, gathered.truth(), &about.file)?;
        let mut log = match gathered.log(first) {
            Ok(log) => Some(log),
            Err(_) if axes.iter().any(Axis::is_of_log) => None,
            Err(error) => return Err(error.into()),
        };
        if let Some(log) = &mut log {
            about.notes = std::mem::take(&mut log.notes);
            about.losses.clone_from(&log.losses);
            know_sonars(axes, log)?;
        }
        // Chi2 compares only where all cells take the ranges to be equally precise.
        let sigma_abs = log.as_ref().and_then(|log| {
            let replay = Replay::new(log, plan.config).or_else(|_| Replay::new(log, first));
            replay.ok()?.config().noise.sigma_abs
        });
        if let Some(sigma) = sigma_abs.filter(|_| first.noise.sigma_abs.is_none()) {
            about.notes.push(format!(
                "all cells take the noise to be what the ranges scatter by without the sweep; beside the \
                 flags of a cell, --set noise.sigma_abs={sigma} gives just that cell"
            ));
        }
        about.notes.extend(idle(axes, plan.config));
        if axes.iter().any(Axis::is_of_log) {
            log = None;
        }
        Ok(Self {
            plan,
            gathered,
            log,
            sigma_abs,
            has_truth,
            about,
        })
    }

    /// Replays and scores the log without the sweep.
    pub fn configured(&self) -> Configured {
        let config = self.plan.config;
        let log = self.gathered.log(config);
        let sonars = log.as_ref().map_or(&[][..], |log| &log.events.sonars);
        let axes = self.plan.grid.axes().iter();
        Configured {
            values: axes
                .map(|axis| value(axis, config, sonars, self.sigma_abs))
                .collect(),
            score: self.replayed(config.clone()),
        }
    }

    /// Replays and scores a cell.
    pub fn run(&self, cell: usize) -> Result<Score, CellError> {
        self.replayed(self.plan.grid.configuration(self.plan.config, cell)?)
    }

    fn replayed(&self, mut config: Config) -> Result<Score, CellError> {
        let plan = self.plan;
        config.noise.sigma_abs = config.noise.sigma_abs.or(self.sigma_abs);
        if plan.grid.axes().iter().any(Axis::is_decoding) {
            let gathered = Gathered::read(plan.log, &config)?;
            let log = gathered.log(&config)?;
            return self.score(&log, &config, gathered.truth());
        }
        let log = match &self.log {
            Some(log) => Cow::Borrowed(log),
            None => Cow::Owned(self.gathered.log(&config)?),
        };
        self.score(&log, &config, self.gathered.truth())
    }

    fn score(
        &self,
        log: &Log,
        config: &Config,
        recorded: &RecordedTruth,
    ) -> Result<Score, CellError> {
        let replay = Replay::new(log, config)?;
        let truth = self.truth(&replay, recorded)?;
        let outcome = replay.run(&mut [])?;
        let truth = truth.map(|truth| {
            let evaluation = Evaluation::new(&truth, &replay.path(&outcome), &outcome);
            TruthScore::new(&evaluation)
        });
        Ok(Score::new(&outcome, truth))
    }

    fn truth(
        &self,
        replay: &Replay<'_>,
        recorded: &RecordedTruth,
    ) -> Result<Option<Truth>, TruthError> {
        if !self.has_truth {
            return Ok(None);
        }
        let world = match &self.plan.truth {
            TruthSource::World(world) => Some(world.clone()),
            TruthSource::Log | TruthSource::None => None,
        };
        Truth::new(replay, recorded, world, self.plan.agreeing_range).map(Some)
    }
}

/// Whether there is a truth to hold cells against.
fn has_truth(plan: &Plan<'_>, recorded: &RecordedTruth, file: &str) -> Result<bool, SweepError> {
    match plan.truth {
        TruthSource::None => Ok(false),
        TruthSource::World(_) => Ok(true),
        TruthSource::Log => match recorded.world() {
            Ok(world) => Ok(world.is_some()),
            Err(problem) => Err(SweepError::Truth(TruthError::World {
                file: file.to_owned(),
                problem: problem.to_string(),
            })),
        },
    }
}

/// A sonar that is swept must be there: a name that is misspelt would change nothing.
fn know_sonars(axes: &[Axis], log: &Log) -> Result<(), SweepError> {
    let sonars = &log.events.sonars;
    for axis in axes {
        let ["sonar", name, _] = axis.parts().as_slice()[..] else {
            continue;
        };
        let is_it = |sonar: &Sonar| {
            let rest = sonar.name.strip_prefix(name);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
                || axis
                    .pattern()
                    .is_some_and(|pattern| is_chosen(&[pattern.to_owned()], &sonar.name))
                || axis
                    .stands_for
                    .iter()
                    .any(|(path, _)| path.get(1) == Some(&sonar.name))
        };
        if !sonars.iter().any(is_it) {
            return Err(SweepError::NoSuchSonar {
                key: axis.key(),
                name: name.to_owned(),
                sonars: sonars.iter().map(|sonar| sonar.name.clone()).collect(),
            });
        }
    }
    Ok(())
}

/// What is swept without any effect, and why.
fn idle(axes: &[Axis], config: &Config) -> Option<String> {
    if !config.departures().label_by_opinion {
        return None;
    }
    let keys: Vec<String> = axes.iter().map(Axis::key).collect();
    let bounds = ["triple.alpha", "triple.beta", "triple.gamma"];
    let idle: Vec<&str> = bounds
        .into_iter()
        .filter(|bound| keys.iter().any(|key| key == bound))
        .collect();
    (!idle.is_empty()).then(|| {
        format!(
            "no label depends on {} under the noise-aware rule, which labels by what the readings support; \
             to sweep that, give --rule paper",
            idle.join(" or ")
        )
    })
}

/// What is configured on an axis: in the configuration, in the log's mounts, or measured.
fn value(axis: &Axis, config: &Config, sonars: &[Sonar], sigma: Option<f64>) -> Option<f64> {
    if !axis.stands_for.is_empty() {
        let is_relative = axis.stands_for.iter().any(|(_, from)| *from != 0.0);
        return is_relative.then_some(0.0);
    }
    let mut inner = Some(Value::Table(to_table(config)));
    for part in &axis.path {
        inner = inner.and_then(|value| value.get(part).cloned());
    }
    match (inner, axis.parts().as_slice()) {
        (Some(Value::Float(number)), _) => Some(number),
        (Some(Value::Integer(number)), _) => Some(number as f64),
        (_, ["sonar", name, leaf]) => {
            let sonar = sonars.iter().find(|sonar| sonar.name == *name)?;
            let mount = sonar.robot_from_sensor;
            match *leaf {
                "x" => Some(undusted(mount.x)),
                "y" => Some(undusted(mount.y)),
                "yaw" => Some(undusted(mount.yaw.to_degrees())),
                _ => None,
            }
        }
        (_, ["noise", "sigma_abs"]) => sigma,
        _ => None,
    }
}

/// A number of a log's mount without the dust of its conversions: it is told, and not calculated with.
fn undusted(number: f64) -> f64 {
    libm::round(number * 1e4) / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;

    #[test]
    fn what_is_configured_comes_from_the_configuration_then_from_the_log() {
        let mut config = Config::default();
        config.triple.gamma = 7_f64.to_radians();
        config.map.confirm_runs = 4;
        let sonars = [Sonar {
            name: "front".to_owned(),
            topic: "/front".to_owned(),
            robot_from_sensor: Pose2::new(0.1, 0.2, -20_f64.to_radians()),
        }];
        let said = |key: &str| {
            let axis = Axis::parse(key, "1").unwrap();
            value(&axis, &config, &sonars, Some(0.003))
        };
        assert_eq!(said("triple.gamma"), Some(7.0));
        assert_eq!(said("map.confirm_runs"), Some(4.0));
        assert_eq!(said("sonar.front.yaw"), Some(-20.0));
        assert_eq!(said("sonar.front.x"), Some(0.1));
        assert_eq!(said("sonar.front.beam_width"), None);
        assert_eq!(said("noise.sigma_abs"), Some(0.003));
    }
}
