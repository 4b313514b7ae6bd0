//! What the paper's rule compares of an arc and its neighbours: where common tangents touch and arcs
//! cross, which beams hold these points, the angles between them, and the bounds on these.

use std::fmt::Write as _;

use serde::Serialize;

use crate::core::config::Triple;
use crate::core::geometry::{Vec2, direction, wrap_angle};
use crate::core::rounding::{number, optional, rounded};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::label::{Label, Reason};
use crate::core::tmam::pair::{MIN_BASELINE, PairPoint, Points, cos_contact, cos_intersection};
use crate::core::tmam::triple::{TripleTest, has_common_side};

/// Two neighbouring arcs. SI units and radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// From one sensor centre to the other.
    #[serde(serialize_with = "number")]
    pub base_line: f64,
    /// Whether that is too short to have a direction; then there are no points.
    pub too_short: bool,
    /// Direction of the base line in the world.
    #[serde(serialize_with = "number")]
    pub direction: f64,
    /// Where the common tangent touches.
    pub contact: CirclePoints,
    /// Where the arcs cross.
    pub intersection: CirclePoints,
}

/// The points of one kind that the whole circles have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CirclePoints {
    /// The cosine of (2) or (3); beyond 1 there is no such point.
    #[serde(serialize_with = "number")]
    pub cosine: f64,
    /// Left and right of travel; none where the cosine has no angle.
    pub sides: Vec<CirclePoint>,
}

/// A point of the whole circles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CirclePoint {
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
        let seen = |arc: &Arc, bearing: f64, at: Vec2| Seen {
            at: [rounded(at.x), rounded(at.y)],
            bearing: wrap_angle(bearing),
            off_axis: wrap_angle(bearing - arc.world_from_sensor.yaw),
            held: arc.beam_holds(bearing),
        };
        let candidate = |(side, point): (&'static str, Option<PairPoint>)| {
            let point = point?;
            let seen = [
                seen(a, point.bearing_a, point.on_a),
                seen(b, point.bearing_b, point.on_b),
            ];
            let counts = seen.iter().all(|seen| seen.held);
            Some(CirclePoint { side, seen, counts })
        };
        let candidates = |cosine, points| CirclePoints {
            cosine,
            sides: (["left", "right"].into_iter().zip(points))
                .filter_map(candidate)
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

    /// The pairs before and after an arc.
    pub fn text(pairs: &[Self], beam_width: f64) -> String {
        let mut text = String::new();
        for (name, pair) in ["before - this arc", "this arc - after"].iter().zip(pairs) {
            let length = format!("{:.1} mm", pair.base_line * 1e3);
            let towards = degrees(pair.direction);
            let _ = writeln!(text, "  {name}: base line {length} towards {towards}");
            if pair.too_short {
                text.push_str("    the sensor stood still: no base line, so no points\n");
                continue;
            }
            for (name, CirclePoints { cosine, sides }) in [
                ("contact", &pair.contact),
                ("intersection", &pair.intersection),
            ] {
                if sides.is_empty() {
                    let _ = writeln!(
                        text,
                        "    {name:<12}  cos {cosine:.4} is beyond 1: the ranges differ by more than {length} allow",
                    );
                }
                for point in sides {
                    let _ = writeln!(
                        text,
                        "    {name:<12}  cos {cosine:+.4}  {:5}  {}",
                        point.side,
                        point.text(beam_width / 2.0)
                    );
                }
            }
        }
        text
    }
}

impl CirclePoint {
    fn text(&self, half: f64) -> String {
        let [a, b] = self.seen;
        let outside = match (a.held, b.held) {
            (true, true) => None,
            (false, false) => Some("both beams"),
            (false, true) => Some("the first beam"),
            (true, false) => Some("the second beam"),
        };
        let lies = match outside {
            None => format!("at {}", place(b.at)),
            Some(beams) => format!("outside {beams} (+-{:.2})", half.to_degrees()),
        };
        let [a, b] = [a, b].map(|seen| format!("{:+.2}", seen.off_axis.to_degrees()));
        format!("{a:>7}, {b:>7}  {lies}")
    }
}

/// The angles of a triple, and the paper's rule on them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnglesStory {
    /// Between contact points; the beam width where there are none on a common side.
    #[serde(serialize_with = "number")]
    pub theta_c: f64,
    #[serde(serialize_with = "number")]
    pub theta_i: f64,
    /// Standard deviation that the noise of the ranges predicts.
    #[serde(serialize_with = "optional")]
    pub theta_c_sigma: Option<f64>,
    #[serde(serialize_with = "optional")]
    pub theta_i_sigma: Option<f64>,
    /// Whether there are contact points on a common side.
    pub has_contact: bool,
    pub has_intersection: bool,
    /// What the angles have to spare, or lack.
    #[serde(serialize_with = "number")]
    pub margin: f64,
    /// By the paper's rule.
    pub label: Label,
    pub reason: Option<Reason>,
    pub conditions: Vec<AngleComparison>,
}

/// One comparison of the paper's rule. Radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AngleComparison {
    /// The label that needs it.
    pub label: Label,
    /// `theta_c` or `theta_i`.
    pub angle: &'static str,
    #[serde(serialize_with = "number")]
    pub value: f64,
    pub relation: &'static str,
    /// `alpha`, `beta` or `gamma`.
    pub parameter: &'static str,
    /// The `theta_i` that it is multiplied with; `None` for gamma.
    #[serde(serialize_with = "optional")]
    pub times: Option<f64>,
    #[serde(serialize_with = "number")]
    pub bound: f64,
    pub holds: bool,
}

