//! The scores of a replay.

use std::collections::BTreeMap;

use serde::Serialize;

use super::extracted::{Extracted, ExtractedScore};
use super::labels::{LabelScore, ScoredArc};
use super::map::{MapScore, is_confirmed};
use super::path::PathScore;
use super::suspects::SuspectScore;
use super::truth::{Target, Truth};
use crate::core::event::SonarId;
use crate::core::geometry::Pose2;
use crate::core::replay::Outcome;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{Action, Kind};
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Extraction;

/// How a replay did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    pub labels: LabelScore,
    /// Its doubts about its labels, where a map predicts them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suspects: Option<SuspectScore>,
    /// What was extracted from single runs.
    pub extracted: Extractions,
    /// Its whole map.
    pub map: MapScore,
    /// The confirmed features of its map.
    pub confirmed: MapScore,
    /// The path that it used, where the true one is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathScore>,
    /// Every arc, by frame and sonar.
    #[serde(skip)]
    pub arcs: Vec<ScoredArc>,
}

/// How the features extracted from single runs did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extractions {
    pub lines: ExtractedScore,
    pub points: ExtractedScore,
    /// Where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circles: Option<ExtractedScore>,
}

impl Evaluation {
    /// The scores of a replay that used a path.
    pub fn new(truth: &Truth, path: &[(i64, Pose2)], outcome: &Outcome) -> Self {
        let mut targets = BTreeMap::new();
        let mut sequences: BTreeMap<SonarId, Vec<ArcId>> = BTreeMap::new();
        for ArcReport { arc, .. } in outcome.reports.iter() {
            targets.insert(arc.id, truth.target(arc));
            sequences.entry(arc.id.sonar).or_default().push(arc.id);
        }
        let echoes = Echoes { targets, sequences };
        let scored = |report: &ArcReport| {
            let arc = report.arc.id;
            let target = *echoes.targets.get(&arc)?;
            Some(ScoredArc {
                arc,
                label: report.label,
                target,
                one_target: echoes.neighbours_share(arc, target),
                doubt: report.doubt(),
                suspect: report.is_suspect(),
            })
        };
        let arcs: Vec<ScoredArc> = outcome.reports.iter().filter_map(scored).collect();
        let extracted = echoes.extracted(&outcome.extractions);
        Self {
            labels: LabelScore::new(&arcs),
            suspects: (outcome.suspects).map(|_| SuspectScore::new(&arcs)),
            extracted: Extractions {
                lines: ExtractedScore::new(Kind::Line, &extracted, truth),
                points: ExtractedScore::new(Kind::Point, &extracted, truth),
                circles: Some(ExtractedScore::new(Kind::Circle, &extracted, truth))
                    .filter(|score| score.features > 0),
            },
            map: MapScore::new(outcome.map.iter(), truth),
            confirmed: MapScore::new(outcome.map.iter().filter(|f| is_confirmed(f)), truth),
            path: PathScore::new(path, truth.poses()).map(|score| match outcome.joint() {
                Some(joint) => score.with_nees(&joint.path, truth.poses()),
                None => score,
            }),
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
