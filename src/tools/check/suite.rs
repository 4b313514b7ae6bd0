//! The logs of a run: which golden file each has, which part of them is checked here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::job::{Artifacts, Job, Terms, artifacts_of, picture_of};
use super::renamed::renamed;
use super::report::{CheckError, Report};
use super::require::Requirements;
use crate::io::drives::drives;
use crate::io::output::OutputError;
use crate::io::outputs::{OutputsError, refuse_collisions};
use crate::io::text_file::read_text;
use crate::tools::golden::{Tolerance, is_set};

/// What is to be checked, and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    pub logs: Vec<PathBuf>,
    /// The directory of the golden files.
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
    /// The part of the logs that is checked here, `I/N`.
    pub partition: Option<String>,
    /// What to bless with instead of what is recorded: texts as of a configuration file, each over
    /// the one before.
    pub layers: Vec<String>,
    /// Tolerances to bless with, as `KEY=VALUE`.
    pub tolerances: Vec<String>,
    /// The configuration that ships, as such texts, to hold the logs to instead of that in their golden files.
    pub shipped: Option<Vec<String>>,
    /// Compare nothing but the confirmed features of the map.
    pub only_map: bool,
    /// A file that says what is required of the results.
    pub suite: Option<PathBuf>,
}

impl Options {
    /// Refuses reports in the place of a log, of a configuration or suite file, of a golden file, of what is kept of
    /// a log, or of each other; `json` goes to standard output.
    ///
    /// # Errors
    /// The file that would be destroyed.
    pub fn refuse_collisions(
        &self,
        junit: Option<&Path>,
        summary: Option<&Path>,
        config: Option<&Path>,
        json: bool,
    ) -> Result<(), OutputsError> {
        // A log that is given twice is refused elsewhere, with better words.
        let names = names(&self.logs, &self.golden);
        let golden = names.iter().map(|name| golden_file(&self.golden, name));
        let artifacts = self.artifacts.iter();
        let kept = artifacts.flat_map(|to| names.iter().flat_map(|name| artifacts_of(name, to)));
        let pictures = names.iter().filter(|_| self.bless);
        let pictures = pictures.map(|name| picture_of(&golden_file(&self.golden, name)));
        let written: BTreeSet<PathBuf> = golden.chain(kept).chain(pictures).collect();
        let inputs = self.logs.iter().chain(&self.suite).map(PathBuf::as_path);
        let inputs: Vec<&Path> = inputs.chain(config).collect();
        let outputs = written.iter().map(|path| Some(path.as_path()));
        let json = json.then(|| Path::new("-"));
        let outputs: Vec<Option<&Path>> = outputs.chain([junit, summary, json]).collect();
        refuse_collisions(&inputs, &outputs)
    }
}

/// A run, made ready.
#[derive(Debug)]
pub struct Suite {
    options: Options,
    jobs: Vec<Job>,
    artifacts: Option<Artifacts>,
    required: Requirements,
    notes: Vec<String>,
}

