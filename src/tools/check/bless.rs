//! Writing golden files: only from whole logs that gave something.

use std::io::Write as _;

use super::judge::{of_a_test, unfit, unusable};
use super::suite::{Job, Options};
use super::{CheckError, Found, Report, Verdict};
use crate::core::config::Config;
use crate::io::config::file::layered;
use crate::io::config::render::render;
use crate::io::output::Output;
use crate::tools::golden::{Golden, Tolerance, ToleranceError, as_recorded, compare, replay};

/// Writes or updates a log's golden file.
///
/// What is given of the configuration and the tolerances stands over what the old file records, and
/// that over the defaults.
pub fn bless(job: &Job, options: &Options) -> Report {
    try_bless(job, options).unwrap_or_else(|error| job.report(unusable(&error)))
}

fn try_bless(job: &Job, options: &Options) -> Result<Report, CheckError> {
    let old = match job.golden.exists() {
        true => Some(Golden::read(&job.golden)?.0),
        false => None,
    };
    if old
        .as_ref()
        .is_some_and(|old| old.log.is_none() || old.config.is_none())
    {
        return Ok(job.report(Verdict::Unusable(of_a_test(&job.golden))));
    }
    let recorded = old.as_ref().and_then(|old| old.config.clone());
    let config = layered(recorded.unwrap_or_default(), &options.layers)?;
    let config = as_recorded(&config)?;
    let tolerances = tolerances(old.as_ref(), &options.tolerances)?;
    let replayed = replay(&job.log, &config)?;
    if let Some(reason) = unfit(&replayed) {
        return Ok(job.report(Verdict::Nothing(format!("not blessed: {reason}"))));
    }
    if replayed.results.is_empty() {
        return Ok(job.report(Verdict::Nothing(format!(
            "not blessed: {} gives no feature, and an empty result can never differ",
            replayed.log.file
        ))));
    }
    let new = Golden::new(
        Some(replayed.info),
        Some(config),
        tolerances,
        replayed.results,
    );
    if old
        .as_ref()
        .is_some_and(|old| same_but_for_the_tool(old, &new))
    {
        return Ok(job.report(Verdict::Unchanged));
    }
    let bytes = new.render()?;
    let mut out = Output::create(&job.golden)?;
    out.write_all(&bytes).map_err(|source| out.failed(source))?;
    out.commit()?;

    let mut report = job.report(Verdict::Blessed);
    if let Some(old) = old {
        report.notes = changed_terms(&old, &new);
        let comparison = compare(&old.results, &new.results, &old.tolerances);
        report.found = Some(Found {
            golden: old,
            actual: new.results,
            comparison,
        });
    }
    Ok(report)
}

fn tolerances(old: Option<&Golden>, given: &[String]) -> Result<Tolerance, ToleranceError> {
    let before = old.map(|old| old.tolerances).unwrap_or_default();
    given.iter().try_fold(before, |all, one| all.with(one))
}

/// A new version that finds the same rewrites nothing.
fn same_but_for_the_tool(old: &Golden, new: &Golden) -> bool {
    let old = Golden {
        tool: new.tool.clone(),
        ..old.clone()
    };
    let bytes = |golden: &Golden| golden.render().ok();
    bytes(&old).is_some_and(|bytes_of_old| Some(bytes_of_old) == bytes(new))
}

/// What is otherwise on the terms of the comparison: tolerances, configuration, log.
fn changed_terms(old: &Golden, new: &Golden) -> Vec<String> {
    let mut notes = Vec::new();
    let fields = |tolerance: &Tolerance| match serde_json::to_value(tolerance) {
        Ok(serde_json::Value::Object(fields)) => fields,
        _ => serde_json::Map::new(),
    };
    let (before, after) = (fields(&old.tolerances), fields(&new.tolerances));
    for (key, value) in &after {
        if let Some(was) = before.get(key).filter(|was| *was != value) {
            notes.push(format!("tolerance {key} {was} -> {value}"));
        }
    }
    notes.extend(changed_config(old.config.as_ref(), new.config.as_ref()));
    let digest = |golden: &Golden| golden.log.as_ref().map(|log| log.events_sha256.clone());
    if digest(old) != digest(new) {
        notes.push("the log holds other events than before".to_owned());
    }
    notes
}

/// The lines of the configuration that are not what they were.
fn changed_config(old: Option<&Config>, new: Option<&Config>) -> Vec<String> {
    let (Some(old), Some(new)) = (old, new) else {
        return Vec::new();
    };
    let settings = |config: &Config| -> Vec<String> {
        let mut section = String::new();
        let mut settings = Vec::new();
        for line in render(config).lines() {
            let line = line.split(" #").next().unwrap_or_default().trim();
            if line.starts_with('[') {
                section = line.trim_matches(['[', ']']).to_owned();
            } else if line.contains('=') && !line.starts_with('#') {
                let dot = if section.is_empty() { "" } else { "." };
                settings.push(format!("{section}{dot}{line}"));
            }
        }
        settings
    };
    let (old, new) = (settings(old), settings(new));
    let gone = old.iter().filter(|line| !new.contains(line));
    let come = new.iter().filter(|line| !old.contains(line));
    gone.map(|line| format!("configuration before: {line}"))
        .chain(come.map(|line| format!("configuration now: {line}")))
        .collect()
}
