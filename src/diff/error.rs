//! Why two results cannot be compared.

use std::path::PathBuf;

use crate::features;
use crate::schema::Relation;

/// Why there is nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    /// Something else.
    #[error(
        "{} is neither an MCAP log nor a features.json nor a golden file: {reason}", path.display()
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
    /// Recordings hold pictures, not features.
    #[error(
        "{} is a recording: it is for looking at, and holds what is drawn, not the features with their numbers. \
         Compare {}", path.display(), match .features {
            Some(features) => format!("{}, which lies beside it, or the log itself", features.display()),
            None => "the log itself, or the features.json that `tmam replay` writes beside a recording: keep both".to_owned(),
         }
    )]
    Recording {
        /// The file.
        path: PathBuf,
        /// The features file beside it, where there is one.
        features: Option<PathBuf>,
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
}
