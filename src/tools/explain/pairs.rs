//! The geometry of the two pairs: where common tangents touch, where arcs cross, and which beams hold
//! these points.

use serde::Serialize;

use crate::core::geometry::{Vec2, direction, wrap_angle};
use crate::core::rounding::{number, rounded};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::pair::{MIN_BASELINE, PairPoint, Points, cos_contact, cos_intersection};

/// Two neighbouring arcs. SI units and radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// From one sensor centre to the other, metres.
    #[serde(serialize_with = "number")]
    pub base_line: f64,
    /// Whether that is too short to have a direction; then there are no points.
    pub too_short: bool,
    /// Direction of the base line in the world.
    #[serde(serialize_with = "number")]
    pub direction: f64,
    /// Where the common tangent touches.
    pub contact: Candidates,
    /// Where the arcs cross.
    pub intersection: Candidates,
}

/// The points of one kind that the whole circles have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidates {
    /// The cosine of (2) or (3); beyond 1 there is no such point.
    #[serde(serialize_with = "number")]
    pub cosine: f64,
    /// Left and right of travel; none where the cosine has no angle.
    pub sides: Vec<Candidate>,
}

/// A point of the whole circles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Candidate {
    /// `left` or `right` of travel.
    pub side: &'static str,
    /// Seen from the two sensors.
    pub seen: [Seen; 2],
    /// Whether both beams hold it: only then it counts.
    pub counts: bool,
}

/// A point as one sensor sees it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Seen {
    /// Where on the arc it lies.
    pub at: [f64; 2],
    /// Its bearing in the world.
    #[serde(serialize_with = "number")]
    pub bearing: f64,
    /// Its bearing off the beam's axis, positive to the left.
    #[serde(serialize_with = "number")]
    pub off_axis: f64,
    /// Whether the beam holds it.
    pub held: bool,
}

impl Pair {
    /// The two pairs of three arcs.
    pub fn both([first, middle, last]: &[Arc; 3]) -> Vec<Self> {
        vec![Self::new(first, middle), Self::new(middle, last)]
    }

    fn new(a: &Arc, b: &Arc) -> Self {
        let way = b.center() - a.center();
        let d = way.norm();
        let points = Points::of_circles(a, b);
        let candidates = |cosine: f64, points: [Option<PairPoint>; 2]| Candidates {
            cosine,
            sides: ["left", "right"]
                .into_iter()
                .zip(points)
                .filter_map(|(side, point)| Some(candidate(side, &point?, a, b)))
                .collect(),
        };
        Self {
            base_line: d,
            too_short: d < MIN_BASELINE,
            direction: direction(way),
            contact: candidates(cos_contact(a.range, b.range, d), points.contact),
            intersection: candidates(cos_intersection(a.range, b.range, d), points.intersection),
        }
    }
}

fn candidate(side: &'static str, point: &PairPoint, a: &Arc, b: &Arc) -> Candidate {
    let seen = |arc: &Arc, bearing: f64, at: Vec2| Seen {
        at: [rounded(at.x), rounded(at.y)],
        bearing: wrap_angle(bearing),
        off_axis: wrap_angle(bearing - arc.world_from_sensor.yaw),
        held: arc.beam_holds(bearing),
    };
    let seen = [
        seen(a, point.bearing_a, point.on_a),
        seen(b, point.bearing_b, point.on_b),
    ];
    Candidate {
        side,
        seen,
        counts: seen.iter().all(|seen| seen.held),
    }
}
