//! The scores of a replay.

use std::collections::BTreeMap;

use super::extracted::{Extracted, ExtractedScore};
use super::labels::{Judged, LabelScore};
use super::map::{MapScore, is_confirmed};
use super::suspects::SuspectScore;
use super::truth::{Target, Truth};
use crate::core::event::SonarId;
use crate::core::replay::Outcome;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{Action, Kind};
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Extraction;

/// How a replay did.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Its labels.
    pub labels: LabelScore,
    /// Its doubts about them.
    pub suspects: SuspectScore,
    /// Lines extracted from single runs.
    pub extracted_lines: ExtractedScore,
    /// Points extracted from single runs.
    pub extracted_points: ExtractedScore,
    /// Its whole map.
    pub map: MapScore,
    /// The confirmed features of its map.
    pub confirmed: MapScore,
    /// Every arc, by frame and sonar.
    pub arcs: Vec<Judged>,
}

impl Evaluation {
    /// The scores of a replay.
    pub fn new(truth: &Truth, outcome: &Outcome) -> Self {
        let mut targets = BTreeMap::new();
        let mut sequences: BTreeMap<SonarId, Vec<ArcId>> = BTreeMap::new();
        for ArcReport { arc, .. } in &outcome.reports {
            targets.insert(arc.id, truth.target(arc));
            sequences.entry(arc.id.sonar).or_default().push(arc.id);
        }
        let echoes = Echoes { targets, sequences };
        let judged = |report: &ArcReport| {
            let arc = report.arc.id;
            let target = *echoes.targets.get(&arc)?;
            Some(Judged {
                arc,
                label: report.label,
                target,
                one_target: echoes.neighbours_share(arc, target),
                doubt: report.doubt(),
                suspect: report.is_suspect(),
            })
        };
        let arcs: Vec<Judged> = outcome.reports.iter().filter_map(judged).collect();
        let extracted = echoes.extracted(&outcome.extractions);
        Self {
            labels: LabelScore::new(&arcs),
            suspects: SuspectScore::new(&arcs),
            extracted_lines: ExtractedScore::new(Kind::Line, &extracted, truth),
            extracted_points: ExtractedScore::new(Kind::Point, &extracted, truth),
            map: MapScore::new(outcome.map.iter(), truth),
            confirmed: MapScore::new(outcome.map.iter().filter(|f| is_confirmed(f)), truth),
            arcs,
        }
    }
}

/// What echoed.
struct Echoes {
    targets: BTreeMap<ArcId, Target>,
    sequences: BTreeMap<SonarId, Vec<ArcId>>,
}

impl Echoes {
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
