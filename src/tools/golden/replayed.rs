//! A log replayed to be compared: with what a replay warns of, and held against the truth where the log carries it.

use std::collections::BTreeMap;
use std::path::Path;

use super::collect::results;
use super::results::Results;
use crate::core::replay::{Outcome, Replay};
use crate::core::rounding::micro;
use crate::io::log::survey::Survey;
use crate::io::log::{LogError, read_with_truth, truth};
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::evaluate::{Evaluation, Truth};
use crate::tools::findings::examined::Examined;
use crate::tools::findings::facts::Facts;
use crate::tools::findings::findings;

/// The results of a replay of the log at `path`, all of them; the outcome is given back.
///
/// # Errors
/// When the truth that the log carries cannot be read.
pub fn all_results(
    path: &Path,
    survey: &Survey,
    replay: &Replay<'_>,
    outcome: Outcome,
) -> Result<(Results, Outcome), LogError> {
    let mut results = results(&replay.setting(), &outcome);
    let is_truth = |name: &str| name == truth::WORLD_SCHEMA;
    if survey
        .channels
        .iter()
        .any(|channel| is_truth(&channel.type_name))
    {
        let (_, recorded) = read_with_truth(path, replay.config())?;
        // Truth that is of no use is told by `evaluate`.
        let known = Truth::if_known(replay, &recorded, None, AGREEING_RANGE).unwrap_or_default();
        if let (Some(truth), Some(quality)) = (known, &mut results.quality) {
            let scores = Evaluation::new(&truth, &replay.path(&outcome), &outcome);
            quality.wrong_labels = scores.labels.wrong_share.map(micro);
            let of_kinds = [&scores.confirmed.lines, &scores.confirmed.points];
            let known = of_kinds.map(|kind| &kind.errors.nees);
            let sum = |of: fn(f64, f64) -> f64| {
                let known = known
                    .iter()
                    .filter_map(|nees| Some(of(nees.features as f64, nees.mean?)));
                known.fold(0.0, |sum, one| sum + one)
            };
            let features = sum(|features, _| features);
            quality.nees = (features > 0.0).then(|| micro(sum(|n, mean| n * mean) / features));
        }
    }
    let mut facts = Facts::new(survey, Some(outcome));
    let found = findings(&Examined {
        facts: &facts,
        survey,
        // Advice is not compared, so none is tried.
        attempt: &|_| None,
    });
    let mut warned = BTreeMap::new();
    for finding in found {
        warned
            .entry(finding.code.to_owned())
            .or_insert(finding.what);
    }
    results.findings = Some(warned);
    Ok((results, facts.replay.outcome.take().unwrap_or_default()))
}
