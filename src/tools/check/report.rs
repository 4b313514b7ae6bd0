//! What came of the logs of a run, also as JSON.

use std::path::PathBuf;

use serde_json::{Value as Json, json};

use super::require::RequirementError;
use crate::core::exit::Exit;
use crate::core::replay::ReplayError;
use crate::core::tool::Tool;
use crate::io::config::file::ConfigError;
use crate::io::log::LogError;
use crate::io::output::OutputError;
use crate::observe::viewer;
use crate::tools::golden::{
    Comparison, Feature, GoldenError, Quality, ToleranceError, differences_in_json,
};

/// The name and version of the JSON format.
const SCHEMA: &str = "tmam.check/1";

/// What came of one log.
#[derive(Debug)]
pub struct Report {
    pub log: PathBuf,
    /// Its golden file.
    pub golden: PathBuf,
    pub result: CheckResult,
    /// What a person should know beside it.
    pub notes: Vec<String>,
    /// `None` where it did not come to a comparison.
    pub compared: Option<Compared>,
    /// How good the results are; `None` where there are none.
    pub quality: Option<Quality>,
    /// Files that were written for people to look into.
    pub artifacts: Vec<PathBuf>,
    /// The recording among them.
    pub recording: Option<PathBuf>,
    /// How long it took, seconds.
    pub seconds: f64,
}

/// A comparison, and the map that was blessed.
#[derive(Debug, Default)]
pub struct Compared {
    pub map: Vec<Feature>,
    pub found: Comparison,
}

/// What came of a log, in the end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CheckResult {
    /// Nothing differs beyond the tolerances.
    Matches,
    Differs,
    /// The golden file was written.
    Blessed,
    /// The golden file is what would be written.
    Unchanged,
    /// There was nothing to compare, and why.
    Nothing(String),
    /// Something could not be read or written, and what.
    Unusable(String),
}

/// Why a check cannot begin, or a log not be checked.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    #[error(
        "{} and {} would have the same golden file, {}; give them different names, or check them in two runs with \
         a --golden directory each", one.display(), other.display(), golden.display()
    )]
    SameGolden {
        one: PathBuf,
        other: PathBuf,
        golden: PathBuf,
    },
    #[error("{} is given twice; give each log once", log.display())]
    SameLog { log: PathBuf },
    #[error("there is no directory {}; look at --golden, or make it with --bless", path.display())]
    NoGoldenDirectory { path: PathBuf },
    #[error(
        "CI is set, and golden files are blessed by people who look at what changed. Bless on your own machine and \
         commit the files, or give --force"
    )]
    BlessInCi,
    #[error(
        "check replays each log with the configuration in its golden file, so parameters have a place only beside \
         --bless, or beside --config FILE, which holds the logs to that configuration; or try `tmam diff`"
    )]
    ParametersWithoutBless,
    #[error(
        "[require.{name}] asks something of a log that is not given and has no golden file: call it as its file is called"
    )]
    RequiredOfNoLog { name: String },
    #[error("--partition `{text}` is no part of a suite; give I/N with 1 <= I <= N, such as 2/4")]
    Partition { text: String },
    #[error(
        "{} was made from no log: it holds results of a Rust test. Bless the log into another directory",
        golden.display()
    )]
    OfATest { golden: PathBuf },
    /// There is nothing to compare, and why.
    #[error("{0}")]
    Nothing(String),
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Golden(#[from] GoldenError),
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Recording(#[from] viewer::Error),
    #[error("{}: {source}", path.display())]
    Suite {
        path: PathBuf,
        source: RequirementError,
    },
    #[error("cannot read {}: {source}", path.display())]
    ReadSuite {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("cannot form the report: {0}")]
    Report(#[from] std::io::Error),
}

impl CheckError {
    /// Whether the log wants a configuration of its own.
    pub fn wants_configuration(&self) -> bool {
        match self {
            Self::Log(error) => error.wants_configuration(),
            Self::Replay(error) => !matches!(error, ReplayError::Observer(_)),
            _ => false,
        }
    }
}

impl From<CheckError> for CheckResult {
    fn from(error: CheckError) -> Self {
        let text = error.to_string();
        match error {
            CheckError::Nothing(reason) => Self::Nothing(reason),
            CheckError::Replay(error) if error.found_nothing() => Self::Nothing(text),
            _ => Self::Unusable(text),
        }
    }
}

impl CheckResult {
    /// In a word or two.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Matches => "matches",
            Self::Differs => "differs",
            Self::Blessed => "blessed",
            Self::Unchanged => "unchanged",
            Self::Nothing(_) => "nothing to judge",
            Self::Unusable(_) => "unusable",
        }
    }

    /// Why nothing was compared.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Nothing(reason) | Self::Unusable(reason) => Some(reason),
            _ => None,
        }
    }

    pub fn exit(&self) -> Exit {
        match self {
            Self::Matches | Self::Blessed | Self::Unchanged => Exit::Done,
            Self::Differs => Exit::Differs,
            Self::Nothing(_) => Exit::Incomplete,
            Self::Unusable(_) => Exit::Unusable,
        }
    }
}

/// How a run ends.
pub fn exit(reports: &[Report]) -> Exit {
    Exit::gravest(reports.iter().map(|report| report.result.exit()))
}

/// The report as JSON; `notes` are on the run as a whole.
pub fn json(reports: &[Report], notes: &[String]) -> Json {
    json!({
        "schema": SCHEMA,
        "tool": Tool::THIS,
        "exit_code": exit(reports).code(),
        "notes": notes,
        "logs": reports.iter().map(log).collect::<Vec<_>>(),
    })
}

/// The report of a run that did not begin, as JSON.
pub fn refused(why: &impl std::fmt::Display) -> Json {
    json!({
        "schema": SCHEMA,
        "tool": Tool::THIS,
        "exit_code": Exit::Unusable.code(),
        "reason": why.to_string(),
        "notes": [],
        "logs": [],
    })
}

fn log(report: &Report) -> Json {
    let found = report.compared.as_ref().map(|compared| &compared.found);
    let [differences, borderline] = found.map(differences_in_json).unwrap_or_default();
    let files = report
        .artifacts
        .iter()
        .map(|path| path.display().to_string());
    json!({
        "log": report.log.display().to_string(),
        "golden": report.golden.display().to_string(),
        "verdict": report.result.name(),
        "reason": report.result.reason(),
        "notes": report.notes,
        "quality": found.and_then(|found| found.quality).map(|[then, now]| json!({
            "trend": now.trend(&then), "golden": then, "actual": now,
        })),
        "causes": found.map_or_else(Vec::new, |found| found.causes().collect()),
        "first_frame": found.and_then(Comparison::first_frame),
        "differences": differences,
        "borderline": borderline,
        "artifacts": files.collect::<Vec<_>>(),
    })
}