impl Suite {
    /// Finds each log's golden file and the part to be checked, and makes the directories.
    ///
    /// # Errors
    /// Whatever makes the run senseless before it begins.
    pub fn new(options: Options) -> Result<Self, CheckError> {
        if !options.layers.is_empty() && !options.bless {
            return Err(CheckError::ParametersWithoutBless);
        }
        let required = match &options.suite {
            Some(path) => required(path)?,
            None => Requirements::default(),
        };
        let partition = options.partition.as_deref().map(Partition::parse);
        let partition = partition.transpose()?;
        let ci = std::env::var("CI").is_ok_and(|value| is_set(&value));
        if options.bless && ci && !options.force {
            return Err(CheckError::BlessInCi);
        }
        (options.tolerances.iter()).try_fold(Tolerance::default(), Tolerance::with)?;
        if options.bless {
            make(&options.golden)?;
        } else if !options.golden.is_dir() {
            return Err(CheckError::NoGoldenDirectory {
                path: options.golden,
            });
        }
        let names = names(&options.logs, &options.golden);
        let mut logs = BTreeMap::<PathBuf, PathBuf>::new();
        for (log, name) in options.logs.iter().zip(&names) {
            let golden = golden_file(&options.golden, name);
            let (one, other) = (logs.insert(golden.clone(), log.clone()), log.clone());
            match one {
                None => {}
                Some(one) if same_file(&one, log) => {
                    return Err(CheckError::SameLog { log: other });
                }
                Some(one) => return Err(CheckError::SameGolden { one, other, golden }),
            }
        }
        let named: BTreeMap<&PathBuf, &String> = options.logs.iter().zip(&names).collect();
        let is_there = |log: &&str| {
            let golden = golden_file(&options.golden, log);
            logs.contains_key(&golden) || golden.exists()
        };
        if let Some(name) = required.logs().find(|log| !is_there(log)) {
            return Err(CheckError::RequiredOfNoLog {
                name: name.to_owned(),
            });
        }
        let mut left = left(&options.golden, &logs);
        let mut renamed = renamed(&logs, &left);
        left.retain(|golden| !renamed.values().any(|one| one == golden));
        // Of a suite in parts, all the parts know all the logs, and the first one tells.
        let tells = !options.bless && partition.is_none_or(|part| part.index == 1);
        let notes = if tells { unused(left) } else { Vec::new() };
        let jobs = logs.into_iter().map(|(golden, log)| Job {
            renamed: renamed.remove(&golden),
            name: named
                .get(&log)
                .map_or_else(String::new, |name| (*name).clone()),
            log,
            golden,
        });
        let jobs: Vec<Job> = match partition {
            Some(partition) => partition.of(jobs).collect(),
            None => jobs.collect(),
        };
        if let Some(directory) = &options.artifacts {
            make(directory)?;
        }
        Ok(Self {
            artifacts: options.artifacts.clone().map(|directory| Artifacts {
                directory,
                around: options.around,
            }),
            required,
            options,
            jobs,
            notes,
        })
    }

    /// What a person should know of the suite as a whole.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Checks or blesses every log, and goes on after one that fails; `tell` hears of each.
    pub fn run(&self, mut tell: impl FnMut(&Report)) -> Vec<Report> {
        let options = &self.options;
        let terms = Terms {
            strict: options.strict,
            only_map: options.only_map,
            shipped: options.shipped.as_deref(),
            required: &self.required,
            artifacts: self.artifacts.as_ref(),
        };
        let jobs = self.jobs.iter();
        jobs.map(|job| {
            let begun = Instant::now();
            let mut report = if options.bless {
                job.bless(&options.layers, &options.tolerances, &self.required)
            } else {
                job.check(&terms)
            };
            report.seconds = begun.elapsed().as_secs_f64();
            tell(&report);
            report
        })
        .collect()
    }
}

fn required(path: &Path) -> Result<Requirements, CheckError> {
    let text = read_text(path).map_err(|source| CheckError::ReadSuite {
        path: path.to_owned(),
        source,
    })?;
    Requirements::parse(&text).map_err(|source| CheckError::Suite {
        path: path.to_owned(),
        source,
    })
}

fn same_file(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => one == other,
    }
}

/// What logs are called: as their files, without the ending, with the folders before that where several are. One that
/// has no golden file by that name has the one by a name with more folders, as of a suite that is larger.
fn names(logs: &[PathBuf], golden: &Path) -> Vec<String> {
    let stem = |log: &Path| {
        log.file_stem()
            .unwrap_or(log.as_os_str())
            .to_string_lossy()
            .into_owned()
    };
    let mut called = BTreeMap::<String, u32>::new();
    for log in logs {
        *called.entry(stem(log)).or_default() += 1;
    }
    let apart = drives(logs.to_vec()).into_iter();
    let apart: BTreeMap<PathBuf, String> = apart.map(|drive| (drive.path, drive.name)).collect();
    let name = |log: &PathBuf| {
        let stem = stem(log);
        let is_shared = called.get(&stem).is_some_and(|logs| *logs > 1);
        let apart = apart.get(log).filter(|_| is_shared);
        let name = apart.unwrap_or(&stem).clone();
        let place = std::path::absolute(log).unwrap_or_else(|_| log.clone());
        let mut longer = stem;
        let longer = place
            .ancestors()
            .skip(1)
            .filter_map(Path::file_name)
            .map(|folder| {
                longer = format!("{}_{longer}", folder.to_string_lossy());
                longer.clone()
            });
        let longer = longer.filter(|longer| longer.len() > name.len());
        let mut all = std::iter::once(name.clone()).chain(longer);
        all.find(|name| golden_file(golden, name).exists())
            .unwrap_or(name)
    };
    logs.iter().map(name).collect()
}

