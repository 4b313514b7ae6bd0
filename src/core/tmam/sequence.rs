//! One sonar's sequence of readings: which three make a triple, and what the paper's rule says of it.

use super::arc::Arc;
use super::hypothesis::{Gate, HypothesisTest};
use super::pair::Points;
use super::spread::Spread;
use super::triple::{Evidence, Label, Reason, Verdict, judge, turns};
use crate::core::config::{Config, Sequence as Bounds};

/// What the sonar gave a frame.
#[derive(Debug, Clone, Copy)]
enum Slot {
    Arc(Arc),
    NoEcho,
}

/// The last two entries of one sonar's sequence.
#[derive(Debug, Clone, Default)]
pub struct Sequence {
    before: Option<Slot>,
    middle: Option<Slot>,
}

/// The decision of the paper's rule on an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The arc.
    pub arc: Arc,
    /// The decision.
    pub verdict: Verdict,
    /// The arc between its neighbours, where the three make a triple.
    pub triple: Option<[Arc; 3]>,
}

impl Sequence {
    /// Takes the sonar's next entry, `None` for no echo; decides the entry before it.
    pub fn push(&mut self, next: Option<Arc>, config: &Config, gate: &Gate) -> Option<Decision> {
        let next = next.map_or(Slot::NoEcho, Slot::Arc);
        let decision = self.decide(Some(next), config, gate);
        self.before = self.middle.replace(next);
        decision
    }

    /// The log has ended: decides the last entry.
    pub fn finish(&mut self, config: &Config, gate: &Gate) -> Option<Decision> {
        let decision = self.decide(None, config, gate);
        (self.before, self.middle) = (None, None);
        decision
    }

    /// The newest entry, where it is an arc.
    pub fn newest(&self) -> Option<&Arc> {
        match &self.middle {
            Some(Slot::Arc(arc)) => Some(arc),
            Some(Slot::NoEcho) | None => None,
        }
    }

    /// Decides the middle entry, if it is an arc, now that the one after it is known.
    fn decide(&self, after: Option<Slot>, config: &Config, gate: &Gate) -> Option<Decision> {
        let middle = *self.newest()?;
        let (Some(Slot::Arc(before)), Some(Slot::Arc(after))) = (self.before, after) else {
            return Some(no_triple(middle, Reason::Missing));
        };
        let bounds = &config.sequence;
        if gap(&before, &middle, bounds) || gap(&middle, &after, bounds) {
            return Some(no_triple(middle, Reason::Gap));
        }
        if turns(&before, &middle, &after, &config.triple) {
            return Some(no_triple(middle, Reason::Turning));
        }
        let pairs = (Points::of(&before, &middle), Points::of(&middle, &after));
        let (label, angles) = judge(pairs.0, pairs.1, middle.beam_width, &config.triple);
        let triple = [before, middle, after];
        let verdict = Verdict {
            arc: middle.id,
            label,
            margin: Some(angles.margin),
            chi2_margin: None,
            evidence: Some(Evidence {
                angles,
                spread: Spread::of([&before, &middle, &after]),
                opinion: HypothesisTest::of(&triple, gate),
            }),
        };
        Some(Decision {
            arc: middle,
            verdict,
            triple: Some(triple),
        })
    }
}

fn no_triple(arc: Arc, reason: Reason) -> Decision {
    Decision {
        arc,
        verdict: Verdict {
            arc: arc.id,
            label: Label::Unidentified(reason),
            margin: None,
            chi2_margin: None,
            evidence: None,
        },
        triple: None,
    }
}

/// Whether two neighbours lie too far apart in time or distance.
pub fn gap(a: &Arc, b: &Arc, bounds: &Bounds) -> bool {
    let seconds = b.stamp_ns.saturating_sub(a.stamp_ns) as f64 * 1e-9;
    seconds.abs() > bounds.max_gap || (b.center() - a.center()).norm() > bounds.max_baseline
}
