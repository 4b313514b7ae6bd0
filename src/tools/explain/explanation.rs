//! What is told of an arc.

use serde::Serialize;

use super::doubts::Doubt;
use super::outcome::RunStory;
use super::pairs::Pair;
use super::rule::{Change, Condition};
use super::situation::{Reading, Situation};
use super::truth::TruthStory;
use super::windows::Window;
use crate::core::rounding::{number, optional};

/// The whole story of an arc. SI units and radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// The sonar's name.
    pub sensor: String,
    /// The arc.
    pub arc: Reading,
    /// How far it passes from the place that was asked for.
    #[serde(serialize_with = "optional")]
    pub distance: Option<f64>,
    /// How long after the time that was asked for it was measured, seconds.
    #[serde(serialize_with = "optional")]
    pub late: Option<f64>,
    /// Other arcs that pass about as near, nearest first.
    pub also_near: Vec<Near>,
    /// `contact`, `intersection` or `unidentified`.
    pub label: &'static str,
    /// Why, for an unidentified arc.
    pub reason: Option<&'static str>,
    /// What decided: `angles` or `opinion`.
    pub decided_by: &'static str,
    /// Whether the label is suspect.
    pub suspect: bool,
    /// What contradicts it.
    pub doubts: Vec<Doubt>,
    /// How it stands to its neighbours.
    pub situation: Situation,
    /// The two pairs, where the arc has an echo on either side.
    pub pairs: Vec<Pair>,
    /// The angles, where it is the middle of a triple; those it would have, where only a bound keeps
    /// it from that.
    pub angles: Option<AnglesStory>,
    /// What would have given another label.
    pub changes: Vec<Change>,
    /// The second opinion, window by window.
    pub windows: Vec<Window>,
    /// The lead in chi2 that decides.
    #[serde(serialize_with = "number")]
    pub decisive: f64,
    /// Why no wider window was looked at: `decided`, `neither`, `max-half-width` or `no-more-readings`.
    pub windows_end: Option<&'static str>,
    /// Runs that the arc stands behind, and what became of them.
    pub runs: Vec<RunStory>,
    /// What the map of all readings says.
    pub map: Option<MapStory>,
    /// What echoed, where that is known.
    pub truth: Option<TruthStory>,
}

/// Another arc that passes near a place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Near {
    /// Its sonar.
    pub sensor: String,
    /// Its frame.
    pub frame: u32,
    /// How far it passes, metres.
    #[serde(serialize_with = "optional")]
    pub distance: Option<f64>,
}

/// The angles of a triple, and the paper's rule on them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnglesStory {
    /// Between contact points; the beam width where there are none on a common side.
    #[serde(serialize_with = "number")]
    pub theta_c: f64,
    /// Between intersection points.
    #[serde(serialize_with = "number")]
    pub theta_i: f64,
    /// Standard deviation of `theta_c` that the noise of the ranges predicts.
    #[serde(serialize_with = "optional")]
    pub theta_c_sigma: Option<f64>,
    /// The same of `theta_i`.
    #[serde(serialize_with = "optional")]
    pub theta_i_sigma: Option<f64>,
    /// Whether there are contact points on a common side.
    pub has_contact: bool,
    /// Whether there are intersection points on a common side.
    pub has_intersection: bool,
    /// What the angles have to spare, or lack.
    #[serde(serialize_with = "number")]
    pub margin: f64,
    /// The label by the paper's rule.
    pub label: &'static str,
    /// Why, where that is unidentified.
    pub reason: Option<&'static str>,
    /// The rule's comparisons.
    pub conditions: [Condition; 4],
}

/// What the map of all readings says of an arc.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MapStory {
    /// Which kind of feature explains it: `line`, `point`, `ambiguous` or `neither`.
    pub says: &'static str,
    /// The feature that does: an id of the map that the noise-aware rule makes of the whole log.
    pub feature: Option<u32>,
}
