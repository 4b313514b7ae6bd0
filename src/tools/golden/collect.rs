//! What a golden file holds of a replay.

use std::collections::BTreeMap;

use super::range_noise::RangeNoise;
use super::results::{Feature, LabelledArc, Labels, Margin, Mark, Measured, Results, micro};
use crate::core::event::{Sonar, SonarId};
use crate::core::replay::Outcome;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{Action, MapFeature, Shape};
use crate::core::tmam::label::Label;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Extraction;

/// The results of a replay of these sonars.
pub fn results(sonars: &[Sonar], outcome: &Outcome) -> Results {
    let mut spans = BTreeMap::<u32, [u32; 2]>::new();
    for extraction in &outcome.extractions {
        if let (Some(feature), Some([first, last])) = (extraction.map_feature, frames(extraction)) {
            let span = spans.entry(feature.id).or_insert([first, last]);
            *span = [span[0].min(first), span[1].max(last)];
        }
    }
    let map = outcome.map.iter();
    Results {
        map: map
            .map(|feature| registered(feature, spans.get(&feature.id).copied()))
            .collect(),
        extracted: outcome
            .extractions
            .iter()
            .map(|extraction| extracted(extraction, sonars))
            .collect(),
        labels: Some(labels(sonars, outcome)),
        noise: RangeNoise::Unknown,
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
        let sonar = name(sonars, Some(&report.arc.id)).unwrap_or_default();
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

fn name(sonars: &[Sonar], arc: Option<&ArcId>) -> Option<String> {
    let sonar = sonars.get(arc?.sonar.index())?;
    Some(sonar.name.clone())
}

fn extracted(extraction: &Extraction, sonars: &[Sonar]) -> Feature {
    let fate = match extraction.action {
        Action::Registered(_) => "registered",
        Action::Merged(_) => "merged",
        Action::Rejected(why) => why.name(),
    };
    let mut feature = match &extraction.shape {
        Some(shape) => shaped(shape),
        None => Feature::new(extraction.kind, None),
    };
    feature.id = extraction.id;
    feature.readings = u32::try_from(extraction.associated.len()).unwrap_or(u32::MAX);
    feature.frames = frames(extraction);
    feature.sensor = name(sonars, extraction.associated.first());
    feature.fate = Some(fate.to_owned());
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
    let sigma = [covariance.m11, covariance.m22].map(|variance| micro(variance.max(0.0).sqrt()));
    Feature {
        sigma: sigma.iter().all(|s| s.is_finite()).then_some(sigma),
        ..feature
    }
}
