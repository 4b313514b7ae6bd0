//! `tmam check`: logs held to their golden files, and what is said and kept of it.
//!
//! A log is replayed with the configuration in its golden file ([`judge`]); what differs becomes
//! text ([`text`]), a recording ([`artifacts`], [`overlay`]), and what CI systems read ([`junit`],
//! [`summary`], [`annotations`], [`json`]).

pub mod annotations;
mod artifacts;
mod bless;
mod error;
pub mod json;
mod judge;
pub mod junit;
mod overlay;
mod partition;
mod report_files;
mod sketch;
mod suite;
pub mod summary;
pub mod text;

use std::path::PathBuf;

pub use error::CheckError;
pub use partition::{Partition, PartitionError};
pub use report_files::ReportFiles;
pub use suite::{Options, Suite};

use crate::core::exit::Exit;
use crate::tools::golden::{Comparison, Golden, Results};

/// What came of one log.
#[derive(Debug)]
pub struct Report {
    /// The log.
    pub log: PathBuf,
    /// Its golden file.
    pub golden: PathBuf,
    /// The verdict.
    pub verdict: Verdict,
    /// What a person should know beside it.
    pub notes: Vec<String>,
    /// The comparison behind the verdict; `None` where it did not come to one.
    pub found: Option<Found>,
    /// Files that were written for people to look into.
    pub artifacts: Vec<PathBuf>,
    /// The recording among them.
    pub recording: Option<PathBuf>,
}

/// Both sides of a comparison and what it found.
#[derive(Debug)]
pub struct Found {
    /// What was blessed.
    pub golden: Golden,
    /// What the replay gives now.
    pub actual: Results,
    /// How they differ.
    pub comparison: Comparison,
}

/// What came of a log, in the end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing differs beyond the tolerances.
    Matches,
    /// Something does.
    Differs,
    /// The golden file was written.
    Blessed,
    /// The golden file is what would be written.
    Unchanged,
    /// There was nothing to hold to each other, and why.
    Nothing(String),
    /// Something could not be read or written, and what.
    Unusable(String),
}

impl Verdict {
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

    /// Why there is none, where there is none.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Nothing(reason) | Self::Unusable(reason) => Some(reason),
            _ => None,
        }
    }

    fn exit(&self) -> Exit {
        match self {
            Self::Matches | Self::Blessed | Self::Unchanged => Exit::Done,
            Self::Differs => Exit::Differs,
            Self::Nothing(_) => Exit::Incomplete,
            Self::Unusable(_) => Exit::Unusable,
        }
    }
}

/// How a run ends: 2 stands before 1, 1 before 3, 3 before 0. What could not be read may hide
/// anything, a difference is sure, and where nothing was compared nothing may be called good.
pub fn exit(reports: &[Report]) -> Exit {
    let exits: Vec<Exit> = reports.iter().map(|report| report.verdict.exit()).collect();
    [Exit::Unusable, Exit::Differs, Exit::Incomplete]
        .into_iter()
        .find(|exit| exits.contains(exit))
        .unwrap_or(Exit::of_whole(!exits.is_empty()))
}
