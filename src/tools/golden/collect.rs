//! The results of a replay.

use std::collections::BTreeMap;

use super::profile::LogInfo;
use super::quality::Quality;
use super::results::{Feature, Geometry, LabelledArc, Labels, Mark, RangeSigma, Results, sigma_of};
use crate::core::event::{Sonar, name_of};
use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::core::statistics::seconds;
use crate::core::tmam::feature::{MapFeature, Shape};
use crate::core::tmam::label::{Kind, Label};
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Extraction;

/// The results of a replay.
pub fn results(setting: &Setting<'_>, outcome: &Outcome) -> Results {
    let runs = outcome.extractions.iter();
    let spans = spans(runs.filter_map(|run| Some((run.map_feature?.id, frames(run)?))));
    let timed = |feature: Feature| {
        let second = |frame: u32| {
            let stamp = outcome.frame_stamps.get(usize::try_from(frame).ok()?)?;
            let milliseconds = libm::rint(seconds(setting.origin_ns, *stamp) * 1e3);
            Some(milliseconds / 1e3)
        };
        let seconds = feature
            .frames
            .and_then(|[first, last]| Some([second(first)?, second(last)?]));
        Feature { seconds, ..feature }
    };
    let map = outcome.map.iter();
    let map = map.map(|one| timed(registered(one, spans.get(&one.id).copied())));
    let map: Vec<Feature> = map.collect();
    let confirmed = [Kind::Line, Kind::Point, Kind::Circle].map(|kind| {
        let is_one = |one: &&Feature| one.kind() == kind && one.is_confirmed();
        map.iter().filter(is_one).count() as u64
    });
    let extracted = outcome.extractions.iter();
    let extracted = extracted.map(|one| timed(self::extracted(one, setting.sonars)));
    Results {
        quality: Some(Quality::of(
            outcome,
            confirmed,
            setting.config.departures().circles,
        )),
        map,
        extracted: extracted.collect(),
        labels: Some(labels(setting.sonars, outcome)),
        noise: RangeSigma::of(outcome.variance_from, setting.config),
        log: Some(LogInfo::of(setting)),
        findings: None,
    }
}

/// The label of every arc.
pub fn labels(sonars: &[Sonar], outcome: &Outcome) -> Labels {
    let mut labels = Labels {
        frame_stamps: outcome.frame_stamps.clone(),
        ..Labels::default()
    };
    for report in outcome.reports.iter() {
        let sonar = name_of(sonars, report.arc.id.sonar).to_owned();
        let arcs = labels.sonars.entry(sonar).or_default();
        arcs.push(labelled(report));
    }
    for arcs in labels.sonars.values_mut() {
        arcs.sort_by_key(|arc| (arc.stamp_ns, arc.frame));
    }
    labels
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
            Label::Circle => Mark::Circle,
            Label::Unidentified(_) => Mark::Unidentified,
        },
        frame: Some(report.arc.id.frame),
        margin: report.margin,
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
    let feature = match shape {
        Shape::Line(line) => Feature::line(line.rho, line.theta, line.mid.into(), line.half_length),
        Shape::Point(point) => Feature::point(point.position.x, point.position.y),
        Shape::Circle(circle) => Feature::circle(circle.center.x, circle.center.y, circle.radius),
    };
    let covariance = shape.covariance();
    let sigma = match shape {
        Shape::Circle(circle) => sigma_of_circle(circle.covariance.transpose().into()),
        Shape::Line(_) | Shape::Point(_) => {
            covariance.and_then(|covariance| sigma_of([covariance.m11, covariance.m22]))
        }
    };
    Feature { sigma, ..feature }
}

/// The standard deviations of a circle's centre, along the worse of its axes, and of its radius.
pub fn sigma_of_circle([[xx, ..], [_, yy, _], [.., rr]]: [[f64; 3]; 3]) -> Option<[f64; 2]> {
    sigma_of([xx.max(yy), rr])
}
