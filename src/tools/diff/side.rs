//! One side of a comparison: a log to be replayed, or the results in a file.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde::Deserialize as _;
use serde_json::{Value as Json, json};

use crate::core::config::Config;
use crate::core::replay::{Replay, ReplayError};
use crate::io::config::file::{ConfigError, check};
use crate::io::log::{LogError, read};
use crate::io::schema::{Relation, in_words, of_file, relation};
use crate::observe::carried::CarriedError;
use crate::observe::features;
use crate::observe::recording::read_carried;
use crate::tools::golden::{
    FeaturesFile, Golden, GoldenError, LabelsFile, LogInfo, Results, SCHEMA as GOLDEN, Tolerance,
    ToleranceError, results, unrecorded,
};

/// One side of a comparison.
#[derive(Debug)]
pub struct Side {
    /// Its file.
    pub path: PathBuf,
    /// The kind of the file: `log`, `features`, `golden` or `recording`.
    kind: &'static str,
    pub results: Results,
    /// The tolerances in it, where it is a golden file.
    pub tolerances: Option<Tolerance>,
    /// Its log, where that is known.
    pub log: Option<LogInfo>,
    /// The configuration that it came from. Only a log beside it needs one that makes sense.
    config: Option<Json>,
    /// Parameters that the file does not record.
    pub unrecorded: Vec<String>,
    /// What could not be read of its log; empty for a whole one.
    pub losses: Vec<String>,
}

/// One of the two arguments, looked at but not replayed.
#[derive(Debug)]
pub enum Source {
    /// A log, to be replayed.
    Log(PathBuf),
    Results(Box<Side>),
}

/// Why there is nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error(
        "{} is neither an MCAP log nor a recording, a features.json or a golden file: {reason}", path.display()
    )]
    NoResults { path: PathBuf, reason: String },
    #[error(
        "{} has the schema `{found}`, and this is tmam {}, which reads `{}`. {}", path.display(),
        env!("CARGO_PKG_VERSION"), features::SCHEMA,
        if *.relation == Relation::Newer { "Install the tmam that wrote it, or replay its log with this one" }
        else { "Replay its log with this tmam" }
    )]
    Version {
        path: PathBuf,
        found: String,
        relation: Relation,
    },
    #[error(
        "{} is no features.json as tmam writes it: {reason}. Write it again with `tmam replay LOG --features FILE`",
        path.display()
    )]
    Malformed { path: PathBuf, reason: String },
    #[error(
        "the results of {} cannot be compared: {source}. Record its log again with `tmam replay LOG -o FILE.rrd`, or \
         compare the log itself or its features.json", path.display()
    )]
    Recording { path: PathBuf, source: CarriedError },
    #[error(
        "neither {} nor {} is a log, so there is nothing to replay with the parameters that are given. Leave them \
         out, or give a log in place of one of the two", a.display(), b.display()
    )]
    NothingToReplay { a: PathBuf, b: PathBuf },
    #[error(
        "--config-b and --set-b are for replaying B, and {} is no log. Leave them out, or give the log as B: \
         tmam diff A LOG", b.display()
    )]
    NothingToReplayForB { b: PathBuf },
    #[error(
        "{} records no configuration that this tmam could replay the log with: {reason}. Compare with a \
         features.json of the log, written by `tmam replay`", path.display()
    )]
    RecordedConfig { path: PathBuf, reason: String },
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Golden(#[from] GoldenError),
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
}

impl Source {
    /// Opens an argument.
    ///
    /// # Errors
    /// When no results are to be had from it.
    pub fn open(path: &Path) -> Result<Self, DiffError> {
        let unreadable = |source| DiffError::Read {
            path: path.to_owned(),
            source,
        };
        let mut head = Vec::new();
        let mut file = std::fs::File::open(path).map_err(unreadable)?.take(64);
        file.read_to_end(&mut head).map_err(unreadable)?;
        let side = if head.starts_with(b"RRF") {
            Side::recorded(path)?
        } else if head.trim_ascii_start().starts_with(b"{") {
            Side::of_file(path, &std::fs::read(path).map_err(unreadable)?)?
        } else {
            return Ok(Self::Log(path.to_owned()));
        };
        Ok(Self::Results(Box::new(side)))
    }
}

