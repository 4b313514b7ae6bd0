//! Three neighbouring arcs of one sonar: whether they make a triple, and the paper's rule on it.

use serde::Serialize;

use super::arc::Arc;
use super::condition::{Condition, Relation};
use super::hypothesis::{Gate, HypothesisTest};
use super::label::{Label, Reason};
use super::pair::{MIN_BASELINE, PairPoint, Points};
use super::spread::Spread;
use crate::core::config::{Config, Triple};
use crate::core::geometry::{angle_between, direction};

/// The way of a sensor from one of its arcs to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// How long it took.
    pub seconds: f64,
    /// Between the sensor centres, metres.
    pub length: f64,
    /// Change of heading, radians.
    pub turn: f64,
}

impl Way {
    /// From arc `a` to arc `b`.
    pub fn between(a: &Arc, b: &Arc) -> Self {
        let seconds = b.stamp_ns.saturating_sub(a.stamp_ns) as f64 * 1e-9;
        Self {
            seconds: seconds.abs(),
            length: (b.center() - a.center()).norm(),
            turn: angle_between(a.world_from_sensor.yaw, b.world_from_sensor.yaw),
        }
    }

    /// What a window may reach over: neighbours near in time and distance, and a sensor that still looks
    /// the same way.
    fn conditions(&self, config: &Config) -> [Condition; 3] {
        let (bounds, turn) = (&config.sequence, config.triple.turn_tolerance);
        [
            at_most("sequence.max_gap", self.seconds, bounds.max_gap),
            at_most("sequence.max_baseline", self.length, bounds.max_baseline),
            at_most("triple.turn_tolerance", self.turn, turn),
        ]
    }

    /// Whether a window may reach over it.
    pub fn continues(&self, config: &Config) -> bool {
        self.conditions(config).iter().all(Condition::holds)
    }
}

/// The bend between the base lines of three arcs, radians. A sensor that stands still has no
/// direction of travel to bend.
pub fn bend([before, middle, after]: &[Arc; 3]) -> f64 {
    let (first, second) = (
        middle.center() - before.center(),
        after.center() - middle.center(),
    );
    if first.norm() >= MIN_BASELINE && second.norm() >= MIN_BASELINE {
        angle_between(direction(first), direction(second))
    } else {
        0.0
    }
}

/// Which neighbours of an arc a condition is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Between {
    /// The arc and the one before it.
    Before,
    /// The arc and the one after it.
    After,
    /// The way to the arc and the way on from it.
    Both,
}

/// The comparisons that make an arc between two ways the middle of a triple, in the order in which they
/// are made, each with the reason why it is none where it does not hold.
pub fn conditions(
    [before, after]: [&Way; 2],
    bend: f64,
    config: &Config,
) -> [(Between, Condition, Reason); 7] {
    let [gap_before, way_before, turn_before] = before.conditions(config);
    let [gap_after, way_after, turn_after] = after.conditions(config);
    let bend = at_most("triple.bend_tolerance", bend, config.triple.bend_tolerance);
    [
        (Between::Before, gap_before, Reason::Gap),
        (Between::Before, way_before, Reason::Gap),
        (Between::After, gap_after, Reason::Gap),
        (Between::After, way_after, Reason::Gap),
        (Between::Before, turn_before, Reason::Turning),
        (Between::After, turn_after, Reason::Turning),
        (Between::Both, bend, Reason::Turning),
    ]
}

/// Why three neighbours are no triple; `None` where they are one.
pub fn obstacle(ways: [&Way; 2], bend: f64, config: &Config) -> Option<Reason> {
    let all = conditions(ways, bend, config);
    let broken = all.iter().find(|(_, condition, _)| !condition.holds());
    broken.map(|(.., reason)| *reason)
}

fn at_most(key: &'static str, found: f64, bound: f64) -> Condition {
    Condition {
        key,
        found,
        relation: Relation::AtMost,
        bound,
    }
}

