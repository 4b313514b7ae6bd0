//! Labels against what echoed.
//!
//! An arc's own reflector is its truth, whatever its neighbours came from: `contact` is right on an
//! arc of a wall, `intersection` on one of a point.

use std::collections::BTreeMap;

use serde::Serialize;

use super::truth::{Other, Target};
use crate::core::rounding::optional;
use crate::core::statistics::share;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::label::{Label, Reason};
use crate::core::world::Reflector;

/// A decided arc and what it came from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoredArc {
    /// The arc.
    pub arc: ArcId,
    /// What it was labelled.
    pub label: Label,
    /// What it came from.
    pub target: Target,
    /// Whether its neighbours in the sonar's sequence came from the same wall or point.
    pub one_target: bool,
    /// How strongly the replay itself doubts the label: see [`suspects`](super::suspects).
    pub doubt: f64,
    /// Whether the replay itself calls the label suspect.
    pub suspect: bool,
}

impl ScoredArc {
    /// Whether the label is right; `None` for an arc without one.
    pub fn is_right(&self) -> Option<bool> {
        match self.label {
            Label::Contact => Some(matches!(self.target, Target::Reflector(Reflector::Line(_)))),
            Label::Intersection => Some(matches!(
                self.target,
                Target::Reflector(Reflector::Point(_))
            )),
            Label::Circle => Some(matches!(
                self.target,
                Target::Reflector(Reflector::Circle(_))
            )),
            Label::Unidentified(_) => None,
        }
    }
}

/// Arcs by what they came from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct ByTarget {
    /// From a wall.
    pub line: u64,
    /// From a point.
    pub point: u64,
    /// From a pillar; in files where there are any.
    #[serde(skip_serializing_if = "is_none")]
    pub circle: u64,
    /// From neither.
    pub other: u64,
}

fn is_none(count: &u64) -> bool {
    *count == 0
}

impl ByTarget {
    fn count(&mut self, target: Target) {
        *match target {
            Target::Reflector(Reflector::Line(_)) => &mut self.line,
            Target::Reflector(Reflector::Point(_)) => &mut self.point,
            Target::Reflector(Reflector::Circle(_)) => &mut self.circle,
            Target::Other(_) => &mut self.other,
        } += 1;
    }

    /// All of them.
    pub fn total(&self) -> u64 {
        self.line + self.point + self.circle + self.other
    }
}

/// How one label did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Class {
    /// The arcs that have it.
    #[serde(flatten)]
    pub arcs: ByTarget,
    /// Right ones among the arcs that have the label.
    #[serde(serialize_with = "optional")]
    pub precision: Option<f64>,
    /// Arcs that have the label among those that should.
    #[serde(serialize_with = "optional")]
    pub recall: Option<f64>,
}

/// Wrong labels by what their triples saw.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Wrong {
    /// The arc and its neighbours came from one wall or point.
    pub one_target: u64,
    /// They came from different ones, or not from the world: a triple across a change of target,
    /// or an arc of something unknown.
    pub mixed: u64,
    /// The arc came from a pillar, which a wall or a point was seen in; in files where there are any.
    #[serde(skip_serializing_if = "is_none")]
    pub pillar: u64,
}

/// How the reason `oblique` did: right on an arc of a rough wall, beside the foot of the perpendicular.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ObliqueScore {
    /// Arcs that have it.
    pub arcs: u64,
    /// Right ones among them.
    pub right: u64,
    #[serde(serialize_with = "optional")]
    pub precision: Option<f64>,
    /// Share of the arcs of rough walls that have it.
    #[serde(serialize_with = "optional")]
    pub recall: Option<f64>,
}

