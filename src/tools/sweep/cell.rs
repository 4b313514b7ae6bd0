//! Runs single cells. The log is read once, unless the way in which it is decoded is swept; what
//! its messages make together is put together once, unless mounts, beams or clocks are swept.

use std::borrow::Cow;

use super::axes::Axis;
use super::configured::{Configured, value};
use super::score::{Score, TruthScore};
use super::{Plan, SweepError, TruthSource};
use crate::core::config::Config;
use crate::core::log::Log;
use crate::core::replay::{Replay, ReplayError};
use crate::io::config::file::ConfigError;
use crate::io::log::truth::RecordedTruth;
use crate::io::log::{Gathered, LogError};
use crate::tools::evaluate::{Evaluation, Truth, TruthError};

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

/// Runs single cells.
pub struct Runner<'a> {
    plan: &'a Plan<'a>,
    gathered: Gathered,
    /// Where every cell has the same.
    log: Option<Log>,
    /// What the ranges' noise is taken to be where no axis says it.
    sigma_abs: Option<f64>,
    has_truth: bool,
    about: About,
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
        let has_truth = plan.truth.is_there(gathered.truth(), &about.file)?;
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

    /// Whether cells are held against the truth.
    pub fn has_truth(&self) -> bool {
        self.has_truth
    }

    /// What the log itself says.
    pub fn into_about(self) -> About {
        self.about
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
        let truth = truth.map(|truth| TruthScore::new(&Evaluation::new(&truth, &outcome)));
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
        let (world, agreeing_range) = match &self.plan.truth {
            TruthSource::None => return Ok(None),
            TruthSource::Log { agreeing_range } => (None, *agreeing_range),
            TruthSource::World {
                world,
                agreeing_range,
            } => (Some(world.clone()), *agreeing_range),
        };
        Truth::new(replay, recorded, world, agreeing_range).map(Some)
    }
}

/// A sonar that is swept must be there: a name that is misspelt would change nothing.
fn know_sonars(axes: &[Axis], log: &Log) -> Result<(), SweepError> {
    for axis in axes {
        let [section, name, _] = axis.path.as_slice() else {
            continue;
        };
        let is_it = |sonar: &str| {
            let rest = sonar.strip_prefix(name.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
        };
        let sonars = &log.events.sonars;
        if section == "sonar" && !sonars.iter().any(|sonar| is_it(&sonar.name)) {
            return Err(SweepError::NoSuchSonar {
                key: axis.key(),
                name: name.clone(),
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
