//! Several logs in one run: each by itself, on as many threads as asked for, and a table of what came of them
//! with the worst log first.

pub mod lines;
pub mod replayed;
mod surveyed;

use std::fmt::Write as _;

use rayon::iter::{
    IndexedParallelIterator as _, IntoParallelRefIterator as _, ParallelIterator as _,
};

use crate::core::exit::Exit;
use crate::core::legible::one_line;
use crate::core::replay::{CauseTold, Stretch};
use crate::core::rounding::fixed;
use crate::io::drives::Drive;
use crate::tools::tables::{TableColumn, listed, name};

/// Why there is no run.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// The threads could not be started.
    #[error("cannot start {jobs} threads: {source}; give fewer with --jobs")]
    Threads {
        /// How many.
        jobs: usize,
        /// Why.
        source: rayon::ThreadPoolBuildError,
    },
}

/// What a table says of a log.
pub trait Summary {
    /// How the log ended.
    fn exit(&self) -> Exit;
    /// What to put it after among logs that ended alike: larger is worse, the first number counts most.
    fn badness(&self) -> [f64; 3];
    /// What a person should know of it, a line each.
    fn problems(&self) -> &str;
}

/// Why nothing came of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    pub exit: Exit,
    pub text: String,
}

/// What came of one log.
#[derive(Debug)]
pub struct OfLog<T> {
    pub name: String,
    pub result: Result<T, Failure>,
}

/// What came of all of them, the worst first.
#[derive(Debug)]
pub struct Fleet<T>(Vec<OfLog<T>>);

impl<T: Summary + Send> Fleet<T> {
    /// Does the work for every drive, on so many threads (0: one per processor). One that fails stops no other.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn run(
        drives: &[Drive],
        jobs: usize,
        work: impl Fn(&Drive) -> Result<T, Failure> + Sync,
    ) -> Result<Self, FleetError> {
        // No log is replayed on two.
        let jobs = jobs.min(drives.len());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
        let pool = pool.map_err(|source| FleetError::Threads { jobs, source })?;
        let done = || {
            let drives = drives.par_iter().with_max_len(1);
            drives.map(|drive| OfLog {
                name: drive.name.clone(),
                result: work(drive),
            })
        };
        let mut all: Vec<OfLog<T>> = pool.install(|| done().collect());
        // Equal ones stay in the order in which they were named.
        all.sort_by(|one, other| {
            let gravity = other.exit().gravity().cmp(&one.exit().gravity());
            let [one, other] = [one, other].map(|of| match &of.result {
                Ok(summary) => summary.badness(),
                Err(_) => [f64::INFINITY; 3],
            });
            let worse = other
                .iter()
                .zip(one)
                .map(|(other, one)| other.total_cmp(&one));
            worse.fold(gravity, std::cmp::Ordering::then)
        });
        Ok(Self(all))
    }
}

impl<T: Summary> OfLog<T> {
    fn exit(&self) -> Exit {
        match &self.result {
            Ok(summary) => summary.exit(),
            Err(failure) => failure.exit,
        }
    }
}

impl<T: Summary> Fleet<T> {
    /// How the run ends: as the worst of its logs.
    pub fn exit(&self) -> Exit {
        Exit::gravest(self.0.iter().map(OfLog::exit))
    }

    /// What is told of those of which something came, the worst first.
    pub fn told(&self) -> impl Iterator<Item = &T> {
        self.0.iter().filter_map(|of| of.result.as_ref().ok())
    }

    /// What a person should know of the logs: a line each, with the log's name before it; what is said of all of them
    /// once.
    pub fn problems(&self) -> String {
        let mut text = String::new();
        let lines = |of: &'_ T| of.problems().lines().map(str::to_owned).collect::<Vec<_>>();
        let mut of_all = self.told().map(lines);
        let first = of_all
            .next()
            .filter(|_| self.told().count() > 1)
            .unwrap_or_default();
        let shared = of_all.fold(first, |mut shared, lines| {
            shared.retain(|line| lines.contains(line));
            shared
        });
        for line in &shared {
            // Writing into a string cannot fail.
            let _ = writeln!(text, "all logs: {line}");
        }
        for of in &self.0 {
            let (name, failed) = (one_line(&of.name), of.result.as_ref().err());
            if let Some(Failure { text: why, .. }) = failed {
                let _ = writeln!(text, "{name}: error: {why}");
            }
            let problems = of.result.as_ref().map_or("", |summary| summary.problems());
            for line in problems
                .lines()
                .filter(|line| !shared.iter().any(|of| of == line))
            {
                let _ = writeln!(text, "{name}: {line}");
            }
        }
        text
    }

    /// A row for each log: its name, how it ended, and these columns.
    pub fn table(&self, columns: &[TableColumn<'_, T>]) -> String {
        let of_log: TableColumn<'_, OfLog<T>> = ("log", &|of| name(&of.name));
        let ended: TableColumn<'_, OfLog<T>> = ("ended", &|of| ending(of.exit()).to_owned());
        let cells: Vec<_> = columns
            .iter()
            .map(|(head, cell)| {
                let cell = move |of: &OfLog<T>| of.result.as_ref().map_or("-".to_owned(), cell);
                (*head, cell)
            })
            .collect();
        let cells = cells.iter().map(|(head, cell)| {
            let cell: &dyn Fn(&OfLog<T>) -> String = cell;
            (*head, cell)
        });
        let all: Vec<TableColumn<'_, OfLog<T>>> =
            [of_log, ended].into_iter().chain(cells).collect();
        listed(2, &all, &self.0)
    }
}

fn ending(exit: Exit) -> &'static str {
    match exit {
        Exit::Done => "done",
        Exit::Differs => "differs",
        Exit::Unusable => "FAILED",
        Exit::Incomplete => "incomplete",
    }
}

/// The keys that mend what is off, and the stretch in which something was; `None` where that was not looked for.
fn off(causes: Option<&[CauseTold]>, stretch: Option<&Stretch>) -> String {
    let settings = match causes {
        None | Some([]) => None,
        Some([first, rest @ ..]) => {
            let settings = first.settings.join(", ");
            Some(match rest.len() {
                0 => settings,
                more => format!("{settings} and {more} more"),
            })
        }
    };
    let stretch = stretch.map(|stretch| {
        let [from, to] = stretch.seconds.map(|seconds| fixed(seconds, 1));
        format!("{from} to {to} s")
    });
    let off: Vec<String> = settings.into_iter().chain(stretch).collect();
    match (off.is_empty(), causes) {
        (false, _) => off.join(", "),
        (true, None) => "-".to_owned(),
        (true, Some(_)) => "none found".to_owned(),
    }
}
