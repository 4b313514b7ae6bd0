//! What an arc and its neighbours gave, and what the machine compared of it.

use serde::{Serialize, Serializer};

use super::question::since;
use super::sequences::Given;
use crate::core::config::{Config, Triple};
use crate::core::rounding::{number, optional};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::label::{Kind, Reason};
use crate::core::tmam::report::{ArcReport, Between};
use crate::core::tmam::triple::{TripleTest, has_common_side};

/// A reading, placed in the world. SI units and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Reading {
    pub frame: u32,
    pub stamp_ns: i64,
    /// After the log's first reading.
    #[serde(serialize_with = "number")]
    pub seconds: f64,
    #[serde(serialize_with = "number")]
    pub x: f64,
    #[serde(serialize_with = "number")]
    pub y: f64,
    /// Direction of the beam.
    #[serde(serialize_with = "number")]
    pub yaw: f64,
    #[serde(serialize_with = "number")]
    pub range: f64,
    #[serde(serialize_with = "number")]
    pub sigma: f64,
    #[serde(serialize_with = "number")]
    pub beam_width: f64,
}

impl Reading {
    /// The reading of an arc.
    pub fn new(arc: &Arc, origin_ns: i64) -> Self {
        Self {
            frame: arc.id.frame,
            stamp_ns: arc.stamp_ns,
            seconds: since(arc.stamp_ns, origin_ns),
            x: arc.world_from_sensor.x,
            y: arc.world_from_sensor.y,
            yaw: arc.world_from_sensor.yaw,
            range: arc.range,
            sigma: arc.variance.max(0.0).sqrt(),
            beam_width: arc.beam_width,
        }
    }
}

/// What stands next to an arc in its sonar's sequence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "is", rename_all = "kebab-case")]
pub enum Neighbour {
    Echo(Reading),
    /// The sonar fired, and nothing came back.
    NoEcho {
        frame: u32,
    },
    /// The sequence begins or ends here.
    End,
}

/// A bound that keeps an arc from being the middle of a triple. SI units or radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Obstacle {
    /// The key of the configuration.
    pub key: &'static str,
    #[serde(serialize_with = "word")]
    pub between: Between,
    #[serde(serialize_with = "number")]
    pub found: f64,
    #[serde(serialize_with = "number")]
    pub allowed: f64,
}

fn word<S: Serializer>(between: &Between, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(match between {
        Between::Before => "before",
        Between::After => "after",
        Between::Both => "both",
    })
}

/// An arc between its neighbours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Situation {
    pub before: Neighbour,
    pub after: Neighbour,
    /// Way of the sensor from the arc before, metres.
    #[serde(serialize_with = "optional")]
    pub way_before: Option<f64>,
    /// Way of the sensor to the arc after, metres.
    #[serde(serialize_with = "optional")]
    pub way_after: Option<f64>,
    /// The conditions that do not hold, where it has two echoes beside it.
    pub obstacles: Vec<Obstacle>,
    /// The three arcs, where there are three.
    #[serde(skip)]
    pub three: Option<[Arc; 3]>,
}

impl Situation {
    /// How the arc at `place` of a sequence stands.
    pub fn new(sequence: &[Given<'_>], place: usize, config: &Config, origin_ns: i64) -> Self {
        let given = |at: Option<usize>| at.and_then(|at| sequence.get(at));
        let (before, after) = (given(place.checked_sub(1)), given(place.checked_add(1)));
        let report = given(Some(place)).and_then(|given| given.report);
        let arc = |given: Option<&Given<'_>>| Some(given?.report?.arc);
        let neighbour = |given: Option<&Given<'_>>| match given.map(|given| given.report) {
            Some(Some(report)) => Neighbour::Echo(Reading::new(&report.arc, origin_ns)),
            Some(None) => Neighbour::NoEcho {
                frame: given.map_or(0, |given| given.frame),
            },
            None => Neighbour::End,
        };
        let conditions = report.map(|report| report.conditions(config));
        let broken = conditions.into_iter().flatten().filter(|(_, c)| !c.holds());
        Self {
            before: neighbour(before),
            after: neighbour(after),
            way_before: report.and_then(|report| Some(report.before?.length)),
            way_after: report.and_then(|report| Some(report.after?.length)),
            obstacles: broken
                .map(|(between, condition)| Obstacle {
                    key: condition.key,
                    between,
                    found: condition.found,
                    allowed: condition.bound,
                })
                .collect(),
            three: arc(before)
                .zip(arc(given(Some(place))))
                .zip(arc(after))
                .map(|((before, arc), after)| [before, arc, after]),
        }
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
    pub label: &'static str,
    pub reason: Option<&'static str>,
    pub conditions: Vec<Comparison>,
}

/// One comparison of the paper's rule. Radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison {
    /// The label that needs it.
    pub label: &'static str,
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
            ("contact", "theta_c", "alpha"),
            ("contact", "theta_c", "gamma"),
            ("intersection", "theta_c", "beta"),
            ("intersection", "theta_i", "gamma"),
        ];
        let conditions = names.into_iter().zip(angles.conditions(bounds));
        Self {
            theta_c: angles.theta_c,
            theta_i: angles.theta_i,
            theta_c_sigma: triple.spread.theta_c,
            theta_i_sigma: triple.spread.theta_i,
            has_contact: has_common_side(&angles.contact_points),
            has_intersection: has_common_side(&angles.intersection_points),
            margin: triple.margin,
            label: triple.label.name(),
            reason: triple.label.reason().map(Reason::name),
            conditions: conditions
                .map(|((label, angle, parameter), condition)| Comparison {
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
}

/// The readings `k-m ..= k+m` around an arc, and what they support.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Window {
    /// Readings to either side: m.
    pub half_width: usize,
    pub first_frame: u32,
    pub last_frame: u32,
    /// Squares that remain of the best line.
    #[serde(serialize_with = "number")]
    pub chi2_line: f64,
    #[serde(serialize_with = "number")]
    pub chi2_point: f64,
    /// A model explains the readings when its chi2 is below this.
    #[serde(serialize_with = "number")]
    pub gate: f64,
    pub support: &'static str,
    /// What they decide, if they do: `line` or `point`.
    pub decides: Option<&'static str>,
}

impl Window {
    /// The windows that were looked at around the arc at `place` of a sequence.
    pub fn looked_at(sequence: &[Given<'_>], place: usize, config: &Config) -> Vec<Self> {
        let frame = |at: usize| sequence.get(at).map_or(0, |given| given.frame);
        let report = sequence.get(place).and_then(|given| given.report);
        let tests = report.map_or(&[][..], |report: &ArcReport| &report.windows);
        let windows = (1..).zip(tests);
        windows
            .map(|(half_width, test)| Self {
                half_width,
                first_frame: frame(place.saturating_sub(half_width)),
                last_frame: frame(place + half_width),
                chi2_line: test.chi2_line,
                chi2_point: test.chi2_point,
                gate: test.gate,
                support: test.support.name(),
                decides: test.decided(config.opinion.decisive).map(Kind::name),
            })
            .collect()
    }
}
