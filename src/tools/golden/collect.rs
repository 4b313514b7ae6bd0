//! The results of a replay, gathered by an observer while it runs, and which log they are of.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::results::{
    Feature, Geometry, LabelledArc, Labels, Margin, Mark, Measured, RangeSigma, Results, micro,
    sigma_of,
};
use crate::core::event::{Events, Sonar, SonarId};
use crate::core::frames::Frame;
use crate::core::log::Log;
use crate::core::observer::{Observer, ObserverError};
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::rounding::rounded;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{Action, Extraction, MapFeature, Shape};
use crate::core::tmam::step::Step;
use crate::core::tmam::triple::{Label, Verdict};

/// An observer that keeps the label of every arc.
#[derive(Debug)]
pub struct Collector {
    sonars: Vec<Sonar>,
    /// Number and sum of the ranges of each sonar's arcs.
    ranges: BTreeMap<SonarId, (u32, f64)>,
    stamps: BTreeMap<ArcId, i64>,
    labels: Labels,
}

/// Replays a log for its results.
///
/// # Errors
/// As the replay fails.
pub fn results_of(replay: &Replay<'_>) -> Result<(Results, Outcome), ReplayError> {
    let setting = replay.setting();
    let mut collector = Collector::new(setting.sonars);
    let outcome = replay.run(&mut [&mut collector])?;
    let results = Results {
        noise: RangeSigma::of(outcome.variance_from, setting.config),
        ..collector.finish(&outcome)
    };
    Ok((results, outcome))
}

impl Collector {
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            sonars: sonars.to_vec(),
            ranges: BTreeMap::new(),
            stamps: BTreeMap::new(),
            labels: Labels::default(),
        }
    }

    /// The results, but for the noise of the ranges.
    pub fn finish(mut self, outcome: &Outcome) -> Results {
        for arcs in self.labels.sonars.values_mut() {
            arcs.sort_by_key(|arc| (arc.stamp_ns, arc.frame));
        }
        self.labels.measured = self.measured();
        let runs = outcome.extractions.iter();
        let spans = spans(runs.filter_map(|run| Some((run.map_feature?.id, frames(run)?))));
        let map = outcome.map.iter();
        let extracted = outcome.extractions.iter();
        Results {
            map: map
                .map(|one| registered(one, spans.get(&one.id).copied()))
                .collect(),
            extracted: extracted.map(|one| self.extracted(one)).collect(),
            labels: Some(self.labels),
            noise: RangeSigma::Unknown,
        }
    }

    fn measured(&self) -> BTreeMap<String, Measured> {
        let of = |(id, (count, sum)): (&SonarId, &(u32, f64))| {
            let sonar = self.sonars.get(id.index())?;
            let mount = sonar.robot_from_sensor;
            let measured = Measured {
                mount: [mount.x, mount.y, mount.yaw].map(micro),
                mean_range: micro(sum / f64::from(*count)),
            };
            Some((sonar.name.clone(), measured))
        };
        self.ranges.iter().filter_map(of).collect()
    }

    fn sonar(&self, arc: Option<&ArcId>) -> Option<String> {
        self.sonars
            .get(arc?.sonar.index())
            .map(|sonar| sonar.name.clone())
    }

    fn extracted(&self, extraction: &Extraction) -> Feature {
        let fate = match extraction.action {
            Action::Registered(_) => "registered",
            Action::Merged(_) => "merged",
            Action::Rejected(why) => why.name(),
        };
        let mut feature = match &extraction.shape {
            Some(shape) => shaped(shape),
            None => Feature::new(Geometry::Unfitted {
                kind: extraction.kind,
            }),
        };
        feature.id = extraction.id;
        feature.readings = u32::try_from(extraction.associated.len()).unwrap_or(u32::MAX);
        feature.frames = frames(extraction);
        feature.sensor = self.sonar(extraction.associated.first());
        feature.fate = Some(fate.to_owned());
        feature
    }

    fn take(&mut self, step: &Step) {
        self.stamps
            .extend(step.arcs.iter().map(|arc| (arc.id, arc.stamp_ns)));
        for arc in &step.arcs {
            let (count, sum) = self.ranges.entry(arc.id.sonar).or_default();
            *count += 1;
            *sum += arc.range;
        }
        for verdict in &step.verdicts {
            let Some(stamp_ns) = self.stamps.remove(&verdict.arc) else {
                continue;
            };
            let sonar = self.sonar(Some(&verdict.arc)).unwrap_or_default();
            self.labels
                .sonars
                .entry(sonar)
                .or_default()
                .push(labelled(verdict, stamp_ns));
        }
    }
}

impl Observer for Collector {
    fn frame(&mut self, frame: &Frame, step: &Step) -> Result<(), ObserverError> {
        self.labels.frame_stamps.push(frame.stamp_ns);
        self.take(step);
        Ok(())
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        self.take(step);
        Ok(())
    }
}

fn labelled(verdict: &Verdict, stamp_ns: i64) -> LabelledArc {
    LabelledArc {
        stamp_ns,
        mark: match verdict.label {
            Label::Contact => Mark::Contact,
            Label::Intersection => Mark::Intersection,
            Label::Unidentified(_) => Mark::Unidentified,
        },
        frame: Some(verdict.arc.frame),
        margin: verdict
            .margin
            .map(Margin::Angle)
            .or(verdict.chi2_margin.map(Margin::Chi2)),
        reason: verdict.label.reason().map(|reason| reason.name()),
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
    /// The [`digest`] of its events.
    pub events_sha256: String,
}

impl LogInfo {
    pub fn of(log: &Log) -> Self {
        Self {
            file: log.file.clone(),
            events_sha256: digest(&log.events),
        }
    }
}

/// SHA-256 over what was read from a log: sonars and their mounts, readings, odometry, in stamp order.
///
/// Of the events, not of the file: a log that was compressed otherwise, cut into other chunks or
/// written in another order holds the same drive. Numbers count to 1e-9.
pub fn digest(events: &Events) -> String {
    let mut hash = Sha256::new();
    let numbers = |hash: &mut Sha256, numbers: &[f64]| {
        for number in numbers {
            let number = if number.is_nan() {
                f64::NAN
            } else {
                rounded(*number)
            };
            hash.update(number.to_bits().to_le_bytes());
        }
    };
    hash.update((events.sonars.len() as u64).to_le_bytes());
    for sonar in &events.sonars {
        hash.update((sonar.name.len() as u64).to_le_bytes());
        hash.update(sonar.name.as_bytes());
        let mount = sonar.robot_from_sensor;
        numbers(&mut hash, &[mount.x, mount.y, mount.yaw]);
    }
    hash.update((events.readings.len() as u64).to_le_bytes());
    for r in &events.readings {
        hash.update(r.stamp_ns.to_le_bytes());
        hash.update(r.sonar.0.to_le_bytes());
        numbers(
            &mut hash,
            &[r.range, r.min_range, r.max_range, r.beam_width, r.variance],
        );
    }
    hash.update((events.odometry.len() as u64).to_le_bytes());
    for sample in &events.odometry {
        hash.update(sample.stamp_ns.to_le_bytes());
        let pose = sample.world_from_robot;
        numbers(&mut hash, &[pose.x, pose.y, pose.yaw]);
    }
    format!("{:x}", hash.finalize())
}
