//! Why a check cannot begin, or a log not be checked.

use std::path::PathBuf;

use super::partition::PartitionError;
use crate::io::config::file::ConfigError;
use crate::io::output::OutputError;
use crate::observe::viewer;
use crate::tools::golden::{GoldenError, ToleranceError};

/// Why a check cannot begin, or a log not be checked.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// Two logs have one golden file.
    #[error(
        "{} and {} would have the same golden file, {}; give them different names, or check them in two runs with \
         a --golden directory each", one.display(), other.display(), golden.display()
    )]
    SameGolden {
        /// A log.
        one: PathBuf,
        /// Another log.
        other: PathBuf,
        /// Their golden file.
        golden: PathBuf,
    },
    /// One log is given twice.
    #[error("{} is given twice; give each log once", log.display())]
    SameLog {
        /// The log.
        log: PathBuf,
    },
    /// There are no golden files.
    #[error("there is no directory {}; look at --golden, or make it with --bless", path.display())]
    NoGoldenDirectory {
        /// What was given.
        path: PathBuf,
    },
    /// Machines do not say what is good.
    #[error(
        "CI is set, and golden files are blessed by people who look at what changed. Bless on your own machine and \
         commit the files, or give --force"
    )]
    BlessInCi,
    /// Parameters, which a check takes from the golden file.
    #[error(
        "check replays each log with the configuration in its golden file, so parameters have no place here; they go \
         with --bless, or try `tmam diff`"
    )]
    ParametersWithoutBless,
    /// The part of the suite.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// A tolerance.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    /// A directory or a file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A log cannot be replayed, or its golden file not be used.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// Parameters to bless with.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The recording of a log that differs.
    #[error(transparent)]
    Recording(#[from] viewer::Error),
    /// The results of a log that differs, or a report.
    #[error("cannot form the report: {0}")]
    Report(#[from] std::io::Error),
}
