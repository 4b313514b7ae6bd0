//! Why nothing is checked at all.

use std::path::PathBuf;

use super::partition::PartitionError;
use crate::io::output::OutputError;
use crate::tools::golden::ToleranceError;

/// Why nothing is checked at all.
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
    /// The part of the suite.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// A tolerance.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    /// A directory cannot be made.
    #[error(transparent)]
    Directory(#[from] OutputError),
}
