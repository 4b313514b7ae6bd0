//! One log and its golden file: held to it, or blessed with it, and what is kept of one that differs.

use std::path::{Path, PathBuf};

use super::overlay::overlay;
use super::report::{CheckError, CheckResult, Compared, Report};
use crate::core::config::Config;
use crate::core::legible::inert_line;
use crate::core::log::Log;
use crate::core::observer::Kept;
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::io::config::file::layered;
use crate::io::config::render::render;
use crate::io::log::{itemised, read};
use crate::io::output::{Output, write_whole};
use crate::observe::recording::Recording;
use crate::observe::viewer;
use crate::tools::golden::{
    Comparison, Difference, Golden, GoldenError, LogInfo, RangeSigma, Results, Tolerance,
    as_recorded, carried, compare, results,
};

/// A log and its golden file.
#[derive(Debug, Clone)]
pub struct Job {
    pub log: PathBuf,
    pub golden: PathBuf,
}

impl Job {
    /// Replays the log with the configuration of its golden file and compares.
    pub fn check(&self, strict: bool, artifacts: Option<&Artifacts>) -> Report {
        if let Some(artifacts) = artifacts {
            artifacts.clear(&self.log);
        }
        self.compared(strict, artifacts)
            .unwrap_or_else(|error| self.report(error))
    }

    fn compared(&self, strict: bool, artifacts: Option<&Artifacts>) -> Result<Report, CheckError> {
        std::fs::metadata(&self.log).map_err(|source| GoldenError::Read {
            path: self.log.clone(),
            source,
        })?;
        if !self.golden.exists() {
            return Ok(self.without_golden(artifacts));
        }
        let (golden, unrecorded) = Golden::read(&self.golden)?;
        let (Some(config), Some(blessed)) = (&golden.config, &golden.log) else {
            return Err(self.of_a_test());
        };
        let log = read(&self.log, config)?;
        let replay = Replay::new(&log, config)?;
        let mut kept = Kept::default();
        let outcome = match artifacts {
            Some(_) => replay.run(&mut [&mut kept])?,
            None => replay.run(&mut [])?,
        };
        fit_to_compare(&log, &outcome)?;
        if golden.results.is_empty() {
            return Err(CheckError::Nothing(format!(
                "{} holds no feature; bless it again from a log that gives some",
                self.golden.display()
            )));
        }
        let results = results(&replay.setting(), &outcome);
        let mut found = compare(&golden.results, &results, &golden.tolerances);
        let info = LogInfo::of(&replay.setting());
        if blessed.events_sha256 != info.events_sha256 {
            let difference = Difference::Log {
                golden: blessed.events_sha256.clone(),
                actual: info.events_sha256.clone(),
            };
            found.differences.insert(0, difference);
        }
        let mut report = self.report(match found.matches(strict) {
            true => CheckResult::Matches,
            false => CheckResult::Differs,
        });
        report.notes = notes(&golden, &results, &unrecorded);
        if let (Some(artifacts), CheckResult::Differs) = (artifacts, &report.result) {
            let config = golden.config.clone();
            let new = Golden::new(Some(info), config, golden.tolerances, results);
            let replayed = (&replay, &outcome, &kept);
            match artifacts.write(&self.log, replayed, &golden, &new, &found) {
                Ok((new, recording)) => {
                    report.artifacts = [new].into_iter().chain(recording.clone()).collect();
                    report.recording = recording;
                }
                Err(error) => report.result = error.into(),
            }
        }
        let map = golden.results.map;
        report.compared = Some(Compared { map, found });
        Ok(report)
    }

    /// There is nothing to compare, but what would be blessed is kept. A log that cannot be read is
    /// unusable whoever blesses it.
    fn without_golden(&self, artifacts: Option<&Artifacts>) -> Report {
        let mut report = self.report(CheckResult::Nothing(format!(
            "there is no golden file {}; write it with --bless and commit it",
            self.golden.display()
        )));
        let config = Config::default();
        let kept = match artifacts {
            Some(artifacts) => self
                .new_golden(config, Tolerance::default())
                .and_then(|golden| artifacts.write_golden(&self.log, &golden).map(Some)),
            None => read(&self.log, &config)
                .map(|_| None)
                .map_err(CheckError::from),
        };
        match kept {
            Ok(new) => report.artifacts.extend(new),
            Err(CheckError::Nothing(_)) => {}
            Err(error) if error.wants_configuration() => report.notes.push(format!(
                "the default configuration does not do for this log, so give what it needs with --bless: {error}"
            )),
            Err(error) => report.result = error.into(),
        }
        report
    }

