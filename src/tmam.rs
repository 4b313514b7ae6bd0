//! The three measurements association model as a pure state machine: frames in, decisions out.
//!
//! No input or output, no clock, no threads. Equation numbers are those of Wang et al., "Sonar
//! Feature Map Building for a Mobile Robot"; `docs/algorithm.md` reads code and paper side by side.

pub mod arc;
pub mod feature;
pub mod fit;
pub mod map;
pub mod opinion;
pub mod pair;
pub mod run;
pub mod sequence;
pub mod step;
pub mod triple;

use std::collections::BTreeMap;

use arc::{Arc, ArcId};
use feature::{Action, Extraction, Kind};
use fit::{fit_line, fit_point};
use map::Map;
use run::Run;
use sequence::{Decision, Sequence};
use step::Step;

use crate::config::Config;
use crate::event::SonarId;
use crate::frames::{Entry, Frame};

/// The machine: what it remembers of each sonar, and the map so far.
#[derive(Debug, Clone)]
pub struct Tmam {
    config: Config,
    sequences: BTreeMap<SonarId, Sequence>,
    map: Map,
    extracted: u32,
}

impl Tmam {
    /// A machine that has seen nothing yet.
    pub fn new(config: &Config) -> Self {
        Self {
            config: config.clone(),
            sequences: BTreeMap::new(),
            map: Map::new(config.map.match_distance),
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
            let arc = self.arc(frame.index, entry);
            step.arcs.extend(arc);
            let sequence = self.sequences.entry(entry.sonar).or_default();
            let decision = sequence.push(arc, &self.config);
            self.take(decision, &mut step);
        }
        step
    }

    /// Decides what still waits for a next reading: the log has ended.
    pub fn finish(&mut self) -> Step {
        let mut step = Step::default();
        for (_, mut sequence) in std::mem::take(&mut self.sequences) {
            let decision = sequence.finish(&self.config);
            self.take(decision, &mut step);
        }
        step
    }

    fn arc(&self, frame: u32, entry: &Entry) -> Option<Arc> {
        let echo = entry.echo?;
        Some(Arc {
            id: ArcId {
                frame,
                sonar: entry.sonar,
            },
            stamp_ns: entry.stamp_ns,
            world_from_sensor: entry.world_from_sensor,
            range: echo.range,
            beam_width: entry.beam_width,
            variance: self.config.noise.variance(echo.range, echo.variance),
        })
    }

    fn take(&mut self, decision: Option<Decision>, step: &mut Step) {
        let Some(Decision { verdict, closed }) = decision else {
            return;
        };
        step.verdicts.push(verdict);
        if let Some(run) = closed {
            let extraction = self.extract(run);
            step.extractions.push(extraction);
        }
    }

    /// Fits a feature to a closed run and fuses it into the map.
    fn extract(&mut self, run: Run) -> Extraction {
        let fit = match run.kind {
            Kind::Line => fit_line(&run.associated),
            Kind::Point => fit_point(&run.associated),
        };
        let readings = u32::try_from(run.associated.len()).unwrap_or(u32::MAX);
        let (action, map_feature) = match (fit.rejection, fit.shape) {
            (None, Some(shape)) => {
                let (action, feature) = self.map.add(shape, readings);
                (action, Some(feature))
            }
            (rejection, _) => {
                let reason = rejection.unwrap_or(feature::Rejection::NoStart);
                (Action::Rejected(reason), None)
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
            action,
            map_feature,
        }
    }
}