impl Side {
    fn new(path: &Path, kind: &'static str, results: Results) -> Self {
        Self {
            path: path.to_owned(),
            kind,
            results,
            tolerances: None,
            log: None,
            config: None,
            unrecorded: Vec::new(),
            losses: Vec::new(),
        }
    }

    /// Replays a log.
    ///
    /// # Errors
    /// As a replay fails.
    pub fn replayed(path: &Path, config: Config) -> Result<Self, DiffError> {
        let log = read(path, &config)?;
        let replay = Replay::new(&log, &config)?;
        let results = results(&replay.setting(), &replay.run(&mut [])?);
        Ok(Self {
            log: Some(LogInfo::of(&log)),
            losses: log.losses.clone(),
            ..Self::new(path, "log", results)
        })
    }

    /// The results that a recording carries.
    fn recorded(path: &Path) -> Result<Self, DiffError> {
        let carried = read_carried(path).map_err(|source| DiffError::Recording {
            path: path.to_owned(),
            source,
        })?;
        let mut side = Self::of_file(path, carried.features.as_bytes())?;
        side.kind = "recording";
        if let Some(text) = carried.labels {
            let file = LabelsFile::parse(&text).map_err(|reason| DiffError::Malformed {
                path: path.to_owned(),
                reason,
            })?;
            side.log = Some(file.log);
            side.results.noise = file.noise;
            side.results.labels = Some(file.labels);
        }
        Ok(side)
    }

    /// The results in a file, by its schema.
    fn of_file(path: &Path, bytes: &[u8]) -> Result<Self, DiffError> {
        let no_results = |reason: String| DiffError::NoResults {
            path: path.to_owned(),
            reason,
        };
        let found = of_file(bytes).map_err(no_results)?;
        let found = found.ok_or_else(|| no_results("it does not say its schema".to_owned()))?;
        // A golden file of another version is refused by its own reader.
        if relation(&found, GOLDEN) != Relation::Other {
            let (golden, unrecorded) = Golden::read(path)?;
            let config = golden.config.map(serde_json::to_value).transpose();
            return Ok(Self {
                tolerances: Some(golden.tolerances),
                log: golden.log,
                config: config.unwrap_or_default(),
                unrecorded,
                ..Self::new(path, "golden", golden.results)
            });
        }
        match relation(&found, features::SCHEMA) {
            Relation::Same => {}
            Relation::Other => return Err(no_results(format!("its schema is `{found}`"))),
            relation => {
                return Err(DiffError::Version {
                    path: path.to_owned(),
                    found,
                    relation,
                });
            }
        }
        let malformed = |reason: String| DiffError::Malformed {
            path: path.to_owned(),
            reason,
        };
        let file: FeaturesFile =
            serde_json::from_slice(bytes).map_err(|error| malformed(in_words(&error)))?;
        let (losses, json) = (file.losses(), file.config.clone());
        let config = json
            .as_ref()
            .and_then(|json| Config::deserialize(json).ok());
        let absent = json
            .as_ref()
            .zip(config)
            .map(|(json, config)| unrecorded(json, &config));
        Ok(Self {
            losses,
            unrecorded: absent.unwrap_or_default(),
            config: json,
            ..Self::new(path, "features", file.into_results().map_err(malformed)?)
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
        let Some(json) = &self.config else {
            return Ok(None);
        };
        let config = Config::deserialize(json).map_err(|error| unfit(error.to_string()))?;
        check(&config).map_err(|error| unfit(error.to_string()))?;
        Ok(Some(config))
    }

    pub fn json(&self) -> Json {
        json!({
            "file": self.path.display().to_string(),
            "kind": self.kind,
            "log": self.log.as_ref().map(|log| &log.file),
            "events_sha256": self.log.as_ref().map(|log| &log.events_sha256),
            "map": self.results.map.len(),
            "extracted": self.results.extracted.len(),
            "labels": self.results.labels.as_ref().map(|labels| labels.len()),
            "lost": self.losses,
        })
    }
}