    /// Writes or updates the golden file.
    ///
    /// What is given of the configuration and the tolerances stands over what the old file records, and
    /// that over the defaults.
    pub fn bless(&self, layers: &[String], tolerances: &[String]) -> Report {
        let blessed = self.blessed(layers, tolerances);
        blessed.unwrap_or_else(|error| {
            self.report(match error {
                CheckError::Nothing(why) => CheckResult::Nothing(format!("not blessed: {why}")),
                error => error.into(),
            })
        })
    }

    fn blessed(&self, layers: &[String], tolerances: &[String]) -> Result<Report, CheckError> {
        let old = match self.golden.exists() {
            true => Some(Golden::read(&self.golden)?.0),
            false => None,
        };
        let (recorded, before) = match old
            .as_ref()
            .map(|old| (&old.log, &old.config, old.tolerances))
        {
            None => (Config::default(), Tolerance::default()),
            Some((Some(_), Some(config), tolerances)) => (config.clone(), tolerances),
            Some(_) => return Err(self.of_a_test()),
        };
        let tolerances = tolerances.iter().try_fold(before, Tolerance::with)?;
        let new = self.new_golden(layered(recorded, layers)?, tolerances)?;
        let bytes = new.render()?;
        // A new version that finds the same rewrites nothing.
        let same = |old: &Golden| {
            let mut old = old.clone();
            old.written_by = new.written_by.clone();
            old.render().is_ok_and(|old| old == bytes)
        };
        if old.as_ref().is_some_and(same) {
            return Ok(self.report(CheckResult::Unchanged));
        }
        write_whole(&self.golden, &bytes)?;
        let mut report = self.report(CheckResult::Blessed);
        if let Some(old) = old {
            report.notes = changed_terms(&old, &new);
            let found = compare(&old.results, &new.results, &old.tolerances);
            let map = old.results.map;
            report.compared = Some(Compared { map, found });
        }
        Ok(report)
    }

    /// The golden file of a whole log that gives something.
    fn new_golden(&self, config: Config, tolerances: Tolerance) -> Result<Golden, CheckError> {
        let config = as_recorded(&config)?;
        let log = read(&self.log, &config)?;
        let replay = Replay::new(&log, &config)?;
        let outcome = replay.run(&mut [])?;
        fit_to_compare(&log, &outcome)?;
        let results = results(&replay.setting(), &outcome);
        if results.is_empty() {
            return Err(CheckError::Nothing(format!(
                "{} gives no feature, and an empty result can never differ",
                log.file
            )));
        }
        let info = LogInfo::of(&replay.setting());
        Ok(Golden::new(Some(info), Some(config), tolerances, results))
    }

    fn of_a_test(&self) -> CheckError {
        CheckError::OfATest {
            golden: self.golden.clone(),
        }
    }

    /// A report without a comparison.
    fn report(&self, result: impl Into<CheckResult>) -> Report {
        Report {
            log: self.log.clone(),
            golden: self.golden.clone(),
            result: result.into(),
            notes: Vec::new(),
            compared: None,
            artifacts: Vec::new(),
            recording: None,
        }
    }
}

/// Only a whole log with echoes is compared.
fn fit_to_compare(log: &Log, outcome: &Outcome) -> Result<(), CheckError> {
    let file = &log.file;
    let lost = itemised(&log.losses);
    Err(CheckError::Nothing(if !log.losses.is_empty() {
        format!("{file} could not be read whole. Lost:{lost}")
    } else if outcome.tally.echoes == 0 {
        format!("not one reading of {file} is an echo")
    } else {
        return Ok(());
    }))
}

fn notes(golden: &Golden, actual: &Results, unrecorded: &[String]) -> Vec<String> {
    let mut notes = Vec::new();
    let (then, now) = (&golden.written_by.version, env!("CARGO_PKG_VERSION"));
    if then != now {
        notes.push(format!("blessed with tmam {then}, checked with {now}"));
    }
    if !unrecorded.is_empty() {
        notes.push(format!(
            "the golden file does not record {}; the present defaults hold. Bless again to record them",
            unrecorded.join(", ")
        ));
    }
    if let (RangeSigma::Unknown, RangeSigma::Measured(sigma)) = (golden.results.noise, actual.noise)
    {
        notes.push(format!(
            "the golden file does not record the noise of the ranges (`measured_sigma`), which they tell themselves: \
             {:.1} mm. So a change of it is not named. Bless again to record it",
            sigma * 1e3
        ));
    }
    let unmeasured = golden.results.labels.iter().flat_map(|labels| {
        let names = labels.sonars.keys().map(String::as_str);
        names.filter(|name| !labels.measured.contains_key(*name))
    });
    let unmeasured: Vec<&str> = unmeasured.collect();
    if !unmeasured.is_empty() {
        notes.push(format!(
            "the golden file does not record where {} is and what it measures (`measured`), so that is not checked. \
             Bless again to record it",
            inert_line(&unmeasured.join(", "))
        ));
    }
    notes
}

