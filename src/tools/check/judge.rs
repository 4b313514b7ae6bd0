//! One log against its golden file.

use std::path::Path;

use super::artifacts::Artifacts;
use super::suite::Job;
use super::{CheckError, Found, Report, Verdict};
use crate::core::config::Config;
use crate::core::legible::inert_line;
use crate::core::replay::ReplayError;
use crate::io::log::{self, itemised};
use crate::tools::golden::{
    Difference, Golden, GoldenError, RangeNoise, Replayed, Results, compare, replay,
};

/// Replays a log with the configuration of its golden file and compares.
pub fn judge(job: &Job, strict: bool, artifacts: Option<&Artifacts>) -> Report {
    if let Some(artifacts) = artifacts {
        artifacts.clear(job);
    }
    if let Err(source) = std::fs::metadata(&job.log) {
        let path = job.log.clone();
        return job.report(unusable(&GoldenError::Read { path, source }.into()));
    }
    if !job.golden.exists() {
        return without_golden(job, artifacts);
    }
    let (golden, unrecorded) = match Golden::read(&job.golden) {
        Ok(read) => read,
        Err(error) => return job.report(unusable(&error.into())),
    };
    let (Some(config), Some(blessed)) = (&golden.config, &golden.log) else {
        return job.report(Verdict::Unusable(of_a_test(&job.golden)));
    };
    let replayed = match replay(&job.log, config) {
        Ok(replayed) => replayed,
        Err(error) => return job.report(unusable(&error.into())),
    };
    if let Some(reason) = unfit(&replayed) {
        return job.report(Verdict::Nothing(reason));
    }
    if golden.results.is_empty() {
        return job.report(Verdict::Nothing(format!(
            "{} holds no feature; bless it again from a log that gives some",
            job.golden.display()
        )));
    }
    let mut comparison = compare(&golden.results, &replayed.results, &golden.tolerances);
    if blessed.events_sha256 != replayed.info.events_sha256 {
        let difference = Difference::Log {
            golden: blessed.events_sha256.clone(),
            actual: replayed.info.events_sha256.clone(),
        };
        comparison.differences.insert(0, difference);
    }
    let matches = comparison.matches(strict);
    let mut report = job.report(if matches {
        Verdict::Matches
    } else {
        Verdict::Differs
    });
    report.notes = notes(&golden, &replayed.results, &unrecorded);
    if let Some(artifacts) = artifacts.filter(|_| !matches) {
        match artifacts.write(job, &golden, config, &replayed, &comparison) {
            Ok((files, recording)) => {
                report.artifacts = files;
                report.recording = recording;
            }
            Err(error) => report.verdict = unusable(&error),
        }
    }
    report.found = Some(Found {
        golden,
        actual: replayed.results,
        comparison,
    });
    report
}

/// A log that nobody has blessed yet: nothing to judge, but what would be blessed is kept. One that
/// cannot be read is unusable whoever blesses it.
fn without_golden(job: &Job, artifacts: Option<&Artifacts>) -> Report {
    let mut report = job.report(Verdict::Nothing(format!(
        "there is no golden file {}; write it with --bless and commit it",
        job.golden.display()
    )));
    let kept = match artifacts {
        Some(artifacts) => artifacts.first(job),
        None => log::read(&job.log, &Config::default())
            .map(|_| None)
            .map_err(|error| GoldenError::from(error).into()),
    };
    match kept {
        Ok(new) => report.artifacts.extend(new),
        Err(error) if wants_configuration(&error) => report.notes.push(format!(
            "the default configuration does not do for this log, so give what it needs with --bless: {error}"
        )),
        Err(error) => report.verdict = unusable(&error),
    }
    report
}

fn wants_configuration(error: &CheckError) -> bool {
    match error {
        CheckError::Golden(GoldenError::Log(error)) => error.wants_configuration(),
        CheckError::Golden(GoldenError::Replay(error)) => {
            !matches!(error, ReplayError::Observer(_))
        }
        _ => false,
    }
}

/// Why a golden file is none of a log.
pub fn of_a_test(golden: &Path) -> String {
    format!(
        "{} was made from no log: it holds results of a Rust test. Bless the log into another directory",
        golden.display()
    )
}

/// Why a log is no ground to judge on; `None` for a good one.
pub fn unfit(replayed: &Replayed) -> Option<String> {
    if !replayed.log.losses.is_empty() {
        return Some(format!(
            "{} could not be read whole. Lost:{}",
            replayed.log.file,
            itemised(&replayed.log.losses)
        ));
    }
    (replayed.echoes == 0).then(|| format!("not one reading of {} is an echo", replayed.log.file))
}

/// The verdict for an error.
pub fn unusable(error: &CheckError) -> Verdict {
    if matches!(error, CheckError::Golden(error) if error.found_nothing()) {
        Verdict::Nothing(error.to_string())
    } else {
        Verdict::Unusable(error.to_string())
    }
}

fn notes(golden: &Golden, actual: &Results, unrecorded: &[String]) -> Vec<String> {
    let mut notes = Vec::new();
    if golden.tool.version != env!("CARGO_PKG_VERSION") {
        notes.push(format!(
            "blessed with tmam {}, checked with {}",
            golden.tool.version,
            env!("CARGO_PKG_VERSION")
        ));
    }
    if !unrecorded.is_empty() {
        notes.push(format!(
            "the golden file does not record {}; the present defaults hold. Bless again to record them",
            unrecorded.join(", ")
        ));
    }
    if let (RangeNoise::Unknown, RangeNoise::Measured(sigma)) = (golden.results.noise, actual.noise)
    {
        notes.push(format!(
            "the golden file does not record the noise of the ranges (`measured_sigma`), which they tell themselves: \
             {:.1} mm. So a change of it is not named. Bless again to record it",
            sigma * 1e3
        ));
    }
    let unmeasured = unmeasured(golden);
    if !unmeasured.is_empty() {
        notes.push(format!(
            "the golden file does not record where {} is and what it measures (`measured`), so that is not checked. \
             Bless again to record it",
            inert_line(&unmeasured.join(", "))
        ));
    }
    notes
}

/// Sonars whose mount and mean range nobody holds.
fn unmeasured(golden: &Golden) -> Vec<&str> {
    let labels = golden.results.labels.as_ref();
    let sonars = labels.into_iter().flat_map(|labels| {
        let names = labels.sonars.keys();
        names.filter(|name| !labels.measured.contains_key(*name))
    });
    sonars.map(String::as_str).collect()
}
