//! The logs of a run: which golden file each has, which part of them is checked here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::artifacts::{Artifacts, artifacts_of};
use super::bless::bless;
use super::error::CheckError;
use super::judge::judge;
use super::partition::Partition;
use super::{Report, Verdict};
use crate::io::output::OutputError;
use crate::io::outputs::{OutputsError, refuse_collisions};
use crate::tools::golden::{Tolerance, is_set};

/// What is to be checked, and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The logs.
    pub logs: Vec<PathBuf>,
    /// Where the golden files are.
    pub golden: PathBuf,
    /// Where to put what people look into when a log differs.
    pub artifacts: Option<PathBuf>,
    /// Record only this many frames around each difference.
    pub around: Option<u32>,
    /// Write golden files instead of holding logs to them.
    pub bless: bool,
    /// Bless even in CI.
    pub force: bool,
    /// Borderline labels are differences, too.
    pub strict: bool,
    /// The part of the logs that is checked here.
    pub partition: Option<Partition>,
    /// What to bless with instead of what is recorded: texts as of a configuration file, each over
    /// the one before.
    pub layers: Vec<String>,
    /// Tolerances to bless with, as `KEY=VALUE`.
    pub tolerances: Vec<String>,
}

impl Options {
    /// Refuses reports in the place of a log, of a golden file, of what is kept of a log, or of each
    /// other; `json` goes to standard output.
    ///
    /// # Errors
    /// The file that would be destroyed.
    pub fn refuse_collisions(
        &self,
        junit: Option<&Path>,
        summary: Option<&Path>,
        json: bool,
    ) -> Result<(), OutputsError> {
        // Two logs with one golden file are refused elsewhere, with better words.
        let golden: BTreeSet<PathBuf> = self
            .logs
            .iter()
            .map(|log| golden_file(&self.golden, log))
            .collect();
        let kept: BTreeSet<PathBuf> = self
            .artifacts
            .iter()
            .flat_map(|to| self.logs.iter().flat_map(|log| artifacts_of(log, to)))
            .collect();
        let json = json.then(|| Path::new("-"));
        let inputs: Vec<&Path> = self.logs.iter().map(PathBuf::as_path).collect();
        let written = golden.iter().chain(&kept).map(|path| Some(path.as_path()));
        let outputs: Vec<Option<&Path>> = written.chain([junit, summary, json]).collect();
        refuse_collisions(&inputs, &outputs)
    }
}

/// A run, made ready.
#[derive(Debug)]
pub struct Suite {
    options: Options,
    jobs: Vec<Job>,
    artifacts: Option<Artifacts>,
    notes: Vec<String>,
}

/// A log and its golden file.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub log: PathBuf,
    pub golden: PathBuf,
}

impl Suite {
    /// Finds each log's golden file and the part to be checked, and makes the directories.
    ///
    /// # Errors
    /// Whatever makes the run senseless before it begins.
    pub fn new(options: Options) -> Result<Self, CheckError> {
        let ci = std::env::var("CI").is_ok_and(|value| is_set(&value));
        if options.bless && ci && !options.force {
            return Err(CheckError::BlessInCi);
        }
        options
            .tolerances
            .iter()
            .try_fold(Tolerance::default(), |all, one| all.with(one))?;
        if options.bless {
            make(&options.golden)?;
        } else if !options.golden.is_dir() {
            return Err(CheckError::NoGoldenDirectory {
                path: options.golden,
            });
        }
        let mut jobs = BTreeMap::<PathBuf, PathBuf>::new();
        for log in &options.logs {
            let golden = golden_file(&options.golden, log);
            if let Some(other) = jobs.insert(golden.clone(), log.clone()) {
                if same_file(&other, log) {
                    return Err(CheckError::SameLog { log: log.clone() });
                }
                return Err(CheckError::SameGolden {
                    one: other,
                    other: log.clone(),
                    golden,
                });
            }
        }
        let notes = match options.partition {
            // Of a suite in parts, all the parts know all the logs, and one of them tells.
            Some(partition) if !partition.is_first() => Vec::new(),
            _ if options.bless => Vec::new(),
            _ => unused(&options.golden, &jobs),
        };
        let jobs: Vec<Job> = jobs
            .into_iter()
            .map(|(golden, log)| Job { log, golden })
            .collect();
        let jobs = match options.partition {
            Some(partition) => partition.of(jobs),
            None => jobs,
        };
        let artifacts = options
            .artifacts
            .as_deref()
            .map(|directory| {
                make(directory)?;
                Ok::<_, OutputError>(Artifacts::new(directory, options.around))
            })
            .transpose()?;
        Ok(Self {
            options,
            jobs,
            artifacts,
            notes,
        })
    }

    /// How many logs there are to check.
    pub fn len(&self) -> usize {
        self.jobs.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// What a person should know of the suite as a whole.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Checks or blesses every log, and goes on after one that fails; `tell` hears of each.
    pub fn run(&self, mut tell: impl FnMut(&Report)) -> Vec<Report> {
        let mut reports = Vec::new();
        for job in &self.jobs {
            let report = if self.options.bless {
                bless(job, &self.options)
            } else {
                judge(job, self.options.strict, self.artifacts.as_ref())
            };
            tell(&report);
            reports.push(report);
        }
        reports
    }
}

impl Job {
    /// A report without a comparison.
    pub fn report(&self, verdict: Verdict) -> Report {
        Report {
            log: self.log.clone(),
            golden: self.golden.clone(),
            verdict,
            notes: Vec::new(),
            found: None,
            artifacts: Vec::new(),
            recording: None,
        }
    }
}

fn same_file(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => one == other,
    }
}

/// `DIR/drive.golden.json` for `drive.mcap`.
fn golden_file(directory: &Path, log: &Path) -> PathBuf {
    let mut name = log.file_stem().unwrap_or(log.as_os_str()).to_owned();
    name.push(".golden.json");
    directory.join(name)
}

fn make(directory: &Path) -> Result<(), OutputError> {
    std::fs::create_dir_all(directory).map_err(|source| OutputError {
        path: directory.to_owned(),
        source,
    })
}

/// More golden files without a log than this are counted, not named.
const NAMED: usize = 20;

/// Golden files that no log of this run has: what they hold is not being checked.
fn unused(directory: &Path, jobs: &BTreeMap<PathBuf, PathBuf>) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(directory) else {
        return Vec::new();
    };
    let mut unused: Vec<String> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            let name = path
                .file_name()
                .map(|name| name.to_string_lossy().into_owned());
            name.is_some_and(|name| name.ends_with(".golden.json")) && !jobs.contains_key(path)
        })
        .map(|path| path.display().to_string())
        .collect();
    unused.sort();
    if unused.is_empty() {
        return Vec::new();
    }
    let more = match unused.len().saturating_sub(NAMED) {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    unused.truncate(NAMED);
    vec![format!("no log was given for {}{more}", unused.join(", "))]
}
