//! One log under many configurations: which parameters do best, and whether a mount or a clock is
//! off.
//!
//! [`Grid`] says which configurations, [`run`] replays each of them and scores it, alone or against
//! the truth; [`table`], [`csv`] and [`json`] tell it. Cells are independent: whatever number of
//! threads runs them, the result is the same.

pub mod axes;
mod cell;
pub mod columns;
pub mod conclusion;
pub mod configured;
pub mod csv;
pub mod drawing;
pub mod grid;
pub mod json;
pub mod request;
pub mod score;
pub mod table;

use std::path::Path;

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

pub use axes::{Axis, AxisError};
pub use cell::CellError;
pub use grid::Grid;
pub use request::Request;

use crate::core::config::Config;
use crate::core::world::World;
use crate::io::log::LogError;
use crate::io::log::truth::RecordedTruth;
use crate::tools::evaluate::TruthError;
use cell::Runner;
use columns::{Column, WITH_TRUTH, WITHOUT_TRUTH};
use configured::Configured;
use score::Score;

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
    /// Threads; 0 for one per processor.
    pub threads: usize,
    /// The column to rank by, before the usual ones.
    pub sort: Option<String>,
}

/// Where the truth comes from.
#[derive(Debug, Clone)]
pub enum TruthSource {
    /// From the log, where it carries one.
    Log {
        /// A range agrees with the echo model within this, metres.
        agreeing_range: f64,
    },
    /// From a world.
    World {
        /// The world.
        world: World,
        /// A range agrees with the echo model within this, metres.
        agreeing_range: f64,
    },
    /// It is not to be looked at.
    None,
}

/// A sweep that has run.
#[derive(Debug)]
pub struct Sweep {
    /// File name of the log, without its directory.
    pub file: String,
    /// What was swept.
    pub grid: Grid,
    /// Whether cells were held against the truth.
    pub with_truth: bool,
    /// Whether the log was read to its end without loss.
    pub complete: bool,
    /// What a person should know of the log.
    pub notes: Vec<String>,
    /// What could not be read of it.
    pub losses: Vec<String>,
    /// By what the cells are ranked.
    pub ranked_by: Vec<&'static Column>,
    /// The log without the sweep.
    pub configured: Configured,
    /// Every cell, the best first, those that failed last.
    pub cells: Vec<Cell>,
}

/// One configuration.
#[derive(Debug)]
pub struct Cell {
    /// Its place in the grid.
    pub index: usize,
    /// What it came to.
    pub score: Result<Score, CellError>,
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
    /// A sonar that the log does not have.
    #[error("{key}: the log has no sonar `{name}`; it has {}", sonars.join(", "))]
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
    /// Replays and scores every cell; `tick` is called after each, from any thread.
    ///
    /// # Errors
    /// A log that cannot be read, and a grid of which no cell could be replayed.
    pub fn run(self, tick: &(dyn Fn() + Sync)) -> Result<Sweep, SweepError> {
        let runner = Runner::new(&self)?;
        let with_truth = runner.has_truth();
        let ranked_by = self.ranking(with_truth)?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .build()
            .map_err(|source| SweepError::Threads {
                threads: self.threads,
                source,
            })?;
        let run = |index| {
            let score = runner.run(index);
            tick();
            Cell { index, score }
        };
        let cells = || (0..self.grid.cells()).into_par_iter().map(run).collect();
        let (configured, mut cells): (_, Vec<Cell>) =
            pool.install(|| rayon::join(|| runner.configured(), cells));
        columns::rank(&mut cells, &ranked_by);
        let about = runner.into_about();
        if cells.iter().all(|cell| cell.score.is_err())
            && let Some(Err(source)) = cells.drain(..).next().map(|cell| cell.score)
        {
            return Err(SweepError::AllFailed {
                cells: self.grid.cells(),
                source,
            });
        }
        Ok(Sweep {
            file: about.file,
            complete: about.losses.is_empty(),
            notes: about.notes,
            losses: about.losses,
            grid: self.grid,
            with_truth,
            ranked_by,
            configured,
            cells,
        })
    }

    /// The columns to rank by.
    fn ranking(&self, with_truth: bool) -> Result<Vec<&'static Column>, SweepError> {
        let usual = if with_truth {
            WITH_TRUTH
        } else {
            WITHOUT_TRUTH
        };
        let first = match &self.sort {
            None => None,
            Some(name) => {
                let known = || columns::columns(with_truth);
                let found = known().find(|column| column.name == name);
                Some(found.ok_or_else(|| SweepError::NoSuchColumn {
                    name: name.clone(),
                    known: known().map(|column| column.name).collect(),
                })?)
            }
        };
        let usual = usual.iter().filter_map(|name| columns::find(name));
        Ok(first.into_iter().chain(usual).collect())
    }
}

impl TruthSource {
    /// Whether there is a truth to hold cells against.
    fn is_there(&self, recorded: &RecordedTruth, file: &str) -> Result<bool, SweepError> {
        match self {
            Self::None => Ok(false),
            Self::World { .. } => Ok(true),
            Self::Log { .. } => match recorded.world() {
                Ok(world) => Ok(world.is_some()),
                Err(problem) => Err(SweepError::Truth(TruthError::World {
                    file: file.to_owned(),
                    problem: problem.to_string(),
                })),
            },
        }
    }
}

impl Sweep {
    /// The best cell.
    pub fn best(&self) -> Option<(&Cell, &Score)> {
        let cell = self.cells.first()?;
        Some((cell, cell.score.as_ref().ok()?))
    }

    /// How many cells could not be replayed.
    pub fn failed(&self) -> usize {
        self.cells.iter().filter(|cell| cell.score.is_err()).count()
    }

    /// Whether anything echoed in any cell.
    pub fn has_arcs(&self) -> bool {
        let scores = self
            .cells
            .iter()
            .filter_map(|cell| cell.score.as_ref().ok());
        scores.into_iter().any(|score| score.arcs > 0)
    }
}
