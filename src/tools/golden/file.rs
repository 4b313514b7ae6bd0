//! The golden file: written, read, and refused where it makes no sense.

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::collect::LogInfo;
use super::labels_file::LabelTable;
use super::results::{Feature, Geometry, RangeSigma, Results};
use super::tolerance::Tolerance;
use crate::core::config::Config;
use crate::io::config::file::check;
use crate::io::schema::{Relation, in_words, of_file, relation};
use crate::tools::document::render;

/// The format's name and version.
pub const SCHEMA: &str = "tmam.golden/1";

/// Why a golden file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
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
        path: PathBuf,
        found: String,
        relation: Relation,
    },
    /// It is not what its schema says.
    #[error(
        "{} is no golden file as tmam writes it: {reason}. Mend it, take it back from version control, \
         or remove it and bless anew", path.display()
    )]
    Malformed { path: PathBuf, reason: String },
    /// A parameter that JSON cannot hold.
    #[error("the configuration cannot be recorded in a golden file: {reason}")]
    Config { reason: String },
}

/// A golden file.
#[derive(Debug, Clone, PartialEq)]
pub struct Golden {
    pub written_by: WrittenBy,
    /// The log it was made from; `None` for results that come from no log.
    pub log: Option<LogInfo>,
    /// Every parameter of the replay.
    pub config: Option<Config>,
    /// What counts as the same.
    pub tolerances: Tolerance,
    /// What was found good.
    pub results: Results,
}

/// The program that wrote a golden file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WrittenBy {
    pub name: String,
    pub version: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GoldenDocument {
    schema: String,
    tool: WrittenBy,
    #[serde(skip_serializing_if = "Option::is_none")]
    log: Option<LogInfo>,
    #[serde(skip_serializing_if = "Option::is_none")]
    config: Option<Config>,
    tolerances: Tolerance,
    #[serde(default, skip_serializing_if = "RangeSigma::is_unknown")]
    measured_sigma: RangeSigma,
    map: Rows,
    #[serde(skip_serializing_if = "Option::is_none")]
    features: Option<Rows>,
    #[serde(skip_serializing_if = "Option::is_none")]
    labels: Option<LabelTable>,
}

/// Features by kind.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rows {
    lines: Vec<Feature>,
    points: Vec<Feature>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    unfitted: Vec<Feature>,
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
            written_by: WrittenBy {
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
        let file: GoldenDocument =
            serde_json::from_slice(bytes).map_err(|e| malformed(in_words(&e)))?;
        let golden = file.open().map_err(malformed)?;
        let json: Json = serde_json::from_slice(bytes).map_err(|e| malformed(in_words(&e)))?;
        let recorded = |key| json.get(key).unwrap_or(&Json::Null);
        let tolerances = serde_json::to_value(golden.tolerances).unwrap_or_default();
        let mut absent = absent_in(recorded("tolerances"), &tolerances, "tolerances.");
        if let Some(config) = &golden.config {
            absent.extend(unrecorded(recorded("config"), config));
        }
        Ok((golden, absent))
    }

    /// The file's bytes: the same for the same content.
    ///
    /// # Errors
    /// A configuration that cannot be JSON.
    pub fn render(&self) -> Result<Vec<u8>, GoldenError> {
        let results = &self.results;
        let has_features = self.log.is_some() || !results.extracted.is_empty();
        let file = GoldenDocument {
            schema: SCHEMA.to_owned(),
            tool: self.written_by.clone(),
            log: self.log.clone(),
            config: self.config.clone(),
            tolerances: self.tolerances,
            measured_sigma: results.noise,
            map: Rows::from(results.map.as_slice()),
            features: has_features.then(|| Rows::from(results.extracted.as_slice())),
            labels: results.labels.as_ref().map(LabelTable::from),
        };
        render(&file).map_err(unfit)
    }
}

impl GoldenDocument {
    fn open(self) -> Result<Golden, String> {
        self.tolerances.check().map_err(|error| error.to_string())?;
        if let Some(config) = &self.config {
            check(config).map_err(|error| format!("config: {error}"))?;
        }
        let absent = match (&self.log, &self.features, &self.labels) {
            (Some(_), None, _) => Some("features"),
            (Some(_), _, None) => Some("labels"),
            _ => None,
        };
        if let Some(absent) = absent {
            return Err(format!(
                "it was made from a log, but holds no `{absent}`, so they would not be checked"
            ));
        }
        Ok(Golden {
            written_by: self.tool,
            log: self.log,
            config: self.config,
            tolerances: self.tolerances,
            results: Results {
                map: self.map.into(),
                extracted: self.features.unwrap_or_default().into(),
                labels: self.labels.map(LabelTable::open).transpose()?,
                noise: self.measured_sigma,
            },
        })
    }
}

impl From<&[Feature]> for Rows {
    fn from(features: &[Feature]) -> Self {
        let mut sorted = features.to_vec();
        sorted.sort_by_key(|feature| feature.id);
        let mut rows = Self::default();
        for feature in sorted {
            match feature.geometry {
                Geometry::Line(_) => rows.lines.push(feature),
                Geometry::Point { .. } => rows.points.push(feature),
                Geometry::Unfitted { .. } => rows.unfitted.push(feature),
            }
        }
        rows
    }
}

impl From<Rows> for Vec<Feature> {
    fn from(rows: Rows) -> Self {
        let mut features = [rows.lines, rows.points, rows.unfitted].concat();
        features.sort_by_key(|feature| feature.id);
        for feature in &mut features {
            feature.geometry = feature.geometry.rounded();
        }
        features
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
    let mut config = config.clone();
    for _ in 0..MOST_ROUNDS {
        let bytes = render(&config).map_err(unfit)?;
        if bytes.windows(5).any(|window| window == b" null") {
            return Err(unfit(
                "a number in it is not finite, and JSON holds only finite ones; give a large one",
            ));
        }
        let back: Config = serde_json::from_slice(&bytes).map_err(unfit)?;
        if back == config {
            return Ok(config);
        }
        config = back;
    }
    Err(unfit("a number in it has too many digits"))
}

fn unfit(reason: impl ToString) -> GoldenError {
    GoldenError::Config {
        reason: reason.to_string(),
    }
}

/// The names of the parameters that a configuration has and its record does not.
pub fn unrecorded(recorded: &Json, config: &Config) -> Vec<String> {
    absent_in(
        recorded,
        &serde_json::to_value(config).unwrap_or_default(),
        "",
    )
}

fn absent_in(recorded: &Json, full: &Json, prefix: &str) -> Vec<String> {
    let (Some(recorded), Some(full)) = (recorded.as_object(), full.as_object()) else {
        return Vec::new();
    };
    let names = full.iter().map(|(key, value)| match recorded.get(key) {
        Some(recorded) => absent_in(recorded, value, &format!("{prefix}{key}.")),
        None => vec![format!("{prefix}{key}")],
    });
    names.flatten().collect()
}
