//! Watches a replay and scores it at the end.

use std::collections::BTreeMap;

use serde::Serialize;

use super::extracted::{Extracted, ExtractedScore};
use super::labels::{LabelScore, ScoredArc};
use super::map::{MapScore, is_confirmed};
use super::suspects::SuspectScore;
use super::truth::{Target, Truth};
use crate::core::event::SonarId;
use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError};
use crate::core::replay::Outcome;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{Action, Extraction, Kind};
use crate::core::tmam::step::Step;
use crate::core::tmam::stream::ArcReport;

/// How a replay did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    pub labels: LabelScore,
    /// Its doubts about its labels.
    pub suspects: SuspectScore,
    /// What was extracted from single runs.
    pub extracted: Extractions,
    /// Its whole map.
    pub map: MapScore,
    /// The confirmed features of its map.
    pub confirmed: MapScore,
    /// Every arc, in the order they were decided.
    #[serde(skip)]
    pub arcs: Vec<ScoredArc>,
}

/// How the features extracted from single runs did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extractions {
    pub lines: ExtractedScore,
    pub points: ExtractedScore,
}

/// Watches a replay.
#[derive(Debug)]
pub struct Scorer<'t> {
    truth: &'t Truth,
    targets: BTreeMap<ArcId, Target>,
    sequences: BTreeMap<SonarId, Vec<ArcId>>,
    judgements: Vec<ArcReport>,
}

impl<'t> Scorer<'t> {
    /// One that has seen nothing yet.
    pub fn new(truth: &'t Truth) -> Self {
        Self {
            truth,
            targets: BTreeMap::new(),
            sequences: BTreeMap::new(),
            judgements: Vec::new(),
        }
    }

    fn take(&mut self, step: &Step) {
        for arc in &step.arcs {
            self.targets.insert(arc.id, self.truth.target(arc));
            self.sequences.entry(arc.id.sonar).or_default().push(arc.id);
        }
        self.judgements.extend(step.judgements.iter().copied());
    }

    /// The scores of the replay that was watched to its end.
    pub fn evaluate(&self, outcome: &Outcome) -> Evaluation {
        let arcs: Vec<ScoredArc> = self
            .judgements
            .iter()
            .filter_map(|judgement| {
                let arc = judgement.arc.id;
                let target = *self.targets.get(&arc)?;
                Some(ScoredArc {
                    arc,
                    label: judgement.verdict.label,
                    target,
                    one_target: self.neighbours_share(arc, target),
                    doubt: judgement.doubt(),
                    suspect: judgement.is_suspect(),
                })
            })
            .collect();
        let extracted = self.extracted(&outcome.extractions);
        let truth = self.truth;
        Evaluation {
            labels: LabelScore::new(&arcs),
            suspects: SuspectScore::new(&arcs),
            extracted: Extractions {
                lines: ExtractedScore::new(Kind::Line, &extracted, truth),
                points: ExtractedScore::new(Kind::Point, &extracted, truth),
            },
            map: MapScore::new(outcome.map.iter(), truth),
            confirmed: MapScore::new(outcome.map.iter().filter(|f| is_confirmed(f)), truth),
            arcs,
        }
    }

    /// Whether the arcs before and after one in its sonar's sequence came from the same wall or
    /// point.
    fn neighbours_share(&self, arc: ArcId, target: Target) -> bool {
        let (Some(sequence), Target::Reflector(_)) = (self.sequences.get(&arc.sonar), target)
        else {
            return false;
        };
        let Ok(place) = sequence.binary_search(&arc) else {
            return false;
        };
        let same = |place: Option<usize>| {
            let neighbour = place.and_then(|place| sequence.get(place));
            neighbour.is_some_and(|arc| self.targets.get(arc) == Some(&target))
        };
        same(place.checked_sub(1)) && same(place.checked_add(1))
    }

    fn extracted<'e>(&self, extractions: &'e [Extraction]) -> Vec<Extracted<'e>> {
        extractions
            .iter()
            .filter(|extraction| !matches!(extraction.action, Action::Rejected(_)))
            .filter_map(|extraction| {
                let targets = extraction.associated.iter();
                Some(Extracted {
                    shape: extraction.shape.as_ref()?,
                    targets: targets
                        .filter_map(|arc| self.targets.get(arc).copied())
                        .collect(),
                })
            })
            .collect()
    }
}

impl Observer for Scorer<'_> {
    fn frame(&mut self, _: &Frame, step: &Step) -> Result<(), ObserverError> {
        self.take(step);
        Ok(())
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        self.take(step);
        Ok(())
    }
}
