//! Runs: maximal stretches of equally labelled arcs of one sonar.

use super::arc::{Arc, ArcId};
use super::feature::Kind;
use super::triple::Label;

/// Consecutive arcs `k..=k+n` of one sonar with the same label, and the readings
/// `k-1..=k+n+1` that they associate with one feature: n + 3 of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What the label says.
    pub kind: Kind,
    /// The labelled arcs.
    pub labelled: Vec<ArcId>,
    /// The associated arcs.
    pub associated: Vec<Arc>,
}

/// The runs of one sonar, one open at a time.
#[derive(Debug, Clone, Default)]
pub struct Runs {
    open: Option<Run>,
}

impl Runs {
    /// Takes the label of the middle of a triple; returns the run that it closed.
    pub fn label(&mut self, label: Label, [before, middle, after]: [&Arc; 3]) -> Option<Run> {
        let kind = match label {
            Label::Contact => Kind::Line,
            Label::Intersection => Kind::Point,
            Label::Unidentified(_) => return self.close(),
        };
        if let Some(run) = self.open.as_mut().filter(|run| run.kind == kind) {
            run.labelled.push(middle.id);
            run.associated.push(*after);
            return None;
        }
        self.open.replace(Run {
            kind,
            labelled: vec![middle.id],
            associated: vec![*before, *middle, *after],
        })
    }

    /// The sequence is interrupted: the open run ends.
    pub fn close(&mut self) -> Option<Run> {
        self.open.take()
    }
}
