//! The three measurements association model as a pure state machine: frames in, decisions out.
//!
//! No input or output, no clock, no threads. Equation numbers are those of Wang et al., "Sonar
//! Feature Map Building for a Mobile Robot"; `docs/algorithm.md` reads code and paper side by side.

pub mod arc;
pub mod circle;
pub mod condition;
pub mod feature;
pub mod fit;
pub mod gauss_newton;
pub mod hearing;
pub mod hypothesis;
pub mod label;
pub mod map;
pub mod oblique;
pub mod pair;
pub mod prediction;
pub mod report;
pub mod residual;
pub mod rule;
pub mod run;
pub mod spread;
pub mod step;
pub mod stream;
pub mod triple;
pub mod window;

use std::collections::BTreeMap;
use std::sync::Arc as Shared;

use arc::Arc;
use feature::{Action, Rejection};
use fit::Fit;
use hearing::Hearing;
use hypothesis::{Gate, HypothesisTest};
use map::Map;
use map::rough::RoughWall;
use report::ArcReport;
use rule::Policies;
use run::Run;
use step::{Extraction, Step};
use stream::Stream;

use crate::core::config::Config;
use crate::core::event::SonarId;
use crate::core::frames::Frame;

/// The machine: what it remembers of each sonar, and the map so far.
#[derive(Debug)]
pub struct Tmam {
    config: Config,
    gate: Gate,
    rule: Policies,
    streams: BTreeMap<SonarId, Stream>,
    /// On every labelled arc, in the order in which they got their labels.
    reports: Vec<ArcReport>,
    map: Map,
    extracted: u32,
}

impl Tmam {
    /// A machine that has seen nothing yet.
    pub fn new(config: &Config) -> Self {
        let gate = Gate::new(config.opinion.gate);
        Self {
            config: config.clone(),
            gate,
            rule: Policies::of(config, &gate),
            streams: BTreeMap::new(),
            reports: Vec::new(),
            map: Map::new(config),
            extracted: 0,
        }
    }

    /// The registered features so far.
    pub fn map(&self) -> &Map {
        &self.map
    }

    /// Takes the next frame.
    pub fn step(&mut self, frame: &Frame) -> Step {
        let mut step = Step::default();
        for entry in &frame.entries {
            let arc = Arc::of_entry(frame.index, entry, &self.config.noise);
            step.arcs.extend(arc);
            self.take(entry.sonar, arc, &mut step);
        }
        step
    }

    /// Decides what still waits for a next reading: the log has ended.
    pub fn finish(&mut self) -> Step {
        let mut step = Step::default();
        let sonars: Vec<SonarId> = self.streams.keys().copied().collect();
        for sonar in sonars {
            self.take(sonar, None, &mut step);
        }
        self.streams.clear();
        let mut reports = std::mem::take(&mut self.reports);
        // No two have one id.
        reports.sort_unstable_by_key(|report: &ArcReport| report.arc.id);
        step.reports = Shared::new(reports);
        let arcs: Vec<Arc> = step.reports.iter().map(|report| report.arc).collect();
        let hardly = Hearing::hardly_explained(&step.reports);
        let rough = if self.config.departures().oblique_walls {
            RoughWall::all(&step.reports, self.map.features(), &self.config)
        } else {
            Vec::new()
        };
        step.settled = self.map.settle(&arcs, &hardly, &rough);
        let (settled, absorbed) = self.map.round(&arcs);
        step.settled.extend(settled);
        step.absorbed.extend(absorbed);
        step
    }

    /// The method: what the next entry of a sonar brings about, `None` for no echo.
    fn take(&mut self, sonar: SonarId, next: Option<Arc>, step: &mut Step) {
        let circles = self.config.departures().circles;
        let (rule, stream) = (&self.rule, self.streams.entry(sonar).or_default());
        let reports = &mut self.reports;
        stream.triple(next, &self.config, &self.gate);
        stream.window(next, &self.config, &self.gate, reports);
        while let Some((report, decision)) = stream.label(rule, reports) {
            if let Some(run) = stream.run(rule, &report, &decision) {
                for (part, fit) in rule.fit(run) {
                    let test =
                        |arcs: &[Arc]| HypothesisTest::with_circles(circles, arcs, &self.gate);
                    let extraction = extract(self.extracted, part, fit, &mut self.map, test);
                    self.extracted += 1;
                    stream.note(&extraction, reports);
                    step.extractions.push(extraction);
                }
            }
            step.labelled.push(report);
            step.triples.push(decision.three);
        }
    }
}

/// Fuses what was fitted to a run into the map.
fn extract(
    id: u32,
    run: Run,
    fit: Fit,
    map: &mut Map,
    test: impl Fn(&[Arc]) -> HypothesisTest,
) -> Extraction {
    let used: Vec<Arc> = run
        .associated
        .iter()
        .filter(|arc| !fit.outliers.contains(&arc.id))
        .copied()
        .collect();
    let (action, map_feature, absorbed) = match (fit.rejection, fit.shape) {
        (None, Some(shape)) => {
            let fused = map.add(shape, &used);
            (fused.action, Some(fused.feature), fused.absorbed)
        }
        (rejection, _) => {
            let reason = rejection.unwrap_or(Rejection::NoStart);
            (Action::Rejected(reason), None, Vec::new())
        }
    };
    Extraction {
        id,
        kind: run.kind,
        labelled: run.labelled,
        associated: run.associated.iter().map(|arc| arc.id).collect(),
        shape: fit.shape,
        residual_rms: fit.residual_rms,
        iterations: fit.iterations,
        converged: fit.converged,
        opinion: Some(test(&used)),
        outliers: fit.outliers,
        action,
        map_feature,
        absorbed,
    }
}
