//! The three measurements association model as a pure state machine: frames in, decisions out.
//!
//! No input or output, no clock, no threads. Equation numbers are those of Wang et al., "Sonar
//! Feature Map Building for a Mobile Robot"; `docs/algorithm.md` reads code and paper side by side.

pub mod arc;
pub mod feature;
pub mod fit;
pub mod hypothesis;
pub mod map;
pub mod pair;
pub mod prediction;
pub mod run;
pub mod sequence;
pub mod spread;
pub mod step;
pub mod stream;
pub mod triple;
pub mod window;

use std::collections::BTreeMap;

use arc::Arc;
use feature::{Action, Extraction};
use fit::{Fit, FitOptions, fit_in_parts, fit_run};
use hypothesis::{Gate, HypothesisTest};
use map::Map;
use prediction::MapPrediction;
use run::Run;
use step::Step;
use stream::{Progress, Stream};

use crate::core::config::Config;
use crate::core::event::SonarId;
use crate::core::frames::Frame;

/// The machine: what it remembers of each sonar, and the map so far.
#[derive(Debug, Clone)]
pub struct Tmam {
    config: Config,
    gate: Gate,
    streams: BTreeMap<SonarId, Stream>,
    map: Map,
    extracted: u32,
    /// Every arc of the log, where the map is made anew of them at the end.
    arcs: Vec<Arc>,
    prediction: Option<MapPrediction>,
}

impl Tmam {
    /// A machine that has seen nothing yet.
    pub fn new(config: &Config) -> Self {
        Self {
            config: config.clone(),
            gate: Gate::new(config.opinion.gate),
            streams: BTreeMap::new(),
            map: Map::new(config),
            extracted: 0,
            arcs: Vec::new(),
            prediction: None,
        }
    }

    /// The same with a map that judges labels: of the same log, made beforehand.
    pub fn with_prediction(self, prediction: MapPrediction) -> Self {
        Self {
            prediction: Some(prediction),
            ..self
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
            if self.config.departures().gather {
                self.arcs.extend(arc);
            }
            let mut stream = self.streams.remove(&entry.sonar).unwrap_or_default();
            let progress = stream.push(arc, &self.config, &self.gate);
            self.take(progress, &mut stream, &mut step);
            self.streams.insert(entry.sonar, stream);
        }
        step
    }

    /// Decides what still waits for a next reading: the log has ended.
    pub fn finish(&mut self) -> Step {
        let mut step = Step::default();
        for (_, mut stream) in std::mem::take(&mut self.streams) {
            let progress = stream.finish(&self.config, &self.gate);
            self.take(progress, &mut stream, &mut step);
        }
        step.settled = self.map.settle(&self.arcs);
        step
    }

    fn take(&mut self, progress: Progress, stream: &mut Stream, step: &mut Step) {
        step.verdicts.extend(progress.verdicts);
        for run in progress.closed {
            for (part, fit) in self.fit(run) {
                let extraction = self.extract(part, fit);
                stream.note(&extraction);
                step.extractions.push(extraction);
            }
        }
        step.judgements
            .extend(stream.complete(self.prediction.as_ref()));
    }

    /// Fits features to a closed run: one, or one to each of its parts.
    fn fit(&self, run: Run) -> Vec<(Run, Fit)> {
        let demands = FitOptions::of(&self.config, &self.gate);
        if self.config.departures().break_runs {
            fit_in_parts(run, &demands)
        } else {
            let fit = fit_run(&run, &demands);
            vec![(run, fit)]
        }
    }

    /// Fuses what was fitted to a run into the map.
    fn extract(&mut self, run: Run, fit: Fit) -> Extraction {
        let used: Vec<Arc> = run
            .associated
            .iter()
            .filter(|arc| !fit.outliers.contains(&arc.id))
            .copied()
            .collect();
        let (action, map_feature, absorbed) = match (fit.rejection, fit.shape) {
            (None, Some(shape)) => {
                let fused = self.map.add(shape, &used);
                (fused.action, Some(fused.feature), fused.absorbed)
            }
            (rejection, _) => {
                let reason = rejection.unwrap_or(feature::Rejection::NoStart);
                (Action::Rejected(reason), None, Vec::new())
            }
        };
        let id = self.extracted;
        self.extracted += 1;
        Extraction {
            id,
            kind: run.kind,
            labelled: run.labelled,
            associated: run.associated.iter().map(|arc| arc.id).collect(),
            shape: fit.shape,
            residual_rms: fit.residual_rms,
            iterations: fit.iterations,
            converged: fit.converged,
            opinion: HypothesisTest::of(&used, &self.gate),
            outliers: fit.outliers,
            action,
            map_feature,
            absorbed,
        }
    }
}