/// How the labels of a replay did.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct LabelScore {
    /// Arcs that were decided.
    pub arcs: u64,
    /// Share of them that have a label.
    #[serde(serialize_with = "optional")]
    pub coverage: Option<f64>,
    /// Share of wrong ones among the labels given.
    #[serde(serialize_with = "optional")]
    pub wrong_share: Option<f64>,
    /// The same among those on arcs of a wall or point: what counts where the world is not the
    /// whole truth.
    #[serde(serialize_with = "optional")]
    pub wrong_share_known: Option<f64>,
    /// The wrong labels.
    pub wrong: Wrong,
    pub contact: Class,
    pub intersection: Class,
    /// Where the replay gave it, or the world has pillars that echoed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circle: Option<Class>,
    /// Arcs without a label.
    pub unidentified: ByTarget,
    /// Arcs without a label, by the reason.
    pub reasons: BTreeMap<&'static str, ByTarget>,
    /// How the reason `oblique` did.
    pub oblique: ObliqueScore,
    /// Arcs from neither a wall nor a point, by why.
    pub other: BTreeMap<&'static str, u64>,
}

impl LabelScore {
    /// Scores every decided arc.
    pub fn new(scored: &[ScoredArc]) -> Self {
        let mut score = Self {
            other: Other::ALL.map(|other| (other.name(), 0)).into(),
            ..Self::default()
        };
        for arc in scored {
            score.take(arc);
        }
        let (contact, intersection) = (score.contact.arcs, score.intersection.arcs);
        let circle = score.circle.unwrap_or_default().arcs;
        let missing = score.unidentified;
        let all = [contact, intersection, circle, missing];
        let sum = |of: fn(&ByTarget) -> u64| all.iter().map(of).sum::<u64>();
        let (lines, points) = (sum(|by| by.line), sum(|by| by.point));
        let pillars = sum(|by| by.circle);
        let class = |arcs: ByTarget, right, all| Class {
            arcs,
            precision: share(right, arcs.total()),
            recall: share(right, all),
        };
        score.contact = class(contact, contact.line, lines);
        score.intersection = class(intersection, intersection.point, points);
        let are_told = circle.total() + pillars > 0;
        score.circle = are_told.then(|| class(circle, circle.circle, pillars));
        score.coverage = share(score.given(), score.arcs);
        score.wrong_share = share(score.wrong_labels(), score.given());
        let rough = score.other.get(Other::Oblique.name()).copied();
        let oblique = &mut score.oblique;
        oblique.precision = share(oblique.right, oblique.arcs);
        oblique.recall = share(oblique.right, rough.unwrap_or_default());
        let of_things = |by: ByTarget| by.line + by.point;
        let known = [contact, intersection, circle].map(of_things).iter().sum();
        let confused = known - contact.line - intersection.point;
        score.wrong_share_known = share(confused, known);
        score
    }

    fn take(&mut self, arc: &ScoredArc) {
        self.arcs += 1;
        if let Target::Other(other) = arc.target {
            *self.other.entry(other.name()).or_default() += 1;
        }
        match arc.label {
            Label::Contact => self.contact.arcs.count(arc.target),
            Label::Intersection => self.intersection.arcs.count(arc.target),
            Label::Circle => {
                let circle = self.circle.get_or_insert_default();
                circle.arcs.count(arc.target);
            }
            Label::Unidentified(reason) => {
                self.unidentified.count(arc.target);
                let of_reason = self.reasons.entry(reason.name()).or_default();
                of_reason.count(arc.target);
                if reason == Reason::Oblique {
                    let is_right = arc.target == Target::Other(Other::Oblique);
                    self.oblique.arcs += 1;
                    self.oblique.right += u64::from(is_right);
                }
            }
        }
        if arc.is_right() == Some(false) {
            *match (arc.target, arc.one_target) {
                (Target::Reflector(Reflector::Circle(_)), _) => &mut self.wrong.pillar,
                (_, true) => &mut self.wrong.one_target,
                (_, false) => &mut self.wrong.mixed,
            } += 1;
        }
    }

