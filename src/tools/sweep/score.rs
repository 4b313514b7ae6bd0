//! What a replay is worth, with and without the truth.
//!
//! Without it a replay is judged by how well its own map explains its readings: a wrong mount or a
//! late clock puts readings beside the walls that other readings made. [`Bits`] says by how much.

use crate::core::bits::Bits;
use crate::core::replay::Outcome;
use crate::core::tmam::feature::{Action, Kind, Status};
use crate::tools::evaluate::Evaluation;

/// What a replay is worth.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Score {
    /// Frames opened.
    pub frames: u64,
    /// Arcs decided.
    pub arcs: u64,
    /// Arcs labelled contact.
    pub contact: u64,
    /// Arcs labelled intersection.
    pub intersection: u64,
    /// Labels that the map prediction or a hypothesis test contradicts; `None` where no map predicts.
    pub suspects: Option<u64>,
    /// Confirmed lines of the map.
    pub lines: u64,
    /// Confirmed points of the map.
    pub points: u64,
    /// Arcs labelled circle, and confirmed circles of the map.
    pub circle: u64,
    pub circles: u64,
    /// Root mean square of what the fits of single runs leave, metres; `None` without a run.
    pub rms: Option<f64>,
    /// Arcs that the noise-aware map explains; `None` where no map predicts.
    pub explained: Option<u64>,
    /// Mean square of their misfits in standard deviations.
    pub chi2: Option<f64>,
    /// Bits that an arc takes, given the noise-aware map, and that the map takes per arc.
    pub bits: Option<f64>,
    /// Against the truth.
    pub truth: Option<TruthScore>,
}

/// What a replay is worth where the truth is known.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TruthScore {
    /// Wrong labels.
    pub wrong: u64,
    /// Walls and points that the confirmed map lacks.
    pub missed: u64,
    /// Confirmed features that are no wall and no point.
    pub spurious: u64,
    /// Confirmed features of a wall or point that has a better one.
    pub twice: u64,
}

impl TruthScore {
    /// From an evaluation.
    pub fn new(evaluation: &Evaluation) -> Self {
        let map = &evaluation.confirmed;
        let kinds = || [&map.lines, &map.points].into_iter().chain(&map.circles);
        let sum = |of: fn(&crate::tools::evaluate::map::KindScore) -> usize| {
            kinds().map(|kind| of(kind) as u64).sum()
        };
        Self {
            wrong: evaluation.labels.wrong_labels(),
            missed: sum(|kind| kind.missed.len()),
            spurious: sum(|kind| kind.spurious.len()),
            twice: sum(|kind| kind.duplicates.len()),
        }
    }

    /// What is wrong with the confirmed map; 0 for an exact one.
    pub fn map_errors(&self) -> u64 {
        self.missed + self.spurious + self.twice
    }
}

impl Score {
    /// Labels given.
    pub fn labelled(&self) -> u64 {
        self.contact + self.intersection + self.circle
    }
}

impl Score {
    /// The score of a replay.
    pub fn new(outcome: &Outcome, truth: Option<TruthScore>) -> Self {
        let known = Bits::of(outcome);
        let mean = |sum: f64, count: u64| (count > 0).then(|| sum / count as f64);
        let confirmed = |kind| {
            let features = outcome.map.iter();
            let of_kind =
                features.filter(|f| f.status == Status::Confirmed && f.shape.kind() == kind);
            of_kind.count() as u64
        };
        let (mut squares, mut readings) = (0.0, 0);
        for run in &outcome.extractions {
            if !matches!(run.action, Action::Rejected(_)) {
                let count = run.associated.len();
                squares += run.residual_rms * run.residual_rms * count as f64;
                readings += count as u64;
            }
        }
        Self {
            frames: outcome.frames.into(),
            arcs: outcome.reports.len() as u64,
            contact: outcome.labelled("contact"),
            intersection: outcome.labelled("intersection"),
            suspects: outcome.suspects,
            lines: confirmed(Kind::Line),
            points: confirmed(Kind::Point),
            circle: outcome.labelled("circle"),
            circles: confirmed(Kind::Circle),
            rms: mean(squares, readings).map(f64::sqrt),
            explained: known.map(|known| known.explained),
            chi2: known.and_then(|known| mean(known.chi2, known.explained)),
            bits: known.as_ref().and_then(Bits::per_arc),
            truth,
        }
    }
}
