//! The results of a replay, and which log they are of.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::results::{
    Feature, Geometry, LabelledArc, Labels, Margin, Mark, Measured, RangeSigma, Results, micro,
    sigma_of,
};
use crate::core::event::{Sonar, SonarId, name_of};
use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::core::tmam::feature::{MapFeature, Shape};
use crate::core::tmam::label::Label;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Extraction;

/// The results of a replay.
pub fn results(setting: &Setting<'_>, outcome: &Outcome) -> Results {
    let runs = outcome.extractions.iter();
    let spans = spans(runs.filter_map(|run| Some((run.map_feature?.id, frames(run)?))));
    let map = outcome.map.iter();
    let extractions = outcome.extractions.iter();
    Results {
        map: map
            .map(|one| registered(one, spans.get(&one.id).copied()))
            .collect(),
        extracted: extractions
            .map(|one| extracted(one, setting.sonars))
            .collect(),
        labels: Some(labels(setting.sonars, outcome)),
        noise: RangeSigma::of(outcome.variance_from, setting.config),
    }
}

/// The label of every arc.
pub fn labels(sonars: &[Sonar], outcome: &Outcome) -> Labels {
    let mut labels = Labels {
        frame_stamps: outcome.frame_stamps.clone(),
        measured: measured(sonars, outcome),
        ..Labels::default()
    };
    for report in &outcome.reports {
        let sonar = name_of(sonars, report.arc.id.sonar).to_owned();
        let arcs = labels.sonars.entry(sonar).or_default();
        arcs.push(labelled(report));
    }
    for arcs in labels.sonars.values_mut() {
        arcs.sort_by_key(|arc| (arc.stamp_ns, arc.frame));
    }
    labels
}

/// Mount and mean range of each sonar that gave an arc.
fn measured(sonars: &[Sonar], outcome: &Outcome) -> BTreeMap<String, Measured> {
    let mut ranges = BTreeMap::<SonarId, (u32, f64)>::new();
    for report in &outcome.reports {
        let (count, sum) = ranges.entry(report.arc.id.sonar).or_default();
        *count += 1;
        *sum += report.arc.range;
    }
    let of = |(id, (count, sum)): (&SonarId, &(u32, f64))| {
        let sonar = sonars.get(id.index())?;
        let mount = sonar.robot_from_sensor;
        let measured = Measured {
            mount: [mount.x, mount.y, mount.yaw].map(micro),
            mean_range: micro(sum / f64::from(*count)),
        };
        Some((sonar.name.clone(), measured))
    };
    ranges.iter().filter_map(of).collect()
}

fn extracted(extraction: &Extraction, sonars: &[Sonar]) -> Feature {
    let mut feature = match &extraction.shape {
        Some(shape) => shaped(shape),
        None => Feature::new(Geometry::Unfitted {
            kind: extraction.kind,
        }),
    };
    feature.id = extraction.id;
    feature.readings = u32::try_from(extraction.associated.len()).unwrap_or(u32::MAX);
    feature.frames = frames(extraction);
    let first = extraction.associated.first();
    feature.sensor = first.map(|arc| name_of(sonars, arc.sonar).to_owned());
    feature.fate = Some(extraction.action.fate().to_owned());
    feature
}

fn labelled(report: &ArcReport) -> LabelledArc {
    LabelledArc {
        stamp_ns: report.arc.stamp_ns,
        mark: match report.label {
            Label::Contact => Mark::Contact,
            Label::Intersection => Mark::Intersection,
            Label::Unidentified(_) => Mark::Unidentified,
        },
        frame: Some(report.arc.id.frame),
        margin: report
            .margin
            .map(Margin::Angle)
            .or(report.chi2_margin.map(Margin::Chi2)),
        reason: report.label.reason().map(|reason| reason.name()),
    }
}

fn frames(extraction: &Extraction) -> Option<[u32; 2]> {
    let (first, last) = (
        extraction.associated.first()?,
        extraction.associated.last()?,
    );
    Some([first.frame, last.frame])
}

/// First and last frame of the runs behind each feature of the map, by its id.
pub fn spans(runs: impl Iterator<Item = (u32, [u32; 2])>) -> BTreeMap<u32, [u32; 2]> {
    let mut spans = BTreeMap::new();
    for (id, [first, last]) in runs {
        let span = spans.entry(id).or_insert([first, last]);
        *span = [span[0].min(first), span[1].max(last)];
    }
    spans
}

fn registered(feature: &MapFeature, frames: Option<[u32; 2]>) -> Feature {
    Feature {
        id: feature.id,
        readings: feature.readings,
        frames,
        fate: Some(feature.status.name().to_owned()),
        ..shaped(&feature.shape)
    }
}

fn shaped(shape: &Shape) -> Feature {
    let (feature, covariance) = match shape {
        Shape::Line(line) => (
            Feature::line(line.rho, line.theta, line.mid.into(), line.half_length),
            line.covariance,
        ),
        Shape::Point(point) => (
            Feature::point(point.position.x, point.position.y),
            point.covariance,
        ),
    };
    Feature {
        sigma: sigma_of([covariance.m11, covariance.m22]),
        ..feature
    }
}

/// The log that results come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogInfo {
    /// Its file name.
    pub file: String,
    /// The digest of its events.
    pub events_sha256: String,
}

impl LogInfo {
    pub fn of(setting: &Setting<'_>) -> Self {
        Self {
            file: setting.source.file.clone(),
            events_sha256: setting.events_sha256.to_owned(),
        }
    }
}
