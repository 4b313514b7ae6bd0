//! What each sonar gave last, without interruption.

use std::collections::BTreeMap;

use super::rival::Scan;
use crate::core::config::Sequence;
use crate::core::event::SonarId;
use crate::core::statistics::seconds;
use crate::core::tmam::arc::Arc;

/// The last arcs of each sonar.
#[derive(Debug)]
pub struct Sequences {
    bounds: Sequence,
    longest: usize,
    open: BTreeMap<SonarId, Vec<Arc>>,
}

impl Sequences {
    /// Of at most `longest` arcs each.
    pub fn new(longest: usize, bounds: &Sequence) -> Self {
        Self {
            bounds: bounds.clone(),
            longest,
            open: BTreeMap::new(),
        }
    }

    /// Takes a scan; gives the sequence of each sonar that has as many arcs as are wanted, the new one last.
    pub fn take(&mut self, scan: &Scan) -> Vec<Vec<Arc>> {
        for sonar in &scan.silent {
            self.open.remove(sonar);
        }
        let mut whole = Vec::new();
        for arc in &scan.arcs {
            let sequence = self.open.entry(arc.id.sonar).or_default();
            if sequence
                .last()
                .is_some_and(|last| !self.bounds.joins(last, arc))
            {
                sequence.clear();
            }
            if sequence.len() == self.longest {
                sequence.remove(0);
            }
            sequence.push(*arc);
            if sequence.len() == self.longest {
                whole.push(sequence.clone());
            }
        }
        whole
    }
}

impl Sequence {
    /// Whether two arcs of a sonar follow each other closely enough.
    fn joins(&self, before: &Arc, after: &Arc) -> bool {
        let way = (after.center() - before.center()).norm();
        seconds(before.stamp_ns, after.stamp_ns) <= self.max_gap && way <= self.max_baseline
    }
}