impl AnglesStory {
    /// Of a triple, under these bounds.
    pub fn new(triple: &TripleTest, bounds: &Triple) -> Self {
        let angles = &triple.angles;
        let names = [
            (Label::Contact, "theta_c", "alpha"),
            (Label::Contact, "theta_c", "gamma"),
            (Label::Intersection, "theta_c", "beta"),
            (Label::Intersection, "theta_i", "gamma"),
        ];
        let conditions = names.into_iter().zip(angles.conditions(bounds));
        Self {
            theta_c: angles.theta_c,
            theta_i: angles.theta_i,
            theta_c_sigma: triple.spread.theta_c(),
            theta_i_sigma: triple.spread.theta_i(),
            has_contact: has_common_side(&angles.contact),
            has_intersection: has_common_side(&angles.intersection),
            margin: triple.margin,
            label: triple.label,
            reason: triple.label.reason(),
            conditions: conditions
                .map(|((label, angle, parameter), condition)| AngleComparison {
                    label,
                    angle,
                    value: condition.found,
                    relation: condition.relation.sign(),
                    parameter,
                    times: (parameter != "gamma").then_some(angles.theta_i),
                    bound: condition.bound,
                    holds: condition.holds(),
                })
                .collect(),
        }
    }

    /// Which comparison decided.
    pub fn decision(&self) -> String {
        let [c, i] = [self.theta_c, self.theta_i].map(degrees);
        let that = |label: Label, holds: bool| {
            let mut all = self.conditions.iter();
            let found = all.find(|one| one.label == label && one.holds == holds);
            found.map_or_else(String::new, AngleComparison::sentence)
        };
        match self.label {
            Label::Contact | Label::Intersection | Label::Circle => {
                let margin = degrees(self.margin);
                format!("{}, with {margin} to spare", that(self.label, true))
            }
            Label::Unidentified(Reason::NoPoints) => {
                "Its arcs meet in no two points on a common side, within the beams".to_owned()
            }
            Label::Unidentified(Reason::Wide) => {
                format!("theta_c {c} and theta_i {i}: neither is below gamma")
            }
            Label::Unidentified(_) => {
                let mut beyond = self.conditions.iter().filter(|one| one.times.is_some());
                let kind = beyond.find(|one| one.holds).map(|one| one.label);
                match kind {
                    Some(kind) => format!("No {}, for not {}", kind.name(), that(kind, false)),
                    None => format!("theta_c {c} by theta_i {i} lies between alpha and beta"),
                }
            }
        }
    }

    /// Both angles and the rule on them.
    pub fn text(&self, beam_width: f64) -> String {
        let angle = |what: &str, angle: f64, sigma: Option<f64>, has: bool| {
            let angle = degrees(angle);
            match sigma.map(degrees) {
                _ if !has => format!(
                    "{}: the full beam width, for want of such points on a common side",
                    degrees(beam_width)
                ),
                None => format!("{angle} between {what} points"),
                Some(sigma) => format!("{angle} +- {sigma} between {what} points"),
            }
        };
        let (c, i) = (self.theta_c_sigma, self.theta_i_sigma);
        let mut text = format!(
            "  theta_c  {}\n  theta_i  {}\n",
            angle("contact", self.theta_c, c, self.has_contact),
            angle("intersection", self.theta_i, i, self.has_intersection)
        );
        for condition in &self.conditions {
            let _ = writeln!(text, "  {}", condition.text());
        }
        let margin = degrees(self.margin);
        let _ = match self.reason {
            None => writeln!(text, "  so {}, with {margin} to spare", self.label.name()),
            Some(reason) => writeln!(
                text,
                "  so unidentified ({}); {margin} short of the nearer label",
                reason.name()
            ),
        };
        if let (Some(c), Some(i)) = (c, i)
            && self.has_contact
            && self.has_intersection
            && (self.theta_c - self.theta_i).abs() < (c * c + i * i).sqrt()
        {
            text.push_str(
                "  The two angles differ by less than noise spreads them: too short a base line to decide.\n",
            );
        }
        text
    }
}

impl AngleComparison {
    /// The comparison in a line.
    fn text(&self) -> String {
        let holds = if self.holds { "yes" } else { "no" };
        format!("{:<13} {:<66} {holds}", self.label.name(), self.sentence())
    }

    fn sentence(&self) -> String {
        let product = match self.times {
            None => String::new(),
            Some(times) if times > 0.0 => {
                let factor = self.bound / times;
                format!(" * theta_i = {factor:.3} * {}", degrees(times))
            }
            Some(_) => " * theta_i".to_owned(),
        };
        format!(
            "{} {} {} {}{product} = {}",
            self.angle,
            degrees(self.value),
            self.relation,
            self.parameter,
            degrees(self.bound)
        )
    }
}

/// An angle as text.
pub fn degrees(angle: f64) -> String {
    format!("{:.2} deg", angle.to_degrees())
}

/// A place in the world as text.
pub fn place([x, y]: [f64; 2]) -> String {
    format!("({x:.3}, {y:.3})")
}
