//! Why one arc was labelled so, what would have changed that, and whether it was right.
//!
//! A [`Watch`](watch::Watch) sees a replay, a [`Question`] names an arc of it, and an [`Explanation`]
//! says all that is known of that arc. None of it reads or writes anything.

pub mod doubts;
pub mod explanation;
pub mod json;
pub mod need;
pub mod outcome;
pub mod pairs;
pub mod question;
pub mod rule;
pub mod situation;
pub mod suspects;
pub mod text;
pub mod truth;
pub mod watch;
pub mod windows;

pub use self::explanation::{AnglesStory, Explanation, MapStory, Near};
use self::pairs::Pair;
use self::question::Found;
pub use self::question::{Question, QuestionError, Which};
use self::situation::{Reading, Situation};
use self::truth::TruthStory;
use self::watch::Watch;
use self::windows::Windows;
use crate::core::observer::Setting;
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::pair::Points;
use crate::core::tmam::spread::Spread;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::{Angles, Evidence, Label, Reason, judge};
use crate::tools::evaluate::Truth;

/// How many other arcs that pass near a place are named.
const NEAR: usize = 5;

/// Why there is nothing to explain.
#[derive(Debug, thiserror::Error)]
pub enum ExplainError {
    /// The log cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// No arc answers the question.
    #[error(transparent)]
    Question(#[from] QuestionError),
}

/// Replays a log and explains one of its arcs.
///
/// # Errors
/// When there is nothing to replay, or no arc that answers the question.
pub fn explain(
    replay: &Replay<'_>,
    question: &Question,
    truth: Option<&Truth>,
) -> Result<(Outcome, Explanation), ExplainError> {
    let mut watch = Watch::default();
    let outcome = replay.run(&mut [&mut watch])?;
    let origin_ns = replay.origin_ns();
    let setting = replay.setting();
    let found = question.answers(&watch, &setting, origin_ns)?;
    let beams = replay.readings().map(|reading| reading.beam_width);
    let teller = Teller {
        watch: &watch,
        outcome: &outcome,
        setting,
        origin_ns,
        truth,
        narrowest: beams.fold(f64::INFINITY, f64::min),
    };
    let explanation = teller.tell(&found).ok_or(QuestionError::NoEcho {
        sonars: question.sonars.clone(),
    })?;
    Ok((outcome, explanation))
}

struct Teller<'a> {
    watch: &'a Watch,
    outcome: &'a Outcome,
    setting: Setting<'a>,
    origin_ns: i64,
    truth: Option<&'a Truth>,
    narrowest: f64,
}

impl Teller<'_> {
    fn tell(&self, found: &[Found]) -> Option<Explanation> {
        let best = found.first()?;
        let arc = best.arc;
        let config = self.setting.config;
        let judgement = self.watch.judgements.get(&arc.id)?;
        let sequence = self.watch.sequence(arc.id.sonar);
        let place = self.watch.place(arc.id)?;
        let situation = Situation::new(sequence, place, config, self.origin_ns);
        let windows = Windows::new(sequence, place, config);
        let by_opinion = config.departures().label_by_opinion;
        let label = judgement.verdict.label;
        let (angles, by_angles) = self.angles(judgement, &situation).unzip();
        let is_triple = judgement.verdict.evidence.is_some();
        let changes = if is_triple && by_opinion {
            windows.changes()
        } else if let (true, Some(angles)) = (is_triple, &angles) {
            let (theta_c, theta_i) = (angles.theta_c, angles.theta_i);
            rule::changes(label, theta_c, theta_i, &config.triple, self.narrowest)
        } else {
            // Without the bounds that it breaks it would be the middle of a triple.
            let then = if by_opinion { None } else { by_angles };
            let then = then.filter(|label| label.kind().is_some()).map(Label::name);
            situation.changes(then)
        };
        let looked_at = windows.looked_at();
        Some(Explanation {
            sensor: self.name(&arc),
            arc: Reading::new(&arc, self.origin_ns),
            distance: best.distance,
            late: best.late,
            also_near: self.near(found),
            label: label.name(),
            reason: label.reason().map(Reason::name),
            decided_by: if by_opinion { "opinion" } else { "angles" },
            suspect: judgement.is_suspect(),
            doubts: doubts::doubts(judgement),
            pairs: self.pairs(&situation),
            angles,
            changes,
            windows_end: looked_at.last().map(|last| windows.end(last)),
            windows: looked_at,
            decisive: config.opinion.decisive,
            runs: outcome::runs(arc.id, self.outcome),
            map: judgement.map.map(|map| MapStory {
                says: map.support.name(),
                feature: map.feature,
            }),
            truth: self
                .truth
                .map(|truth| TruthStory::new(&arc, label, &situation, truth)),
            situation,
        })
    }

    fn name(&self, arc: &Arc) -> String {
        let sonar = self.setting.sonars.get(arc.id.sonar.index());
        sonar.map_or_else(String::new, |sonar| sonar.name.clone())
    }

    fn near(&self, found: &[Found]) -> Vec<Near> {
        let others = found.iter().skip(1).take(NEAR);
        let near = others.filter(|found| found.distance.is_some());
        near.map(|found| Near {
            sensor: self.name(&found.arc),
            frame: found.arc.id.frame,
            distance: found.distance,
        })
        .collect()
    }

    fn pairs(&self, situation: &Situation) -> Vec<Pair> {
        let three = situation.three.as_ref();
        three.map_or_else(Vec::new, |[first, middle, last]| {
            vec![Pair::new(first, middle), Pair::new(middle, last)]
        })
    }

    /// The angles of the triple, or those that the three arcs would have if they were one; with the
    /// paper's label.
    fn angles(&self, judgement: &ArcReport, situation: &Situation) -> Option<(AnglesStory, Label)> {
        let bounds = &self.setting.config.triple;
        let [first, middle, last] = situation.three.as_ref()?;
        let pairs = (Points::of(first, middle), Points::of(middle, last));
        let (label, hypothetical) = judge(pairs.0, pairs.1, middle.beam_width, bounds);
        let spread = Spread::of([first, middle, last]);
        let evidence = judgement.verdict.evidence;
        let angles: Angles = evidence.map_or(hypothetical, |Evidence { angles, .. }| angles);
        let common = |before: &[Option<_>; 2], after: &[Option<_>; 2]| {
            before
                .iter()
                .zip(after)
                .any(|(b, a)| b.is_some() && a.is_some())
        };
        let story = AnglesStory {
            theta_c: angles.theta_c,
            theta_i: angles.theta_i,
            theta_c_sigma: spread.theta_c,
            theta_i_sigma: spread.theta_i,
            has_contact: common(&angles.before.contact, &angles.after.contact),
            has_intersection: common(&angles.before.intersection, &angles.after.intersection),
            margin: angles.margin,
            label: label.name(),
            reason: label.reason().map(Reason::name),
            conditions: rule::conditions(angles.theta_c, angles.theta_i, bounds),
        };
        Some((story, label))
    }
}