/// What is otherwise on the terms of the comparison: tolerances, configuration, log.
fn changed_terms(old: &Golden, new: &Golden) -> Vec<String> {
    let mut notes = Vec::new();
    let [before, after] =
        [old, new].map(|golden| serde_json::to_value(golden.tolerances).unwrap_or_default());
    for (key, value) in after.as_object().into_iter().flatten() {
        if let Some(was) = before.get(key).filter(|was| *was != value) {
            notes.push(format!("tolerance {key} {was} -> {value}"));
        }
    }
    let [before, after] =
        [old, new].map(|golden| golden.config.iter().flat_map(settings).collect());
    let (before, after): (Vec<String>, Vec<String>) = (before, after);
    let gone = before.iter().filter(|line| !after.contains(line));
    let come = after.iter().filter(|line| !before.contains(line));
    notes.extend(gone.map(|line| format!("configuration before: {line}")));
    notes.extend(come.map(|line| format!("configuration now: {line}")));
    let [before, after] =
        [old, new].map(|golden| golden.log.as_ref().map(|log| &log.events_sha256));
    if before != after {
        notes.push("the log holds other events than before".to_owned());
    }
    notes
}

/// A configuration as lines of `section.key = value`.
fn settings(config: &Config) -> Vec<String> {
    let mut section = String::new();
    let mut settings = Vec::new();
    for line in render(config).lines() {
        let line = line.split(" #").next().unwrap_or_default().trim();
        if line.starts_with('[') {
            section = line.trim_matches(['[', ']']).to_owned() + ".";
        } else if line.contains('=') && !line.starts_with('#') {
            settings.push(format!("{section}{line}"));
        }
    }
    settings
}

/// A directory for artefacts.
#[derive(Debug)]
pub struct Artifacts {
    pub directory: PathBuf,
    /// Record only so many frames about each difference.
    pub around: Option<u32>,
}

impl Artifacts {
    /// Writes the golden file that would make the log pass, and the recording, where this tmam writes
    /// recordings. What to mark in that is known only at the end of a replay, so all that it brought about
    /// was kept.
    ///
    /// # Errors
    /// When one of them cannot be written.
    fn write(
        &self,
        log: &Path,
        (replay, outcome, kept): (&Replay<'_>, &Outcome, &Kept),
        golden: &Golden,
        new: &Golden,
        found: &Comparison,
    ) -> Result<(PathBuf, Option<PathBuf>), CheckError> {
        let written = self.write_golden(log, new)?;
        if !viewer::IS_BUILT_IN {
            return Ok((written, None));
        }
        let [_, path] = artifacts_of(log, &self.directory);
        let mut out = Output::create(&path)?;
        let setting = replay.setting();
        let over = overlay(golden, &new.results, found, self.around);
        let mut recording = Recording::new(Some(&mut out), None, setting, over)?;
        kept.show(&mut recording).map_err(ReplayError::from)?;
        let carried = carried(&setting, outcome)?;
        recording.close(Some(&carried))?;
        out.commit()?;
        Ok((written, Some(path)))
    }

    /// Writes a golden file that a log could have.
    ///
    /// # Errors
    /// When it cannot be written.
    fn write_golden(&self, log: &Path, golden: &Golden) -> Result<PathBuf, CheckError> {
        let [path, _] = artifacts_of(log, &self.directory);
        write_whole(&path, &golden.render()?)?;
        Ok(path)
    }

    /// Takes away what an earlier run left of a log.
    fn clear(&self, log: &Path) {
        for path in artifacts_of(log, &self.directory) {
            // What is not there need not go.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The files that may be kept of a log: the golden file that it would get, and the recording.
pub fn artifacts_of(log: &Path, directory: &Path) -> [PathBuf; 2] {
    let stem = log.file_stem().unwrap_or(log.as_os_str());
    [".golden.json.new", ".check.rrd"].map(|extension| {
        let mut name = stem.to_owned();
        name.push(extension);
        directory.join(name)
    })
}
