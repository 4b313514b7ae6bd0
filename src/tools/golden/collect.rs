//! Gathers, while a replay runs, what a golden file holds.

use std::collections::BTreeMap;

use super::range_noise::RangeNoise;
use super::results::{Feature, LabelledArc, Labels, Margin, Mark, Measured, Results, micro};
use crate::core::event::{Sonar, SonarId};
use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError};
use crate::core::replay::Outcome;
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

impl Collector {
    /// A collector that has seen nothing yet.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            sonars: sonars.to_vec(),
            ranges: BTreeMap::new(),
            stamps: BTreeMap::new(),
            labels: Labels::default(),
        }
    }

    /// What the replay came to.
    pub fn finish(mut self, outcome: &Outcome) -> Results {
        for arcs in self.labels.sonars.values_mut() {
            arcs.sort_by_key(|arc| (arc.stamp_ns, arc.frame));
        }
        self.labels.measured = self.measured();
        let mut spans = BTreeMap::<u32, [u32; 2]>::new();
        for extraction in &outcome.extractions {
            if let (Some(feature), Some([first, last])) =
                (extraction.map_feature, frames(extraction))
            {
                let span = spans.entry(feature.id).or_insert([first, last]);
                *span = [span[0].min(first), span[1].max(last)];
            }
        }
        Results {
            map: outcome
                .map
                .iter()
                .map(|feature| registered(feature, spans.get(&feature.id).copied()))
                .collect(),
            extracted: outcome
                .extractions
                .iter()
                .map(|extraction| self.extracted(extraction))
                .collect(),
            labels: Some(self.labels),
            noise: RangeNoise::Unknown,
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
            None => Feature::new(extraction.kind, None),
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
