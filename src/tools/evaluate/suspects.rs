//! How well the replay's own doubts find its wrong labels.

use serde::Serialize;

use super::labels::ScoredArc;
use crate::core::rounding::{number, optional};
use crate::core::statistics::share;

/// Gates at which doubts are held against the truth: 1 in 10, 20, 100 and 1000 of one target's
/// triples lie beyond (chi2 with one degree of freedom).
pub const GATES: [f64; 4] = [2.71, 3.84, 6.63, 10.83];

/// How suspects did under one gate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Gate {
    /// Labels called suspect.
    pub suspects: u64,
    /// Wrong labels among them.
    pub wrong_found: u64,
    /// Right labels among them.
    pub right_accused: u64,
    /// Wrong ones among the suspects.
    #[serde(serialize_with = "optional")]
    pub precision: Option<f64>,
    /// Suspects among the wrong labels.
    #[serde(serialize_with = "optional")]
    pub recall: Option<f64>,
    /// Suspects among the right labels.
    #[serde(serialize_with = "optional")]
    pub right_accused_share: Option<f64>,
}

/// How suspects did under a gate that is not the configured one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct OtherGate {
    /// The gate: chi2 with one degree of freedom.
    #[serde(serialize_with = "number")]
    pub gate: f64,
    /// What it gives.
    #[serde(flatten)]
    pub score: Gate,
}

/// How suspects did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct SuspectScore {
    /// Wrong labels there are to find.
    pub wrong: u64,
    /// Right labels there are to leave alone.
    pub right: u64,
    /// As the replay was configured.
    pub configured: Gate,
    /// Under other gates.
    pub gates: Vec<OtherGate>,
}

impl SuspectScore {
    /// Scores the doubts about every label.
    pub fn new(scored: &[ScoredArc]) -> Self {
        let labels: Vec<(&ScoredArc, bool)> = scored
            .iter()
            .filter_map(|arc| Some((arc, arc.is_right()?)))
            .collect();
        let right = labels.iter().filter(|(_, right)| *right).count() as u64;
        let wrong = labels.len() as u64 - right;
        let score = |is_suspect: &dyn Fn(&ScoredArc) -> bool| {
            let suspects = labels.iter().filter(|(arc, _)| is_suspect(arc));
            let (right_ones, wrong_ones): (Vec<_>, Vec<_>) =
                suspects.map(|(_, right)| *right).partition(|right| *right);
            let (right_accused, wrong_found) = (right_ones.len() as u64, wrong_ones.len() as u64);
            Gate {
                suspects: wrong_found + right_accused,
                wrong_found,
                right_accused,
                precision: share(wrong_found, wrong_found + right_accused),
                recall: share(wrong_found, wrong),
                right_accused_share: share(right_accused, right),
            }
        };
        Self {
            wrong,
            right,
            configured: score(&|arc| arc.suspect),
            gates: GATES
                .map(|gate| OtherGate {
                    gate,
                    score: score(&|arc| arc.doubt >= gate),
                })
                .to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::labels::testing::{LINE, POINT, scored};
    use super::*;
    use crate::core::tmam::label::Label;
    use crate::core::tmam::label::Reason;

    #[test]
    fn each_gate_calls_suspect_what_is_doubted_at_least_so_much() {
        let arcs = [
            scored(Label::Contact, LINE, 0.1),
            scored(Label::Contact, LINE, 3.0),
            scored(Label::Intersection, POINT, 7.0),
            scored(Label::Contact, POINT, 2.71),
            scored(Label::Intersection, LINE, f64::INFINITY),
            scored(Label::Unidentified(Reason::Wide), LINE, f64::INFINITY),
        ];
        let score = SuspectScore::new(&arcs);
        assert_eq!((score.wrong, score.right), (2, 3));
        let found: Vec<_> = score
            .gates
            .iter()
            .map(|g| (g.gate, g.score.wrong_found, g.score.right_accused))
            .collect();
        assert_eq!(
            found,
            [(2.71, 2, 2), (3.84, 1, 1), (6.63, 1, 1), (10.83, 1, 0)]
        );
        assert_eq!(score.configured.wrong_found, 1);
        assert_eq!(score.configured.precision, Some(0.5));
        assert_eq!(score.configured.recall, Some(0.5));
        assert_eq!(score.configured.right_accused_share, Some(1.0 / 3.0));
    }
}
