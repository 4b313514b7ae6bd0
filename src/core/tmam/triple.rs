//! The decision on the middle arc of a triple.

use super::arc::{Arc, ArcId};
use super::feature::Kind;
use super::hypothesis::HypothesisTest;
use super::pair::{MIN_BASELINE, PairPoint, Points};
use super::spread::Spread;
use crate::core::config::Triple;
use crate::core::geometry::{angle_between, direction};

/// What an arc belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// A line.
    Contact,
    /// A point.
    Intersection,
    /// Neither could be told.
    Unidentified(Reason),
}

/// Why an arc is unidentified, in the order in which the reasons are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// No echo before or after it in the sonar's sequence.
    Missing,
    /// A neighbour too far in time or distance.
    Gap,
    /// The robot turned, or its path bent.
    Turning,
    /// No two points on a common side, neither contact nor intersection points.
    NoPoints,
    /// The smaller angle is not below gamma.
    Wide,
    /// The ratio of the angles lies between alpha and beta; under the noise-aware rule, both a line
    /// and a point explain all the readings that there are.
    Ambiguous,
    /// Under the noise-aware rule: the readings around it come from different targets.
    Neither,
}

/// The geometry of a triple, from which its label follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Contact and intersection points of arcs k-1 and k.
    pub before: Points,
    /// Contact and intersection points of arcs k and k+1.
    pub after: Points,
    /// Smallest angle on arc k between contact points on a common side, radians; the full beam
    /// width where there is none.
    pub theta_c: f64,
    /// The same of intersection points.
    pub theta_i: f64,
    /// Radians that the angles lack, or have to spare, to the nearest bound that would change the
    /// label.
    pub margin: f64,
}

/// What speaks for a label and against it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// The angles, which decide under the paper's rule.
    pub angles: Angles,
    /// How far noise spreads them.
    pub spread: Spread,
    /// What the readings themselves support, within their noise.
    pub opinion: HypothesisTest,
}

/// The decision on one arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The arc.
    pub arc: ArcId,
    /// What it belongs to.
    pub label: Label,
    /// Radians that the angles lack, or have to spare, to the nearest bound that would change the
    /// label; `None` where angles do not decide.
    pub margin: Option<f64>,
    /// How far the chi2 of its readings is from another label; `None` where readings do not decide.
    pub chi2_margin: Option<f64>,
    /// Why; `None` where the arc is not the middle of a triple.
    pub evidence: Option<Evidence>,
}

/// Whether the sensor turned, or its path bent, between three neighbouring arcs.
pub fn turns(before: &Arc, middle: &Arc, after: &Arc, bounds: &Triple) -> bool {
    let heading =
        |a: &Arc, b: &Arc| angle_between(a.world_from_sensor.yaw, b.world_from_sensor.yaw);
    if heading(before, middle) > bounds.turn_tolerance
        || heading(middle, after) > bounds.turn_tolerance
    {
        return true;
    }
    let (first, second) = (
        middle.center() - before.center(),
        after.center() - middle.center(),
    );
    // A sensor that stands still has no direction of travel to bend.
    first.norm() >= MIN_BASELINE
        && second.norm() >= MIN_BASELINE
        && angle_between(direction(first), direction(second)) > bounds.bend_tolerance
}

/// Labels the middle arc from its points with the arc before and the arc after it.
pub fn judge(before: Points, after: Points, beam_width: f64, bounds: &Triple) -> (Label, Angles) {
    let contact = smallest_angle(&before.contact, &after.contact);
    let intersection = smallest_angle(&before.intersection, &after.intersection);
    let theta_c = contact.unwrap_or(beam_width);
    let theta_i = intersection.unwrap_or(beam_width);

    // How far each label's two conditions hold: positive where they do.
    let by_contact = (bounds.alpha * theta_i - theta_c).min(bounds.gamma - theta_c);
    let by_intersection = (theta_c - bounds.beta * theta_i).min(bounds.gamma - theta_i);
    let (label, margin) = if by_contact > 0.0 {
        (Label::Contact, by_contact)
    } else if by_intersection > 0.0 {
        (Label::Intersection, by_intersection)
    } else {
        let reason = if contact.is_none() && intersection.is_none() {
            Reason::NoPoints
        } else if theta_c.min(theta_i) >= bounds.gamma {
            Reason::Wide
        } else {
            Reason::Ambiguous
        };
        (
            Label::Unidentified(reason),
            -by_contact.max(by_intersection),
        )
    };
    let angles = Angles {
        before,
        after,
        theta_c,
        theta_i,
        margin,
    };
    (label, angles)
}

/// The smallest angle, on the middle arc, between points of the two pairs on a common side.
fn smallest_angle(before: &[Option<PairPoint>; 2], after: &[Option<PairPoint>; 2]) -> Option<f64> {
    before
        .iter()
        .zip(after)
        .filter_map(|(b, a)| Some(angle_between(b.as_ref()?.bearing_b, a.as_ref()?.bearing_a)))
        .min_by(f64::total_cmp)
}

impl Label {
    /// `contact`, `intersection` or `unidentified`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Intersection => "intersection",
            Self::Unidentified(_) => "unidentified",
        }
    }

    /// The kind of feature that the arc belongs to.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Contact => Some(Kind::Line),
            Self::Intersection => Some(Kind::Point),
            Self::Unidentified(_) => None,
        }
    }

    /// Why, for an unidentified arc.
    pub fn reason(self) -> Option<Reason> {
        match self {
            Self::Unidentified(reason) => Some(reason),
            Self::Contact | Self::Intersection => None,
        }
    }
}

impl Reason {
    /// Every reason, in the order in which they are tried.
    pub const ALL: [Self; 7] = [
        Self::Missing,
        Self::Gap,
        Self::Turning,
        Self::NoPoints,
        Self::Wide,
        Self::Ambiguous,
        Self::Neither,
    ];

    /// The word in files: `missing`, `gap`, `turning`, `no-points`, `wide`, `ambiguous` or
    /// `neither`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Gap => "gap",
            Self::Turning => "turning",
            Self::NoPoints => "no-points",
            Self::Wide => "wide",
            Self::Ambiguous => "ambiguous",
            Self::Neither => "neither",
        }
    }
}

#[cfg(test)]
mod tests;
