//! One side of a comparison.

use std::path::{Path, PathBuf};

use super::DiffError;
use crate::core::config::Config;
use crate::io::config::file::check;
use crate::tools::golden::{LogInfo, Replayed, Results, Tolerance, replay};

/// One side of a comparison.
#[derive(Debug)]
pub struct Side {
    /// What it came from.
    pub path: PathBuf,
    /// What that is.
    pub kind: Kind,
    /// What it holds.
    pub results: Results,
    /// The tolerances in it, where it is a golden file.
    pub tolerances: Option<Tolerance>,
    /// Its log, where that is known.
    pub log: Option<LogInfo>,
    /// The configuration that it came from.
    pub config: Recorded,
    /// Parameters that a golden file does not record.
    pub unrecorded: Vec<String>,
    /// What could not be read of its log; empty for a whole one.
    pub losses: Vec<String>,
}

/// What a side came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A log that was replayed.
    Log,
    /// A features file.
    Features,
    /// A golden file.
    Golden,
    /// A recording, with the results that it carries.
    Recording,
}

impl Kind {
    /// In files and to people: `log`, `features`, `golden` or `recording`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Log => "log",
            Self::Features => "features",
            Self::Golden => "golden",
            Self::Recording => "recording",
        }
    }
}

/// A configuration, as it is recorded.
#[derive(Debug, Clone, PartialEq)]
pub enum Recorded {
    /// None is.
    Nothing,
    /// One that makes sense.
    Config(Box<Config>),
    /// One that nobody has read yet: only a log beside it needs it.
    Json(serde_json::Value),
}

impl Side {
    /// Replays a log.
    ///
    /// # Errors
    /// As a replay fails.
    pub fn replayed(path: &Path, config: Config) -> Result<Self, DiffError> {
        let Replayed {
            log, info, results, ..
        } = replay(path, &config)?;
        Ok(Self {
            path: path.to_owned(),
            kind: Kind::Log,
            results,
            tolerances: None,
            log: Some(info),
            config: Recorded::Config(Box::new(config)),
            losses: log.losses,
            unrecorded: Vec::new(),
        })
    }

    /// The configuration that it came from; `None` where it records none.
    ///
    /// # Errors
    /// One that cannot be replayed with.
    pub fn configuration(&self) -> Result<Option<Config>, DiffError> {
        let unfit = |reason: String| DiffError::RecordedConfig {
            path: self.path.clone(),
            reason,
        };
        match &self.config {
            Recorded::Nothing => Ok(None),
            Recorded::Config(config) => Ok(Some(config.as_ref().clone())),
            Recorded::Json(json) => {
                let config: Config =
                    serde_json::from_value(json.clone()).map_err(|e| unfit(e.to_string()))?;
                check(&config).map_err(|e| unfit(e.to_string()))?;
                Ok(Some(config))
            }
        }
    }
}