/// `DIR/drive.golden.json` for the log that is called `drive`.
fn golden_file(directory: &Path, name: &str) -> PathBuf {
    directory.join(format!("{name}.golden.json"))
}

fn make(directory: &Path) -> Result<(), OutputError> {
    std::fs::create_dir_all(directory).map_err(|source| OutputError {
        path: directory.to_owned(),
        source,
    })
}

/// Golden files that no log of this run is called after.
fn left(directory: &Path, logs: &BTreeMap<PathBuf, PathBuf>) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(directory).into_iter().flatten().flatten();
    let is_golden = |path: &PathBuf| path.to_string_lossy().ends_with(".golden.json");
    let paths = entries.map(|entry| entry.path());
    let mut left: Vec<PathBuf> = paths
        .filter(|path| is_golden(path) && !logs.contains_key(path))
        .collect();
    left.sort();
    left
}

/// What golden files hold for which there is no log is not being checked.
fn unused(left: Vec<PathBuf>) -> Vec<String> {
    /// More of them are counted, not named.
    const NAMED: usize = 20;
    if left.is_empty() {
        return Vec::new();
    }
    let more = match left.len().saturating_sub(NAMED) {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    let named = left
        .iter()
        .take(NAMED)
        .map(|path| path.display().to_string());
    let named = named.collect::<Vec<_>>().join(", ");
    vec![format!("no log was given for {named}{more}")]
}

/// Part `index` of `count` of a big suite, counted from 1: the parts run beside each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Partition {
    index: usize,
    count: usize,
}

impl Partition {
    /// Of `I/N`.
    fn parse(text: &str) -> Result<Self, CheckError> {
        let part = text.split_once('/').and_then(|(index, count)| {
            let (index, count) = (index.parse().ok()?, count.parse().ok()?);
            let within = (1..=count).contains(&index);
            within.then_some(Self { index, count })
        });
        let text = text.to_owned();
        part.ok_or(CheckError::Partition { text })
    }

    /// Every `count`-th of a sorted list, beginning with the `index`-th: parts differ by one log at
    /// most, whatever order the logs are named in.
    fn of<T>(self, sorted: impl Iterator<Item = T>) -> impl Iterator<Item = T> {
        sorted.skip(self.index - 1).step_by(self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_of_one_name_are_called_by_their_folders() {
        let golden = tempfile::tempdir().unwrap();
        let called = |logs: &[&str]| {
            let logs: Vec<PathBuf> = logs.iter().map(PathBuf::from).collect();
            names(&logs, golden.path())
        };
        assert_eq!(called(&["r1/drive.mcap", "hall.mcap"]), ["drive", "hall"]);
        let two = called(&["r1/drive.mcap", "r2/drive.mcap"]);
        assert_eq!(two, ["r1_drive", "r2_drive"]);
        std::fs::write(golden_file(golden.path(), "r1_drive"), "").unwrap();
        assert_eq!(
            called(&["r1/drive.mcap"]),
            ["r1_drive"],
            "by itself as in the suite"
        );
        assert_eq!(called(&["r2/drive.mcap"]), ["drive"]);
    }

    #[test]
    fn the_parts_make_the_whole_and_share_nothing() {
        let parts = (1..=4).flat_map(|i| Partition { index: i, count: 4 }.of(0..10));
        let mut all: Vec<i32> = parts.collect();
        all.sort_unstable();
        assert_eq!(all, (0..10).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_no_part_is_refused() {
        assert_eq!(
            Partition::parse("2/4").unwrap(),
            Partition { index: 2, count: 4 }
        );
        for text in ["0/4", "5/4", "1/0", "1", "a/b", "-1/4", ""] {
            assert!(Partition::parse(text).is_err(), "{text}");
        }
    }
}
