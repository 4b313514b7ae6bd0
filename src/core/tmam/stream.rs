//! One sonar's stream: from its entries to labels, runs and the whole story of each arc.

use std::collections::VecDeque;

use super::arc::{Arc, ArcId};
use super::feature::{Extraction, Kind};
use super::hypothesis::{Gate, HypothesisTest};
use super::prediction::{MapPrediction, Prediction};
use super::run::{Run, Runs};
use super::sequence::{Decision, Sequence, gap};
use super::triple::{Label, Reason, Verdict};
use super::window::{AdaptiveWindow, Wide};
use crate::core::config::Config;
use crate::core::geometry::angle_between;

/// What is known of one arc, once all is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArcReport {
    /// The arc.
    pub arc: Arc,
    /// Its label, and what three readings say of it.
    pub verdict: Verdict,
    /// What as many readings as it takes say: of the widest window around the arc that was looked
    /// at. `None` where the arc has no neighbour on one side.
    pub wide: Option<HypothesisTest>,
    /// The run that the arc is in, where it has a label.
    pub run: Option<RunTest>,
    /// What the map says that all readings together make; `None` where none was called to prediction.
    pub map: Option<Prediction>,
}

/// What all the readings of a run support.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunTest {
    /// The feature that was extracted from it.
    pub extraction: u32,
    /// The opinion.
    pub opinion: HypothesisTest,
}

impl ArcReport {
    /// Whether the label is contradicted: how a wrong one is found without the truth. The map
    /// decides where it explains the reading; else the readings of the triple, of the window and of
    /// the run do.
    pub fn is_suspect(&self) -> bool {
        let label = self.verdict.label;
        if let Some(kind) = self.map.and_then(|map| map.support.kind()) {
            return label.kind().is_some_and(|labelled| labelled != kind);
        }
        let triple = self.verdict.evidence.map(|evidence| evidence.opinion);
        let run = self.run.map(|run| run.opinion);
        [triple, self.wide, run]
            .iter()
            .flatten()
            .any(|opinion| opinion.contradicts(label))
    }
}

impl ArcReport {
    /// How strongly the label is contradicted: the gate on chi2 with one degree of freedom from
    /// which on it would not be suspect. Infinite where the map says otherwise; zero where there is
    /// no label, or where the map says the same.
    pub fn doubt(&self) -> f64 {
        let Some(labelled) = self.verdict.label.kind() else {
            return 0.0;
        };
        match self.map.and_then(|map| map.support.kind()) {
            Some(kind) if kind == labelled => return 0.0,
            Some(_) => return f64::INFINITY,
            None => {}
        }
        let triple = self.verdict.evidence.map(|evidence| evidence.opinion);
        let run = self.run.map(|run| run.opinion);
        let opinions = [triple, self.wide, run];
        let doubts = opinions.iter().flatten().map(|opinion| {
            let chi2 = match labelled {
                Kind::Line => opinion.chi2_line,
                Kind::Point => opinion.chi2_point,
            };
            Gate::let_through(chi2, opinion.readings.saturating_sub(2))
        });
        doubts.fold(0.0, f64::max)
    }
}

/// What one entry brought about.
#[derive(Debug, Default)]
pub struct Progress {
    /// Arcs that have their label now, in order.
    pub verdicts: Vec<Verdict>,
    /// Runs that closed.
    pub closed: Vec<Run>,
}

/// An arc on its way.
#[derive(Debug, Clone)]
struct Case {
    arc: Arc,
    decision: Option<Decision>,
    wide: Option<Wide>,
    verdict: Option<Verdict>,
    run: Option<RunTest>,
}

/// One sonar's stream of entries.
#[derive(Debug, Clone, Default)]
pub struct Stream {
    sequence: Sequence,
    widening: AdaptiveWindow,
    runs: Runs,
    /// Arcs whose story is not complete, in order.
    cases: VecDeque<Case>,
}

impl Stream {
    /// Takes the sonar's next entry, `None` for no echo.
    pub fn push(&mut self, next: Option<Arc>, config: &Config, gate: &Gate) -> Progress {
        let continues = match (self.sequence.newest(), &next) {
            (Some(last), Some(arc)) => {
                let turn = angle_between(last.world_from_sensor.yaw, arc.world_from_sensor.yaw);
                !gap(last, arc, &config.sequence) && turn <= config.triple.turn_tolerance
            }
            _ => false,
        };
        if !continues {
            let wide = self.widening.end();
            self.settle(wide);
        }
        let decision = self.sequence.push(next, config, gate);
        self.decide(decision);
        if let Some(arc) = next {
            self.cases.push_back(Case {
                arc,
                decision: None,
                wide: None,
                verdict: None,
                run: None,
            });
            let wide = self.widening.push(arc, &config.opinion, gate);
            self.settle(wide);
        }
        self.label(config)
    }

