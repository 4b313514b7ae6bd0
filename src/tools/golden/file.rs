//! The golden file: written, read, and refused where it makes no sense.

#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

use super::labels_file::LabelTable;
use super::profile::LogInfo;
use super::quality::Quality;
use super::results::{Feature, Geometry, RangeSigma, Results};
use super::tolerance::Tolerance;
use crate::core::config::Config;
use crate::io::config::file::check;
use crate::io::schema::{Relation, in_words, of_file, relation};
use crate::io::text_file::read_bytes;
use crate::tools::document::render;

/// The format's name and version.
pub const SCHEMA: &str = "tmam.golden/2";

/// The version before, which is read, too: it holds every parameter, and of the log only a digest.
const BEFORE: &str = "tmam.golden/1";

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
    /// Every parameter of the replay; `None` for results that come from no log.
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
    /// What of it is not as the defaults of the program that wrote it.
    #[serde(skip_serializing_if = "Option::is_none")]
    config: Option<Json>,
    tolerances: Tolerance,
    #[serde(default, skip_serializing_if = "RangeSigma::is_unknown")]
    measured_sigma: RangeSigma,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    findings: Option<BTreeMap<String, String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    quality: Option<Quality>,
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
    circles: Vec<Feature>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    unfitted: Vec<Feature>,
}

impl Golden {
    /// Results to be held from now on.
    pub fn new(config: Option<Config>, tolerances: Tolerance, results: Results) -> Self {
        Self {
            written_by: WrittenBy {
                name: "tmam".to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
            },
            config,
            tolerances,
            results,
        }
    }

    /// The log that it was made from; `None` for results that come from no log.
    pub fn log(&self) -> Option<&LogInfo> {
        self.results.log.as_ref()
    }

    /// Reads a golden file; also what it does not know, because a later version of this program has added
    /// that.
    ///
    /// # Errors
    /// A file that cannot be read, is of another schema, or contradicts itself.
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), GoldenError> {
        let bytes = read_bytes(path).map_err(|source| GoldenError::Read {
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
        if relation != Relation::Same && found != BEFORE {
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
        if let (BEFORE, Some(config)) = (found.as_str(), &golden.config) {
            absent.extend(unrecorded(recorded("config"), config));
            absent
                .push("what the log holds, part by part, so that no cause can be named".to_owned());
        }
        Ok((golden, absent))
    }

    /// The file's bytes: the same for the same content.
    ///
    /// # Errors
    /// A configuration that cannot be JSON.
    pub fn render(&self) -> Result<Vec<u8>, GoldenError> {
        let results = &self.results;
        let has_features = self.log().is_some() || !results.extracted.is_empty();
        let file = GoldenDocument {
            schema: SCHEMA.to_owned(),
            tool: self.written_by.clone(),
            log: self.log().cloned(),
            config: self.config.as_ref().map(not_default),
            tolerances: self.tolerances,
            measured_sigma: results.noise,
            findings: results.findings.clone(),
            quality: results.quality,
            map: Rows::by_place(&results.map),
            features: has_features.then(|| Rows::by_place(&results.extracted)),
            labels: results.labels.as_ref().map(LabelTable::from),
        };
        render(&file).map_err(unfit)
    }
}

impl GoldenDocument {
    fn open(self) -> Result<Golden, String> {
        self.tolerances.check().map_err(|error| error.to_string())?;
        let config = self.config.map(Config::deserialize).transpose();
        let config = config.map_err(|error| format!("config: {error}"))?;
        if let Some(config) = &config {
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
            config,
            tolerances: self.tolerances,
            results: Results {
                log: self.log,
                findings: self.findings,
                quality: self.quality,
                map: self.map.into(),
                extracted: self.features.unwrap_or_default().into(),
                labels: self.labels.map(LabelTable::open).transpose()?,
                noise: self.measured_sigma,
            },
        })
    }
}

impl Rows {
    /// Those of a sonar by the time, others from left to right and up.
    fn by_place(features: &[Feature]) -> Self {
        let key = |feature: &Feature| {
            let at = match feature.geometry {
                Geometry::Line(line) => line.mid,
                Geometry::Point { x, y } | Geometry::Circle { x, y, .. } => [x, y],
                Geometry::Unfitted { .. } => [0.0; 2],
            };
            let seconds = feature.seconds.filter(|_| feature.sensor.is_some());
            [seconds.unwrap_or_default(), at]
        };
        let mut sorted = features.to_vec();
        sorted.sort_by(|one, other| {
            let numbers = key(one).into_iter().flatten();
            let numbers = numbers.zip(key(other).into_iter().flatten());
            let by_place = numbers.map(|(one, other)| one.total_cmp(&other));
            one.sensor
                .cmp(&other.sensor)
                .then(by_place.fold(Ordering::Equal, Ordering::then))
        });
        let mut rows = Self::default();
        for feature in sorted {
            match feature.geometry {
                Geometry::Line(_) => rows.lines.push(feature),
                Geometry::Point { .. } => rows.points.push(feature),
                Geometry::Circle { .. } => rows.circles.push(feature),
                Geometry::Unfitted { .. } => rows.unfitted.push(feature),
            }
        }
        rows
    }
}

impl From<Rows> for Vec<Feature> {
    fn from(rows: Rows) -> Self {
        let mut features = [rows.lines, rows.points, rows.circles, rows.unfitted].concat();
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

/// What of a configuration is not as the defaults.
fn not_default(config: &Config) -> Json {
    fn beyond(value: &Json, default: &Json) -> Option<Json> {
        match (value.as_object(), default.as_object()) {
            (Some(value), Some(default)) => {
                let none = Json::Null;
                let changed = value.iter().filter_map(|(key, value)| {
                    let default = default.get(key).unwrap_or(&none);
                    Some((key.clone(), beyond(value, default)?))
                });
                let changed: Map<String, Json> = changed.collect();
                (!changed.is_empty()).then_some(Json::Object(changed))
            }
            _ => (value != default).then(|| value.clone()),
        }
    }
    let [value, default] =
        [config, &Config::default()].map(|config| serde_json::to_value(config).unwrap_or_default());
    beyond(&value, &default).unwrap_or_else(|| Json::Object(Map::new()))
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
