//! One log under many configurations: which parameters do best, and whether a mount or a clock is
//! off.
//!
//! [`Grid`] says which configurations, [`Plan::run`] replays each of them and scores it, alone or against
//! the truth; [`text`] and [`files`] tell it. Cells are independent: whatever number of threads runs
//! them, the result is the same.

pub mod columns;
pub mod files;
pub mod grid;
mod result;
mod runner;
pub mod score;
pub mod text;

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use columns::Column;
pub use grid::{Axis, AxisError, Grid, Request};
use result::rank;
pub use result::{Cell, Sweep};
use runner::Runner;
pub use runner::{CellError, Plan, SweepError, TruthSource};

impl Plan<'_> {
    /// Replays and scores every cell; `tick` is called after each, from any thread.
    ///
    /// # Errors
    /// A log that cannot be read, and a grid of which no cell could be replayed.
    pub fn run(self, tick: &(dyn Fn() + Sync)) -> Result<Sweep, SweepError> {
        self.resolved()?.run_resolved(tick)
    }

    fn run_resolved(self, tick: &(dyn Fn() + Sync)) -> Result<Sweep, SweepError> {
        let runner = Runner::new(&self)?;
        let with_truth = runner.has_truth;
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
        rank(&mut cells, &ranked_by);
        let log = runner.about;
        if cells.iter().all(|cell| cell.score.is_err())
            && let Some(Err(source)) = cells.drain(..).next().map(|cell| cell.score)
        {
            return Err(SweepError::AllFailed {
                cells: self.grid.cells(),
                source,
            });
        }
        Ok(Sweep {
            log,
            grid: self.grid,
            with_truth,
            ranked_by,
            configured,
            cells,
        })
    }

    /// Whether only mounts, clocks and noise are swept: the ranges tell which fit best, whatever share of
    /// labels comes out.
    fn is_of_calibration(&self) -> bool {
        let mut axes = self.grid.axes().iter();
        axes.all(|axis| {
            matches!(
                axis.parts().first(),
                Some(&("sonar" | "sonars" | "input" | "noise"))
            )
        })
    }

    /// The columns to rank by.
    fn ranking(&self, with_truth: bool) -> Result<Vec<&'static Column>, SweepError> {
        let known = || columns::columns(with_truth);
        let asked = self.sort.as_ref().map(|name| {
            let found = known().find(|column| column.name == name);
            found.ok_or_else(|| SweepError::NoSuchColumn {
                name: name.clone(),
                known: known().map(|column| column.name).collect(),
            })
        });
        let first = asked.transpose()?;
        Ok(first
            .into_iter()
            .chain(columns::ranking(with_truth && !self.is_of_calibration()))
            .collect())
    }
}
