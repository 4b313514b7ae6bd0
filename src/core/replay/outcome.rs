//! What a replay came to.

use std::collections::{BTreeMap, BTreeSet};

use crate::core::frames::Tally;
use crate::core::noise_estimate::{NoiseEstimator, VarianceFrom};
use crate::core::tmam::feature::{Action, Extraction, MapFeature};
use crate::core::tmam::step::Step;
use crate::core::tmam::triple::Label;

/// What a replay came to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outcome {
    /// Frames opened.
    pub frames: u32,
    /// Way from frame to frame, metres.
    pub distance: f64,
    /// What became of the readings.
    pub tally: Tally,
    /// Arcs by label.
    pub labels: BTreeMap<&'static str, u64>,
    /// Unidentified arcs by reason.
    pub reasons: BTreeMap<&'static str, u64>,
    /// Labelled arcs that their own readings contradict.
    pub suspects: u64,
    /// How far the ranges of each sonar scatter.
    pub scattering: NoiseEstimator,
    /// Where their variance comes from.
    pub variance_from: VarianceFrom,
    /// Readings that stand behind a registered or merged feature, each counted once.
    pub associated_readings: u64,
    /// Every closed run, in the order of extraction.
    pub extractions: Vec<Extraction>,
    /// The final map, by id.
    pub map: Vec<MapFeature>,
}

impl Outcome {
    /// Counts what a step brought about.
    pub(super) fn take(&mut self, step: &Step) {
        step.arcs.iter().for_each(|arc| self.scattering.push(arc));
        for verdict in &step.verdicts {
            *self.labels.entry(verdict.label.name()).or_default() += 1;
            if let Label::Unidentified(reason) = verdict.label {
                *self.reasons.entry(reason.name()).or_default() += 1;
            }
        }
        self.extractions.extend(step.extractions.iter().cloned());
        let suspects = step.judgements.iter().filter(|j| j.is_suspect());
        self.suspects += suspects.count() as u64;
    }

    /// How many arcs have a label.
    pub fn labelled(&self, label: &str) -> u64 {
        self.labels.get(label).copied().unwrap_or_default()
    }
}

/// How many readings stand behind features of the map.
pub(super) fn associated(extractions: &[Extraction]) -> u64 {
    let arcs: BTreeSet<_> = extractions
        .iter()
        .filter(|extraction| !matches!(extraction.action, Action::Rejected(_)))
        .flat_map(|extraction| &extraction.associated)
        .collect();
    arcs.len() as u64
}