    /// The log has ended.
    pub fn finish(&mut self, config: &Config, gate: &Gate) -> Progress {
        let decision = self.sequence.finish(config, gate);
        self.decide(decision);
        let wide = self.widening.end();
        self.settle(wide);
        let mut progress = self.label(config);
        progress.closed.extend(self.runs.close());
        progress
    }

    /// Notes which feature a closed run gave.
    pub fn note(&mut self, extraction: &Extraction) {
        for arc in &extraction.labelled {
            if let Some(case) = self.case(*arc) {
                case.run = Some(RunTest {
                    extraction: extraction.id,
                    opinion: extraction.opinion,
                });
            }
        }
    }

    /// The arcs whose story is complete, in order.
    pub fn complete<'a>(
        &'a mut self,
        prediction: Option<&'a MapPrediction>,
    ) -> impl Iterator<Item = ArcReport> + 'a {
        let complete = self
            .cases
            .iter()
            .take_while(|case| case.is_complete())
            .count();
        self.cases.drain(..complete).filter_map(move |case| {
            Some(ArcReport {
                arc: case.arc,
                verdict: case.verdict?,
                wide: case.wide.and_then(|wide| wide.opinion),
                run: case.run,
                map: prediction.map(|prediction| prediction.predict(&case.arc)),
            })
        })
    }

    fn case(&mut self, arc: ArcId) -> Option<&mut Case> {
        let at = self.cases.partition_point(|case| case.arc.id < arc);
        self.cases.get_mut(at).filter(|case| case.arc.id == arc)
    }

    fn decide(&mut self, decision: Option<Decision>) {
        let Some(decision) = decision else { return };
        if let Some(case) = self.case(decision.arc.id) {
            case.decision = Some(decision);
        }
    }

    fn settle(&mut self, settled: Vec<Wide>) {
        for wide in settled {
            if let Some(case) = self.case(wide.arc) {
                case.wide = Some(wide);
            }
        }
    }

    /// Labels the arcs that can be labelled now, in order, and closes their runs.
    fn label(&mut self, config: &Config) -> Progress {
        let mut progress = Progress::default();
        let by_opinion = config.departures().label_by_opinion;
        let unlabelled = self.cases.partition_point(|case| case.verdict.is_some());
        for case in self.cases.range_mut(unlabelled..) {
            let Some(decision) = case.decision else { break };
            let closed = if by_opinion {
                let Some(wide) = &case.wide else { break };
                let label = label_by(wide, decision.verdict.label, config.opinion.decisive);
                case.verdict = Some(Verdict {
                    label,
                    margin: None,
                    chi2_margin: wide.margin.filter(|_| decision.triple.is_some()),
                    ..decision.verdict
                });
                match (label.kind(), decision.triple) {
                    (Some(kind), _) => self.runs.label_across(kind, case.arc.id, &wide.window),
                    (None, Some(_)) => self.runs.pass(2 * config.opinion.max_half_width),
                    (None, None) => self.runs.close(),
                }
            } else {
                case.verdict = Some(decision.verdict);
                match (decision.verdict.label.kind(), decision.triple) {
                    (Some(kind), Some(triple)) => self.runs.label(kind, case.arc.id, &triple),
                    _ => self.runs.close(),
                }
            };
            progress.verdicts.extend(case.verdict);
            progress.closed.extend(closed);
        }
        progress
    }
}

impl Case {
    fn is_complete(&self) -> bool {
        let run_is_known = |verdict: Verdict| verdict.label.kind().is_none() || self.run.is_some();
        self.wide.is_some() && self.verdict.is_some_and(run_is_known)
    }
}

/// The label that the readings of a window support; `by_angles` says why an arc is no triple.
fn label_by(wide: &Wide, by_angles: Label, decisive: f64) -> Label {
    if let Label::Unidentified(Reason::Missing | Reason::Gap | Reason::Turning) = by_angles {
        return by_angles;
    }
    match wide.opinion {
        Some(opinion) => match opinion.decided(decisive) {
            Some(Kind::Line) => Label::Contact,
            Some(Kind::Point) => Label::Intersection,
            None if opinion.support == super::hypothesis::Support::Neither => {
                Label::Unidentified(Reason::Neither)
            }
            None => Label::Unidentified(Reason::Ambiguous),
        },
        None => Label::Unidentified(Reason::Ambiguous),
    }
}

#[cfg(test)]
mod tests;
