//! The golden file: written, read, and refused where it makes no sense.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::coding::{decode_marks, decode_steps, encode_marks, encode_steps};
use super::layout::render;
use super::results::{LabelledArc, Labels, Mark, Results};
use super::rows::Rows;
use super::tolerance::{Tolerance, ToleranceError};
use crate::config::Config;
use crate::config::file::{ConfigError, check};

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

/// Why a golden file cannot be used.
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
        if *.newer { "Install the tmam that wrote it, or bless it again with this one after removing the file" }
        else { "It is no golden file" }
    )]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its schema.
        found: String,
        /// Whether a later version wrote it.
        newer: bool,
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
    map: Rows,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    features: Option<Rows>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    labels: Option<LabelTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LabelTable {
    contact: u64,
    intersection: u64,
    unidentified: u64,
    sonars: BTreeMap<String, SonarRow>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SonarRow {
    labels: String,
    first_ns: i64,
    steps_ms: String,
}

#[derive(Deserialize)]
struct Head {
    schema: String,
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
        let head: Head = serde_json::from_slice(bytes).map_err(|e| malformed(e.to_string()))?;
        if head.schema != SCHEMA {
            return Err(GoldenError::Schema {
                path: path.to_owned(),
                newer: head.schema.starts_with("tmam.golden/"),
                found: head.schema,
            });
        }
        let file: File = serde_json::from_slice(bytes).map_err(|e| malformed(e.to_string()))?;
        let unrecorded = file
            .config
            .as_ref()
            .map(|config| unrecorded(bytes, config))
            .unwrap_or_default();
        let golden = file
            .open()
            .map_err(|reason: Contradiction| malformed(reason.0))?;
        Ok((golden, unrecorded))
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
            map: self.results.map.as_slice().into(),
            features: Some(Rows::from(self.results.extracted.as_slice()))
                .filter(|_| self.log.is_some() || !self.results.extracted.is_empty()),
            labels: self.results.labels.as_ref().map(LabelTable::from),
        };
        let bytes = render(&file).map_err(|e| unfit(e.to_string()))?;
        let (back, _) = Self::parse(&bytes, Path::new("the golden file"))
            .map_err(|error| unfit(error.to_string()))?;
        if back.config != self.config {
            return Err(unfit(
                "a number in it is not finite, and JSON holds only finite ones; give a finite one"
                    .to_owned(),
            ));
        }
        Ok(bytes)
    }
}

/// What a file says that cannot be.
struct Contradiction(String);

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
    fn open(self) -> Result<Golden, Contradiction> {
        self.tolerances.check()?;
        if let Some(config) = &self.config {
            check(config)?;
        }
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
            },
        })
    }
}

impl From<&Labels> for LabelTable {
    fn from(labels: &Labels) -> Self {
        let counts = labels.counts();
        let count = |mark| counts.get(&mark).copied().unwrap_or_default();
        let rows = labels.sonars.iter().filter_map(|(sonar, arcs)| {
            let stamps: Vec<i64> = arcs.iter().map(|arc| arc.stamp_ns).collect();
            let row = SonarRow {
                labels: encode_marks(arcs.iter().map(|arc| arc.mark)),
                first_ns: *stamps.first()?,
                steps_ms: encode_steps(&stamps),
            };
            Some((sonar.clone(), row))
        });
        Self {
            contact: count(Mark::Contact),
            intersection: count(Mark::Intersection),
            unidentified: count(Mark::Unidentified),
            sonars: rows.collect(),
        }
    }
}

impl LabelTable {
    fn open(self) -> Result<Labels, Contradiction> {
        let mut labels = Labels::default();
        for (sonar, row) in self.sonars {
            let wrong = |what: String| Contradiction(format!("labels of sonar `{sonar}`: {what}"));
            let marks = decode_marks(&row.labels).map_err(wrong)?;
            let stamps = decode_steps(row.first_ns, &row.steps_ms).map_err(wrong)?;
            if marks.len() != stamps.len() {
                return Err(wrong(format!(
                    "there are {} labels and {} stamps",
                    marks.len(),
                    stamps.len()
                )));
            }
            let arcs = marks
                .into_iter()
                .zip(stamps)
                .map(|(mark, stamp_ns)| LabelledArc {
                    stamp_ns,
                    mark,
                    frame: None,
                    margin: None,
                    reason: None,
                });
            labels.sonars.insert(sonar, arcs.collect());
        }
        let counts = labels.counts();
        for (mark, said) in [
            (Mark::Contact, self.contact),
            (Mark::Intersection, self.intersection),
            (Mark::Unidentified, self.unidentified),
        ] {
            let found = counts.get(&mark).copied().unwrap_or_default();
            if found != said {
                return Err(Contradiction(format!(
                    "labels: {said} {} are counted, but the sonars have {found}",
                    mark.name()
                )));
            }
        }
        Ok(labels)
    }
}

/// Parameters that the program has and the file does not record.
fn unrecorded(bytes: &[u8], config: &Config) -> Vec<String> {
    let recorded = serde_json::from_slice(bytes)
        .ok()
        .and_then(|file: serde_json::Value| file.get("config").cloned());
    let (Some(recorded), Ok(full)) = (recorded, serde_json::to_value(config)) else {
        return Vec::new();
    };
    let mut missing = Vec::new();
    absent(&recorded, &full, "", &mut missing);
    missing
}

fn absent(
    recorded: &serde_json::Value,
    full: &serde_json::Value,
    path: &str,
    missing: &mut Vec<String>,
) {
    let (Some(recorded), Some(full)) = (recorded.as_object(), full.as_object()) else {
        return;
    };
    for (key, value) in full {
        let path = if path.is_empty() {
            key.clone()
        } else {
            format!("{path}.{key}")
        };
        match recorded.get(key) {
            Some(recorded) => absent(recorded, value, &path, missing),
            None => missing.push(path),
        }
    }
}
