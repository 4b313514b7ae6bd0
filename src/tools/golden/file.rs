//! The golden file: written, read, and refused where it makes no sense.

#[cfg(test)]
mod tests;

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::digest::digest;
use super::error::GoldenError;
use super::label_table::LabelTable;
use super::layout::render;
use super::range_noise::RangeNoise;
use super::results::Results;
use super::rows::Rows;
use super::tolerance::{Tolerance, ToleranceError};
use super::unrecorded::{absent_under, unrecorded};
use crate::core::config::Config;
use crate::core::log::Log;
use crate::io::config::file::{ConfigError, check};
use crate::io::schema::{Relation, in_words, of_file, relation};

/// The format's name and version.
pub const SCHEMA: &str = "tmam.golden/1";

/// A golden file.
#[derive(Debug, Clone, PartialEq)]
pub struct Golden {
    /// What wrote it.
    pub tool: Tool,
    /// The log it was made from; `None` for results that come from no log.
    pub log: Option<LogInfo>,
    /// Every parameter of the replay.
    pub config: Option<Config>,
    /// What counts as the same.
    pub tolerances: Tolerance,
    /// What was found good.
    pub results: Results,
}

/// What wrote a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// `tmam`.
    pub name: String,
    /// Its version.
    pub version: String,
}

/// The log that a golden file was made from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogInfo {
    /// Its file name.
    pub file: String,
    /// [`digest`](super::digest()) of its events.
    pub events_sha256: String,
}

impl LogInfo {
    /// Of a log that was read.
    pub fn of(log: &Log) -> Self {
        Self {
            file: log.file.clone(),
            events_sha256: digest(&log.events),
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: String,
    tool: Tool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    log: Option<LogInfo>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    config: Option<Config>,
    tolerances: Tolerance,
    #[serde(default, skip_serializing_if = "RangeNoise::is_unknown")]
    measured_sigma: RangeNoise,
    map: Rows,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    features: Option<Rows>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    labels: Option<LabelTable>,
}

impl Golden {
    /// Results to be held from now on.
    pub fn new(
        log: Option<LogInfo>,
        config: Option<Config>,
        tolerances: Tolerance,
        results: Results,
    ) -> Self {
        Self {
            tool: Tool {
                name: "tmam".to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
            },
            log,
            config,
            tolerances,
            results,
        }
    }

    /// Reads a golden file; also the names of parameters that it does not record, because a later
    /// version of this program has added them.
    ///
    /// # Errors
    /// A file that cannot be read, is of another schema, or contradicts itself.
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), GoldenError> {
        let bytes = std::fs::read(path).map_err(|source| GoldenError::Read {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&bytes, path)
    }

    fn parse(bytes: &[u8], path: &Path) -> Result<(Self, Vec<String>), GoldenError> {
        let malformed = |reason: String| GoldenError::Malformed {
            path: path.to_owned(),
            reason,
        };
        let found = of_file(bytes)
            .map_err(malformed)?
            .ok_or_else(|| malformed("it does not say its schema".to_owned()))?;
        let relation = relation(&found, SCHEMA);
        if relation != Relation::Same {
            return Err(GoldenError::Schema {
                path: path.to_owned(),
                relation,
                found,
            });
        }
        let file: File = serde_json::from_slice(bytes).map_err(|e| malformed(in_words(&e)))?;
        let mut absent = absent_under("tolerances", bytes, &file.tolerances, "tolerances");
        if let Some(config) = &file.config {
            absent.extend(unrecorded(bytes, config));
        }
        let golden = file
            .open()
            .map_err(|reason: Contradiction| malformed(reason.0))?;
        Ok((golden, absent))
    }

    /// The file's bytes: the same for the same content.
    ///
    /// # Errors
    /// A configuration that would not come back as it is.
    pub fn render(&self) -> Result<Vec<u8>, GoldenError> {
        let unfit = |reason: String| GoldenError::Config { reason };
        let file = File {
            schema: SCHEMA.to_owned(),
            tool: self.tool.clone(),
            log: self.log.clone(),
            config: self.config.clone(),
            tolerances: self.tolerances,
            measured_sigma: self.results.noise,
            map: self.results.map.as_slice().into(),
            features: Some(Rows::from(self.results.extracted.as_slice()))
                .filter(|_| self.log.is_some() || !self.results.extracted.is_empty()),
            labels: self.results.labels.as_ref().map(LabelTable::from),
        };
        let bytes = render(&file).map_err(|e| unfit(e.to_string()))?;
        let (back, _) = Self::parse(&bytes, Path::new("the golden file"))
            .map_err(|error| unfit(error.to_string()))?;
        if back.config != self.config {
            return Err(unfit(NOT_FINITE.to_owned()));
        }
        Ok(bytes)
    }
}

/// A configuration as a golden file gives it back.
///
/// The reader of JSON may be off by the last bit of a number, so a log is blessed with the numbers
/// that it will be checked with.
///
/// # Errors
/// A number that JSON cannot hold.
pub fn as_recorded(config: &Config) -> Result<Config, GoldenError> {
    /// One in ten numbers is off by a bit, and hardly one of those again.
    const MOST_ROUNDS: usize = 20;
    let unfit = |reason: String| GoldenError::Config { reason };
    let mut config = config.clone();
    for _ in 0..MOST_ROUNDS {
        let bytes = render(&config).map_err(|e| unfit(e.to_string()))?;
        if bytes.windows(5).any(|window| window == b" null") {
            return Err(unfit(NOT_FINITE.to_owned()));
        }
        let back: Config = serde_json::from_slice(&bytes).map_err(|e| unfit(e.to_string()))?;
        if back == config {
            return Ok(config);
        }
        config = back;
    }
    Err(unfit("a number in it has too many digits".to_owned()))
}

const NOT_FINITE: &str =
    "a number in it is not finite, and JSON holds only finite ones; give a large one";

/// What a file says that cannot be.
pub struct Contradiction(pub String);

impl From<ToleranceError> for Contradiction {
    fn from(error: ToleranceError) -> Self {
        Self(error.to_string())
    }
}

impl From<ConfigError> for Contradiction {
    fn from(error: ConfigError) -> Self {
        Self(format!("config: {error}"))
    }
}

impl File {
    /// What was made from a log holds all that a log gives: what is not there would not be checked.
    fn holds_all_of_its_log(&self) -> Result<(), Contradiction> {
        let absent = match (&self.log, &self.features, &self.labels) {
            (Some(_), None, _) => "features",
            (Some(_), _, None) => "labels",
            _ => return Ok(()),
        };
        Err(Contradiction(format!(
            "it was made from a log, but holds no `{absent}`, so they would not be checked"
        )))
    }

    fn open(self) -> Result<Golden, Contradiction> {
        self.tolerances.check()?;
        if let Some(config) = &self.config {
            check(config)?;
        }
        self.holds_all_of_its_log()?;
        let labels = self.labels.map(LabelTable::open).transpose()?;
        Ok(Golden {
            tool: self.tool,
            log: self.log,
            config: self.config,
            tolerances: self.tolerances,
            results: Results {
                map: self.map.into(),
                extracted: self.features.map(Vec::from).unwrap_or_default(),
                labels,
                noise: self.measured_sigma,
            },
        })
    }
}
