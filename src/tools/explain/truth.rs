//! What really echoed, where that is known.

use serde::Serialize;

use super::situation::Situation;
use crate::core::rounding::rounded;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::label::Label;
use crate::core::world::Reflector;
use crate::tools::evaluate::truth::{Origin, Other, Target, Truth};

/// What echoed, and whether the label says so.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthStory {
    /// `log` where the log says what echoed; `echo-model` where it follows from the walls and points
    /// that were there.
    pub from: &'static str,
    /// What echoed.
    pub echoed: Echoed,
    /// What echoed at the arc before.
    pub before: Option<Echoed>,
    /// What echoed at the arc after.
    pub after: Option<Echoed>,
    /// Whether the label is right; `None` for an arc without one.
    pub right: Option<bool>,
}

/// What echoed at an arc.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Echoed {
    /// `line` or `point`; `outlier`, `nothing` or `disagrees` where it was neither.
    pub what: &'static str,
    /// Which wall or point of the world, from 0.
    pub index: Option<usize>,
    /// Where it is: the two ends of a wall, or a point; metres.
    pub at: [Option<[f64; 2]>; 2],
}

impl Echoed {
    fn new(arc: &Arc, truth: &Truth) -> (Self, Target) {
        let target = truth.target(arc);
        let xy = |v: &crate::core::geometry::Vec2| [rounded(v.x), rounded(v.y)];
        let world = truth.world();
        let (index, at) = match target {
            Target::Reflector(Reflector::Line(index)) => {
                let wall = world.walls().get(index);
                let ends = wall.map(|wall| [Some(xy(&wall.start)), Some(xy(&wall.end))]);
                (Some(index), ends.unwrap_or_default())
            }
            Target::Reflector(Reflector::Point(index)) => {
                (Some(index), [world.points().get(index).map(xy), None])
            }
            Target::Other(Other::Outlier | Other::Nothing | Other::Disagrees) => (None, [None; 2]),
        };
        let what = target.name();
        (Self { what, index, at }, target)
    }
}

impl TruthStory {
    /// The truth about an arc with a label.
    pub fn new(arc: &Arc, label: Label, situation: &Situation, truth: &Truth) -> Self {
        let (echoed, target) = Echoed::new(arc, truth);
        let [before, after] = match &situation.three {
            Some([first, _, last]) => [first, last].map(|arc| Some(Echoed::new(arc, truth).0)),
            None => [None, None],
        };
        Self {
            from: match truth.origin() {
                Origin::Log => "log",
                Origin::EchoModel => "echo-model",
            },
            echoed,
            before,
            after,
            right: match (label, target) {
                (Label::Unidentified(_), _) => None,
                (Label::Contact, target) => {
                    Some(matches!(target, Target::Reflector(Reflector::Line(_))))
                }
                (Label::Intersection, target) => {
                    Some(matches!(target, Target::Reflector(Reflector::Point(_))))
                }
            },
        }
    }

    /// Whether the three readings came from one wall or point.
    pub fn one_target(&self) -> Option<bool> {
        let same =
            |other: &Echoed| (other.what, other.index) == (self.echoed.what, self.echoed.index);
        Some(same(self.before.as_ref()?) && same(self.after.as_ref()?))
    }
}