    /// Whether the world is the one that the robot drove in: more than one arc in twenty comes from
    /// what is in it.
    pub fn fits_the_world(&self) -> bool {
        let circle = self.circle.unwrap_or_default().arcs;
        let labels = [
            self.contact.arcs,
            self.intersection.arcs,
            circle,
            self.unidentified,
        ];
        let known: u64 = labels.iter().map(|by| by.total() - by.other).sum();
        self.arcs == 0 || known * 20 > self.arcs
    }

    /// Labels given.
    pub fn given(&self) -> u64 {
        let circle = self.circle.unwrap_or_default().arcs;
        self.contact.arcs.total() + self.intersection.arcs.total() + circle.total()
    }

    /// Wrong ones among them.
    pub fn wrong_labels(&self) -> u64 {
        self.wrong.one_target + self.wrong.mixed + self.wrong.pillar
    }
}

#[cfg(test)]
pub(super) mod testing {
    use super::*;
    use crate::core::event::SonarId;

    pub const LINE: Target = Target::Reflector(Reflector::Line(0));
    pub const POINT: Target = Target::Reflector(Reflector::Point(0));
    pub const PILLAR: Target = Target::Reflector(Reflector::Circle(0));

    /// An arc with a label, which came from something and is doubted so much.
    pub fn scored(label: Label, target: Target, doubt: f64) -> ScoredArc {
        ScoredArc {
            arc: ArcId {
                frame: 0,
                sonar: SonarId(0),
            },
            label,
            target,
            one_target: true,
            doubt,
            suspect: doubt >= 6.63,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{LINE, PILLAR, POINT, scored};
    use super::*;

    #[test]
    fn the_scores_follow_from_the_counts() {
        let wide = Label::Unidentified(Reason::Wide);
        let outlier = Target::Other(Other::Outlier);
        let mut arcs = Vec::new();
        for (label, target, count) in [
            (Label::Contact, LINE, 6),
            (Label::Contact, POINT, 1),
            (Label::Contact, outlier, 1),
            (Label::Intersection, LINE, 2),
            (Label::Intersection, POINT, 3),
            (wide, LINE, 4),
            (wide, POINT, 2),
            (wide, outlier, 1),
        ] {
            arcs.extend(std::iter::repeat_n(scored(label, target, 0.0), count));
        }
        if let Some(arc) = arcs.get_mut(6) {
            arc.one_target = false; // the contact on a point
        }
        let score = LabelScore::new(&arcs);
        assert_eq!(score.arcs, 20);
        assert_eq!(score.coverage, Some(13.0 / 20.0));
        assert_eq!(score.wrong_share, Some(4.0 / 13.0));
        assert_eq!(score.wrong_share_known, Some(3.0 / 12.0));
        assert_eq!(score.contact.precision, Some(6.0 / 8.0));
        assert_eq!(score.contact.recall, Some(6.0 / 12.0));
        assert_eq!(score.intersection.precision, Some(3.0 / 5.0));
        assert_eq!(score.intersection.recall, Some(3.0 / 6.0));
        assert_eq!((score.wrong.one_target, score.wrong.mixed), (3, 1));
        assert_eq!(score.reasons.get("wide").map(ByTarget::total), Some(7));
        assert_eq!(score.other.get("outlier"), Some(&2));
        assert_eq!(score.other.get("nothing"), Some(&0));
    }

    #[test]
    fn a_label_on_a_pillar_is_none_of_a_wall_or_point() {
        let arcs = [
            scored(Label::Contact, LINE, 0.0),
            scored(Label::Contact, PILLAR, 0.0),
            scored(Label::Intersection, PILLAR, 0.0),
        ];
        let score = LabelScore::new(&arcs);
        assert_eq!(score.wrong_share, Some(2.0 / 3.0));
        assert_eq!(score.wrong_share_known, Some(0.0));
        assert_eq!((score.wrong.one_target, score.wrong.pillar), (0, 2));
    }

    #[test]
    fn of_nothing_there_is_no_share() {
        let score = LabelScore::new(&[]);
        assert_eq!((score.coverage, score.wrong_share), (None, None));
        assert_eq!(score.contact, Class::default());
    }
}