/// What three arcs say of the middle one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TripleTest {
    /// The angles, which decide under the paper's rule.
    pub angles: Angles,
    /// The paper's label.
    pub label: Label,
    /// Radians that the angles lack, or have to spare, to the nearest bound that would change that
    /// label.
    pub margin: f64,
    /// How far noise spreads the angles.
    pub spread: Spread,
    /// What the three readings support, within their noise.
    pub test: HypothesisTest,
}

/// Of the two pairs of a triple, the arc before and the middle one first, whether they have a point left of
/// travel, and right of it.
pub type Sides = [[bool; 2]; 2];

/// The angles of a triple, from which its label follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Smallest angle on arc k between contact points on a common side, radians; the full beam
    /// width where there is none.
    pub theta_c: f64,
    /// The same of intersection points.
    pub theta_i: f64,
    /// On which sides the common tangents touch arc k.
    pub contact: Sides,
    /// On which sides its neighbours cross arc k.
    pub intersection: Sides,
}

impl TripleTest {
    /// Of three neighbouring arcs.
    pub fn of(arcs: &[Arc; 3], bounds: &Triple, gate: &Gate) -> Self {
        let [before, middle, after] = arcs;
        let pairs = [Points::of(before, middle), Points::of(middle, after)];
        let angles = Angles::between(&pairs, middle.beam_width);
        let (label, margin) = angles.label(bounds);
        Self {
            angles,
            label,
            margin,
            spread: Spread::of([before, middle, after]),
            test: HypothesisTest::of(arcs, gate),
        }
    }
}

impl Angles {
    /// On the middle arc of a triple, between the points of its two pairs.
    pub fn between([before, after]: &[Points; 2], beam_width: f64) -> Self {
        let smallest = |before: &[Option<PairPoint>; 2], after: &[Option<PairPoint>; 2]| {
            let sides = before.iter().zip(after);
            sides
                .filter_map(|(b, a)| Some(angle_between((*b)?.bearing_b, (*a)?.bearing_a)))
                .min_by(f64::total_cmp)
                .unwrap_or(beam_width)
        };
        Self {
            theta_c: smallest(&before.contact, &after.contact),
            theta_i: smallest(&before.intersection, &after.intersection),
            contact: [before.contact, after.contact].map(|pair| pair.map(|p| p.is_some())),
            intersection: [before.intersection, after.intersection]
                .map(|pair| pair.map(|p| p.is_some())),
        }
    }

    /// The comparisons of the paper's rule: two that make an arc contact, two that make it
    /// intersection.
    pub fn conditions(&self, bounds: &Triple) -> [Condition; 4] {
        let condition = |key, found, relation, bound| Condition {
            key,
            found,
            relation,
            bound,
        };
        let (theta_c, theta_i) = (self.theta_c, self.theta_i);
        let (below, above) = (Relation::Below, Relation::Above);
        [
            condition("triple.alpha", theta_c, below, bounds.alpha * theta_i),
            condition("triple.gamma", theta_c, below, bounds.gamma),
            condition("triple.beta", theta_c, above, bounds.beta * theta_i),
            condition("triple.gamma", theta_i, below, bounds.gamma),
        ]
    }

    /// The label of the paper's rule, and its margin.
    pub fn label(&self, bounds: &Triple) -> (Label, f64) {
        let [alpha, contact_gate, beta, intersection_gate] =
            self.conditions(bounds).map(|condition| condition.room());
        let by_contact = alpha.min(contact_gate);
        let by_intersection = beta.min(intersection_gate);
        if by_contact > 0.0 {
            return (Label::Contact, by_contact);
        }
        if by_intersection > 0.0 {
            return (Label::Intersection, by_intersection);
        }
        let reason = if !has_common_side(&self.contact) && !has_common_side(&self.intersection) {
            Reason::NoPoints
        } else if self.theta_c.min(self.theta_i) >= bounds.gamma {
            Reason::Wide
        } else {
            Reason::Ambiguous
        };
        let margin = -by_contact.max(by_intersection);
        (Label::Unidentified(reason), margin)
    }
}

/// Whether both pairs have a point on one side of travel.
pub fn has_common_side([before, after]: &Sides) -> bool {
    before
        .iter()
        .zip(after)
        .any(|(before, after)| *before && *after)
}

#[cfg(test)]
mod tests;
