//! What can go wrong in a command.

use std::path::PathBuf;

use crate::core::exit::Exit;
use crate::core::replay::ReplayError;
use crate::io::config::file::ConfigError;
use crate::io::drives::DrivesError;
use crate::io::log::{LogError, itemised};
use crate::io::output::OutputError;
use crate::io::outputs::OutputsError;
use crate::observe::viewer;
use crate::tools::check::CheckError;
use crate::tools::diff::DiffError;
use crate::tools::evaluate::TruthError;
use crate::tools::explain::ExplainError;
use crate::tools::fleet::{Failure, FleetError};
use crate::tools::reproduce::ReproduceError;
use crate::tools::simulate::SimulateError;
use crate::tools::sweep::SweepError;

/// What can go wrong in a command.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// What is named as logs.
    #[error(transparent)]
    Drives(#[from] DrivesError),
    /// Several logs, and nothing says where their outputs go.
    #[error(
        "{logs} logs are given: say in which folder their outputs go, -o FOLDER, or --features, --trace or --arcs \
         FOLDER for only these"
    )]
    NoFolder {
        /// How many.
        logs: usize,
    },
    /// A flag that only one log can have.
    #[error("{flag} is for one log, and {logs} are given")]
    ForOneLog {
        /// The flag.
        flag: &'static str,
        /// How many.
        logs: usize,
    },
    /// Several logs, and an output called as that of one is.
    #[error(
        "{} is called as the file of one log is, and {logs} are given: name a folder, such as {}/", path.display(),
        path.with_extension("").display()
    )]
    FileOfSeveral {
        /// As named.
        path: PathBuf,
        /// How many.
        logs: usize,
    },
    /// Several logs at once.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// A log that is not whole, where only a whole one will do.
    #[error("{file} could not be read whole, as --strict asks. Lost:{}", itemised(.losses))]
    Incomplete {
        /// The log.
        file: String,
        /// What could not be read.
        losses: Vec<String>,
    },
    /// A log in which nothing can be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// Nothing to hold a replay against.
    #[error(transparent)]
    Truth(#[from] TruthError),
    /// Nothing to explain.
    #[error(transparent)]
    Explain(#[from] ExplainError),
    /// A flag, or a configuration made of flags.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A `--set` flag.
    #[error("--set takes KEY=VALUE: {source}")]
    Set {
        /// What is wrong with it.
        source: ConfigError,
    },
    /// A `--needs` flag.
    #[error("--needs takes KEY=VALUE: {source}")]
    Needs {
        /// What is wrong with it.
        source: ConfigError,
    },
    /// Another method, for a command that looks into TMAM.
    #[error(
        "`tmam {command}` looks into TMAM alone: leave --method and `method` in the configuration out"
    )]
    OfTmamAlone {
        /// The command.
        command: &'static str,
    },
    /// A sweep.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A simulation.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// A configuration file.
    #[error("{}: {source}", path.display())]
    ConfigFile {
        /// The file.
        path: PathBuf,
        /// What is wrong in it.
        source: ConfigError,
    },
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// An output that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Outputs that cannot be opened together.
    #[error(transparent)]
    Outputs(#[from] OutputsError),
    /// A check that cannot begin.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// A comparison that cannot begin.
    #[error(transparent)]
    Diff(#[from] DiffError),
    /// An experiment that cannot be made again.
    #[error(transparent)]
    Reproduce(#[from] ReproduceError),
    /// A report that cannot be formed.
    #[error("cannot form the report: {0}")]
    Report(#[from] std::io::Error),
    /// The recording.
    #[error(transparent)]
    Recording(#[from] viewer::Error),
}

impl Error {
    /// How a command ends that fails with it.
    pub fn exit(&self) -> Exit {
        let found_nothing = match self {
            Self::Replay(error)
            | Self::Explain(ExplainError::Replay(error))
            | Self::Diff(DiffError::Replay(error)) => error.found_nothing(),
            _ => false,
        };
        if found_nothing {
            Exit::Incomplete
        } else {
            Exit::Unusable
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self {
            exit: error.exit(),
            text: error.to_string(),
        }
    }
}
