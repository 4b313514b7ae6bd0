//! What a replay came to.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc as Shared;

use serde::Serialize;

use super::stretch::Stretch;
use crate::core::event::SonarId;
use crate::core::frames::{Frame, Tally};
use crate::core::joint::{JointEstimate, OdometryKept};
use crate::core::noise_estimate::{NoiseEstimator, VarianceFrom};
use crate::core::tmam::feature::{Action, MapFeature};
use crate::core::tmam::prediction::MapPrediction;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::{Extraction, Step};

/// What a replay came to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outcome {
    /// Frames opened.
    pub frames: u32,
    /// The stamp of each.
    pub frame_stamps: Vec<i64>,
    /// Way from frame to frame, metres.
    pub distance: f64,
    /// What became of the readings.
    pub tally: Tally,
    /// Arcs by label.
    pub labels: BTreeMap<&'static str, u64>,
    /// Unidentified arcs by reason.
    pub reasons: BTreeMap<&'static str, u64>,
    /// Labels that the map prediction or a hypothesis test contradicts; `None` where no map predicts.
    pub suspects: Option<u64>,
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
    /// Every arc by frame and sonar, with all that is known of it.
    pub reports: Shared<Vec<ArcReport>>,
    /// What should have echoed by the map that the noise-aware rule makes of the log; `None` by other methods,
    /// whose maps do not say that.
    pub prediction: Option<MapPrediction>,
    /// Poses and features estimated together, or why the poses stay those of odometry; `None` where that
    /// was asked for.
    pub poses: Option<Result<JointEstimate, OdometryKept>>,
    /// What the log lacks for the method that was asked for.
    pub lacking: Option<String>,
    /// What is off, each tried, the weightiest first; `None` where that was not looked for.
    pub causes: Option<Vec<CauseTold>>,
    /// The stretch that the map explains least, where one stands out and that was looked for.
    pub stretch: Option<Stretch>,
}

/// What is off, in words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CauseTold {
    /// What it is, what mends it, and what comes of that.
    pub text: String,
    /// The keys that mend it, each as `--set` takes it.
    pub settings: Vec<String>,
    /// The sonar that it is of; `None` where it is of all of them, or of odometry.
    #[serde(skip)]
    pub sonar: Option<SonarId>,
}

impl Outcome {
    /// Before the first step.
    pub(super) fn new(variance_from: VarianceFrom, tally: Tally, frames: &[Frame]) -> Self {
        let places = || frames.iter().map(|frame| frame.world_from_robot.position());
        let ways = places().zip(places().skip(1)).map(|(a, b)| (b - a).norm());
        Self {
            frames: frames.last().map_or(0, |last| last.index + 1),
            frame_stamps: frames.iter().map(|frame| frame.stamp_ns).collect(),
            distance: ways.fold(0.0, |sum, way| sum + way),
            variance_from,
            tally,
            ..Self::default()
        }
    }

    /// Takes in what a frame brought about.
    pub(super) fn take(&mut self, step: &Step) {
        step.arcs.iter().for_each(|arc| self.scattering.push(arc));
        self.extractions.extend(step.extractions.iter().cloned());
    }

    /// The log has ended.
    pub(super) fn end(
        &mut self,
        step: Step,
        map: &[MapFeature],
        prediction: Option<MapPrediction>,
        poses: Option<Result<JointEstimate, OdometryKept>>,
    ) {
        self.extractions.extend(step.extractions);
        self.associated_readings = associated(&self.extractions);
        self.poses = poses;
        self.map = self.joint().map_or(map, |joint| &joint.features).to_vec();
        let suspects = || step.reports.iter().filter(|report| report.is_suspect());
        self.suspects = (prediction.as_ref()).map(|_| suspects().count() as u64);
        self.prediction = prediction;
        for report in step.reports.iter() {
            *self.labels.entry(report.label.name()).or_default() += 1;
            if let Some(reason) = report.label.reason() {
                *self.reasons.entry(reason.name()).or_default() += 1;
            }
        }
        self.reports = step.reports;
    }

    /// Poses and features estimated together, where they were.
    pub fn joint(&self) -> Option<&JointEstimate> {
        self.poses.as_ref()?.as_ref().ok()
    }

    /// How many arcs have a label.
    pub fn labelled(&self, label: &str) -> u64 {
        self.labels.get(label).copied().unwrap_or_default()
    }
}

/// How many readings stand behind features of the map.
fn associated(extractions: &[Extraction]) -> u64 {
    let arcs: BTreeSet<_> = extractions
        .iter()
        .filter(|extraction| !matches!(extraction.action, Action::Rejected(_)))
        .flat_map(|extraction| &extraction.associated)
        .collect();
    arcs.len() as u64
}
