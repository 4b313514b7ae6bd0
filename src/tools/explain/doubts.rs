//! What contradicts a label.

use serde::Serialize;

use crate::core::tmam::feature::Kind;
use crate::core::tmam::hypothesis::HypothesisTest;
use crate::core::tmam::report::ArcReport;

/// Something that contradicts a label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Doubt {
    /// Who says so: `map`, `triple`, `window` or `run`.
    pub by: &'static str,
    /// What it says instead: `line`, `point` or `neither`.
    pub says: &'static str,
    /// The map's feature that explains the reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feature: Option<u32>,
    /// How many readings were asked; `None` for the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readings: Option<usize>,
}

/// Everything that makes an arc suspect; empty for one that is not.
pub fn doubts(judgement: &ArcReport) -> Vec<Doubt> {
    if !judgement.is_suspect() {
        return Vec::new();
    }
    if let Some(map) = judgement.map.filter(|map| map.support.kind().is_some()) {
        return vec![Doubt {
            by: "map",
            says: map.support.name(),
            feature: map.feature,
            readings: None,
        }];
    }
    [
        ("triple", judgement.verdict.evidence.map(|e| e.opinion)),
        ("window", judgement.wide),
        ("run", judgement.run.map(|run| run.opinion)),
    ]
    .into_iter()
    .filter_map(|(by, opinion)| Some((by, opinion?)))
    // The window of a triple that decided is the triple.
    .filter(|(by, opinion)| *by != "window" || opinion.readings > 3)
    .filter(|(_, opinion)| opinion.contradicts(judgement.verdict.label))
    .map(|(by, opinion)| Doubt {
        by,
        says: opinion.support.name(),
        feature: None,
        readings: Some(opinion.readings),
    })
    .collect()
}

/// chi2 of the model that the label stands for.
pub fn chi2_of_label(judgement: &ArcReport) -> Option<f64> {
    let kind = judgement.verdict.label.kind()?;
    let triple = judgement.verdict.evidence.map(|e| e.opinion);
    let opinion: HypothesisTest = judgement.wide.or(triple)?;
    Some(match kind {
        Kind::Line => opinion.chi2_line,
        Kind::Point => opinion.chi2_point,
    })
}
