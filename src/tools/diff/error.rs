//! Why two results cannot be compared.

use std::path::PathBuf;

use crate::io::config::file::ConfigError;
use crate::io::schema::Relation;
use crate::observe::carried::CarriedError;
use crate::observe::features;
use crate::tools::golden::{GoldenError, ToleranceError};

/// Why there is nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    /// Something else.
    #[error(
        "{} is neither an MCAP log nor a recording, a features.json or a golden file: {reason}", path.display()
    )]
    NoResults {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A features file of another version.
    #[error(
        "{} has the schema `{found}`, and this is tmam {}, which reads `{}`. {}", path.display(),
        env!("CARGO_PKG_VERSION"), features::SCHEMA,
        if *.relation == Relation::Newer { "Install the tmam that wrote it, or replay its log with this one" }
        else { "Replay its log with this tmam" }
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its schema.
        found: String,
        /// How it stands to the one that is known.
        relation: Relation,
    },
    /// A features file that is not what its schema says.
    #[error(
        "{} is no features.json as tmam writes it: {reason}. Write it again with `tmam replay LOG --features FILE`",
        path.display()
    )]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A recording without results that can be read.
    #[error(
        "the results of {} cannot be compared: {source}. Record its log again with `tmam replay LOG -o FILE.rrd`, or \
         compare the log itself or its features.json", path.display()
    )]
    Recording {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: CarriedError,
    },
    /// Parameters, and no log to replay with them.
    #[error(
        "neither {} nor {} is a log, so there is nothing to replay with the parameters that are given. Leave them \
         out, or give a log in place of one of the two", a.display(), b.display()
    )]
    NothingToReplay {
        /// One side.
        a: PathBuf,
        /// The other side.
        b: PathBuf,
    },
    /// Parameters for B, which is no log.
    #[error(
        "--config-b and --set-b are for replaying B, and {} is no log. Leave them out, or give the log as B: \
         tmam diff A LOG", b.display()
    )]
    NothingToReplayForB {
        /// B.
        b: PathBuf,
    },
    /// The configuration that goes with the other side.
    #[error(
        "{} records no configuration that this tmam could replay the log with: {reason}. Compare with a \
         features.json of the log, written by `tmam replay`", path.display()
    )]
    RecordedConfig {
        /// The features file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A log that cannot be replayed, or a golden file that cannot be used.
    #[error(transparent)]
    Golden(#[from] GoldenError),
    /// A configuration made of what is given.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A tolerance.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
}
