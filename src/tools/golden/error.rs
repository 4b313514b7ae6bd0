//! Why there are no results to compare.

use std::path::PathBuf;

use super::file::SCHEMA;
use crate::core::replay::ReplayError;
use crate::io::log::LogError;
use crate::io::schema::Relation;

/// Why there are no results to compare: a golden file cannot be used, or a log not replayed.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// It cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is of another kind, or of a version that this program does not know.
    #[error(
        "{} has the schema `{found}`, and this is tmam {}, which reads `{SCHEMA}`. {}",
        path.display(), env!("CARGO_PKG_VERSION"),
        match .relation {
            Relation::Newer => "Install the tmam that wrote it, or bless it again with this one after removing the file",
            Relation::Older => "Remove it and bless it again with this one",
            Relation::Same | Relation::Other => "It is no golden file",
        }
    )]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its schema.
        found: String,
        /// How it stands to the one that is known.
        relation: Relation,
    },
    /// It is not what its schema says.
    #[error(
        "{} is no golden file as tmam writes it: {reason}. Mend it, take it back from version control, \
         or remove it and bless anew", path.display()
    )]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A parameter that JSON cannot hold.
    #[error("the configuration cannot be recorded in a golden file: {reason}")]
    Config {
        /// Why.
        reason: String,
    },
    /// A log that cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A log that cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

impl GoldenError {
    /// As [`ReplayError::found_nothing`].
    pub fn found_nothing(&self) -> bool {
        matches!(self, Self::Replay(error) if error.found_nothing())
    }
}
