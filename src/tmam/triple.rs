//! The decision on the middle arc of a triple.

use super::arc::ArcId;
use super::pair::Points;

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
    /// Neither pair of points on a common side.
    NoPoints,
    /// The smaller angle is not below gamma.
    Wide,
    /// The ratio of the angles lies between alpha and beta.
    Ambiguous,
}

/// The geometry of a triple, from which its label follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Contact and intersection points of arcs k-1 and k.
    pub before: Points,
    /// Contact and intersection points of arcs k and k+1.
    pub after: Points,
    /// Smallest angle on arc k between contact points on a common side, radians; the full beam
    /// width where there is none.
    pub theta_c: f64,
    /// The same of intersection points.
    pub theta_i: f64,
    /// Radians to the nearest bound that would change the label.
    pub margin: f64,
}

/// The decision on one arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The arc.
    pub arc: ArcId,
    /// What it belongs to.
    pub label: Label,
    /// Why; `None` where the arc is not the middle of a triple.
    pub evidence: Option<Evidence>,
}
