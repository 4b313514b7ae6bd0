//! One sonar's sequence of readings: which three make a triple.

use super::arc::Arc;
use super::opinion::Opinion;
use super::pair::Points;
use super::run::{Run, Runs};
use super::triple::{Evidence, Label, Reason, Verdict, judge, turns};
use crate::config::{Config, Sequence as Bounds};

/// What the sonar gave a frame.
#[derive(Debug, Clone, Copy)]
enum Slot {
    Arc(Arc),
    NoEcho,
}

/// The last two entries of one sonar's sequence and its open run.
#[derive(Debug, Clone, Default)]
pub struct Sequence {
    before: Option<Slot>,
    middle: Option<Slot>,
    runs: Runs,
}

/// The decision on an arc, and the run that ended with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The decision.
    pub verdict: Verdict,
    /// The run that it closed.
    pub closed: Option<Run>,
}

impl Sequence {
    /// Takes the sonar's next entry, `None` for no echo; decides the entry before it.
    pub fn push(&mut self, next: Option<Arc>, config: &Config) -> Option<Decision> {
        let next = next.map_or(Slot::NoEcho, Slot::Arc);
        let decision = self.decide(Some(next), config);
        self.before = self.middle.replace(next);
        decision
    }

    /// The log has ended: decides the last entry.
    pub fn finish(&mut self, config: &Config) -> Option<Decision> {
        let decision = self.decide(None, config);
        (self.before, self.middle) = (None, None);
        decision
    }

    /// Decides the middle entry, if it is an arc, now that the one after it is known.
    fn decide(&mut self, after: Option<Slot>, config: &Config) -> Option<Decision> {
        let Some(Slot::Arc(middle)) = self.middle else {
            return None;
        };
        let (Some(Slot::Arc(before)), Some(Slot::Arc(after))) = (self.before, after) else {
            return Some(self.no_triple(&middle, Reason::Missing));
        };
        let bounds = &config.sequence;
        if gap(&before, &middle, bounds) || gap(&middle, &after, bounds) {
            return Some(self.no_triple(&middle, Reason::Gap));
        }
        if turns(&before, &middle, &after, &config.triple) {
            return Some(self.no_triple(&middle, Reason::Turning));
        }
        let pairs = (Points::of(&before, &middle), Points::of(&middle, &after));
        let (label, angles) = judge(pairs.0, pairs.1, middle.beam_width, &config.triple);
        let evidence = Evidence {
            angles,
            opinion: Opinion::of([&before, &middle, &after], config.opinion.gate),
        };
        let closed = self.runs.label(label, [&before, &middle, &after]);
        Some(decision(&middle, label, Some(evidence), closed))
    }

    fn no_triple(&mut self, middle: &Arc, reason: Reason) -> Decision {
        let closed = self.runs.close();
        decision(middle, Label::Unidentified(reason), None, closed)
    }
}

fn decision(arc: &Arc, label: Label, evidence: Option<Evidence>, closed: Option<Run>) -> Decision {
    Decision {
        verdict: Verdict {
            arc: arc.id,
            label,
            evidence,
        },
        closed,
    }
}

/// Whether two neighbours lie too far apart in time or distance.
fn gap(a: &Arc, b: &Arc, bounds: &Bounds) -> bool {
    let seconds = b.stamp_ns.saturating_sub(a.stamp_ns) as f64 * 1e-9;
    seconds.abs() > bounds.max_gap || (b.center() - a.center()).norm() > bounds.max_baseline
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::SonarId;
    use crate::geometry::Pose2;
    use crate::tmam::arc::ArcId;
    use crate::tmam::feature::Kind;

    /// Along x at 10 cm a step and a step a second, looking left at a wall 2 m away.
    fn wall(frame: u32) -> Arc {
        Arc {
            id: ArcId {
                frame,
                sonar: SonarId(0),
            },
            stamp_ns: i64::from(frame) * 1_000_000_000,
            world_from_sensor: Pose2::new(0.1 * f64::from(frame), 0.0, 1.57),
            range: 2.0,
            beam_width: 0.4,
            variance: 1e-4,
        }
    }

    fn decide(entries: impl IntoIterator<Item = Option<Arc>>) -> (Vec<(u32, Label)>, Vec<Run>) {
        let config = Config::default();
        let mut sequence = Sequence::default();
        let mut decisions: Vec<Decision> = entries
            .into_iter()
            .filter_map(|entry| sequence.push(entry, &config))
            .collect();
        decisions.extend(sequence.finish(&config));
        let labels = decisions
            .iter()
            .map(|d| (d.verdict.arc.frame, d.verdict.label))
            .collect();
        (
            labels,
            decisions.into_iter().filter_map(|d| d.closed).collect(),
        )
    }

    const MISSING: Label = Label::Unidentified(Reason::Missing);
    const GAP: Label = Label::Unidentified(Reason::Gap);

    #[test]
    fn a_run_of_n_plus_1_labels_associates_n_plus_3_readings() {
        let (labels, runs) = decide((0..6).map(|k| Some(wall(k))));
        let contact = Label::Contact;
        let expected = [MISSING, contact, contact, contact, contact, MISSING];
        assert!(labels.iter().map(|l| l.1).eq(expected), "{labels:?}");
        let [run] = runs.as_slice() else {
            panic!("{runs:?}")
        };
        assert_eq!(run.kind, Kind::Line);
        let frames = |ids: Vec<ArcId>| ids.into_iter().map(|id| id.frame).collect::<Vec<_>>();
        assert_eq!(frames(run.labelled.clone()), [1, 2, 3, 4]);
        let associated = run.associated.iter().map(|arc| arc.id).collect();
        assert_eq!(frames(associated), [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn a_no_echo_breaks_the_sequence_and_a_silent_frame_does_not() {
        let silent = [0, 1, 3, 4].map(|k| Some(wall(k)));
        let (labels, runs) = decide(silent);
        assert_eq!(labels[1], (1, Label::Contact));
        assert_eq!(runs.len(), 1);
        let (labels, runs) = decide([Some(wall(0)), Some(wall(1)), None, Some(wall(3))]);
        assert_eq!(labels, [(0, MISSING), (1, MISSING), (3, MISSING)]);
        assert!(runs.is_empty());
    }

    #[test]
    fn time_and_distance_break_it_too() {
        let late = |k: u32| {
            let mut arc = wall(k);
            arc.stamp_ns += 5_000_000_000;
            Some(arc)
        };
        let (labels, _) = decide([Some(wall(0)), Some(wall(1)), late(2), late(3)]);
        assert_eq!(labels[1].1, GAP);
        assert_eq!(labels[2].1, GAP);
        let (labels, _) = decide([0, 1, 7, 8].map(|k| Some(wall(k))));
        assert_eq!(labels[1].1, GAP, "0.6 m apart");
    }

    #[test]
    fn what_is_missing_is_said_before_what_is_too_far() {
        let (labels, _) = decide([None, Some(wall(1)), Some(wall(9))]);
        assert_eq!(labels[0].1, MISSING);
    }
}
