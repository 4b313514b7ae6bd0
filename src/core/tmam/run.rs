//! Runs: maximal stretches of equally labelled arcs of one sonar.

use super::arc::{Arc, ArcId};
use super::label::Kind;

/// Consecutive arcs `k..=k+n` of one sonar with the same label, and the readings that they
/// associate with one feature: those of their windows. The paper's windows are triples, so its runs
/// associate `k-1..=k+n+1`, n + 3 of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What the label says.
    pub kind: Kind,
    /// The labelled arcs.
    pub labelled: Vec<ArcId>,
    /// The associated arcs, in order.
    pub associated: Vec<Arc>,
}

/// The runs of one sonar, one open at a time.
#[derive(Debug, Clone, Default)]
pub struct Runs {
    open: Option<Run>,
    /// Arcs without a label since the last one of the open run.
    idle: usize,
}

impl Runs {
    /// Takes an arc with its label and the window that decided it; returns the run that it closed.
    pub fn label(&mut self, kind: Kind, arc: ArcId, window: &[Arc]) -> Option<Run> {
        if let Some(run) = self.open.as_mut().filter(|run| run.kind == kind) {
            run.labelled.push(arc);
            run.associate(window);
            return None;
        }
        self.open.replace(Run {
            kind,
            labelled: vec![arc],
            associated: window.to_vec(),
        })
    }

    /// Takes an arc with its label where a run may have gaps: an arc that follows others without a
    /// label still belongs to their run when its window reaches into it, or else the readings that
    /// they share would count twice.
    pub fn label_across(&mut self, kind: Kind, arc: ArcId, window: &[Arc]) -> Option<Run> {
        let reached = self.open.as_ref().is_some_and(|run| run.reached_by(window));
        let closed = (!reached).then(|| self.close()).flatten();
        self.idle = 0;
        let replaced = self.label(kind, arc, window);
        closed.or(replaced)
    }

    /// Passes an arc without a label where a run may have gaps of up to `longest` of them.
    pub fn pass(&mut self, longest: usize) -> Option<Run> {
        self.idle += 1;
        (self.idle > longest).then(|| self.close()).flatten()
    }

    /// The sequence is interrupted: the open run ends.
    pub fn close(&mut self) -> Option<Run> {
        self.idle = 0;
        self.open.take()
    }
}

impl Run {
    /// The run before its associated arc `at`, and from it on: each with its share of the labels.
    pub fn broken_at(&self, at: usize) -> (Self, Self) {
        let (before, after) = self.associated.split_at(at.min(self.associated.len()));
        let part = |arcs: &[Arc]| Self {
            kind: self.kind,
            labelled: (self.labelled.iter().copied())
                .filter(|id| arcs.iter().any(|arc| arc.id == *id))
                .collect(),
            associated: arcs.to_vec(),
        };
        (part(before), part(after))
    }

    /// Whether a later window shares readings with the run.
    fn reached_by(&self, window: &[Arc]) -> bool {
        match (window.first(), self.associated.last()) {
            (Some(first), Some(last)) => first.id.frame <= last.id.frame,
            _ => false,
        }
    }

    /// Adds the readings of a window that are not associated yet. A sonar has one arc per frame.
    fn associate(&mut self, window: &[Arc]) {
        let frames = match (self.associated.first(), self.associated.last()) {
            (Some(first), Some(last)) => first.id.frame..=last.id.frame,
            _ => return,
        };
        let earlier = window.iter().filter(|arc| arc.id.frame < *frames.start());
        let later = window.iter().filter(|arc| arc.id.frame > *frames.end());
        self.associated.splice(0..0, earlier.copied());
        self.associated.extend(later.copied());
    }
}
