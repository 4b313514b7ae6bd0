//! What became of the runs that an arc stands behind.

use serde::Serialize;

use crate::core::replay::Outcome;
use crate::core::rounding::{number, rounded};
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{Action, Extraction, MapFeature, Rejection, Shape};

/// A run that an arc stands behind, and the feature it gave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunStory {
    /// The id of the extracted feature.
    pub feature: u32,
    /// `line` or `point`.
    pub kind: &'static str,
    /// Whether the arc has the run's label; else it is only a neighbour of its arcs.
    pub labelled: bool,
    /// Labelled arcs of the run.
    pub arcs: usize,
    /// Associated readings.
    pub readings: usize,
    /// First frame of them.
    pub first_frame: u32,
    /// Last frame of them.
    pub last_frame: u32,
    /// Readings that the fit left out.
    pub outliers: usize,
    /// Whether the arc is one of them.
    pub left_out: bool,
    /// Root mean square of what remains, metres.
    #[serde(serialize_with = "number")]
    pub residual_rms: f64,
    /// What all its readings support.
    pub opinion: &'static str,
    /// The squares that remain of the best line through them.
    #[serde(serialize_with = "number")]
    pub chi2_line: f64,
    /// The same of the best point.
    #[serde(serialize_with = "number")]
    pub chi2_point: f64,
    /// `registered`, `merged` or `rejected`.
    pub action: &'static str,
    /// Why it was rejected.
    pub reason: Option<&'static str>,
    /// The feature of the map that it went into.
    pub map_id: Option<u32>,
    /// That feature at the end of the run; under another id where it turned out to be the same as
    /// another one.
    pub in_the_end: Option<Registered>,
}

/// A feature of the map, in the end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Registered {
    /// Its id.
    pub id: u32,
    /// `confirmed` or `tentative`.
    pub status: &'static str,
    /// Runs behind it.
    pub runs: u32,
    /// Readings behind it.
    pub readings: u32,
    /// Where it is.
    #[serde(flatten)]
    pub place: Place,
}

/// Where a feature is, metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Place {
    /// A line, from end to end.
    Line {
        /// Distance from the origin.
        rho: f64,
        /// Direction of the normal.
        theta: f64,
        /// The two ends.
        ends: [[f64; 2]; 2],
    },
    /// A point.
    Point {
        /// Where it is.
        x: f64,
        /// The same.
        y: f64,
    },
}

/// The runs that an arc stands behind, in the order of extraction.
pub fn runs(arc: ArcId, outcome: &Outcome) -> Vec<RunStory> {
    let of = outcome
        .extractions
        .iter()
        .filter(|extraction| extraction.associated.contains(&arc));
    of.map(|extraction| story(arc, extraction, outcome))
        .collect()
}

/// A feature of the map by its id, or the one that absorbed it.
pub fn in_the_end(id: u32, outcome: &Outcome) -> Option<Registered> {
    let mut id = id;
    // Every absorption leads to an older or a newer feature that still was there, so no chain is
    // longer than the extractions are many.
    for extraction in &outcome.extractions {
        if extraction.absorbed.contains(&id) {
            id = extraction.map_feature.map_or(id, |feature| feature.id);
        }
    }
    let feature = outcome.map.iter().find(|feature| feature.id == id)?;
    Some(Registered::new(feature))
}

impl Registered {
    fn new(feature: &MapFeature) -> Self {
        let xy = |v: crate::core::geometry::Vec2| [rounded(v.x), rounded(v.y)];
        Self {
            id: feature.id,
            status: feature.status.name(),
            runs: feature.runs,
            readings: feature.readings,
            place: match &feature.shape {
                Shape::Line(segment) => Place::Line {
                    rho: rounded(segment.rho),
                    theta: rounded(segment.theta),
                    ends: segment.ends().map(xy),
                },
                Shape::Point(point) => Place::Point {
                    x: rounded(point.position.x),
                    y: rounded(point.position.y),
                },
            },
        }
    }
}

fn story(arc: ArcId, extraction: &Extraction, outcome: &Outcome) -> RunStory {
    let (action, map_id, reason) = match extraction.action {
        Action::Registered(id) => ("registered", Some(id), None),
        Action::Merged(id) => ("merged", Some(id), None),
        Action::Rejected(reason) => ("rejected", None, Some(reason)),
    };
    let frame = |arc: Option<&ArcId>| arc.map_or(0, |arc| arc.frame);
    RunStory {
        feature: extraction.id,
        kind: extraction.kind.name(),
        labelled: extraction.labelled.contains(&arc),
        arcs: extraction.labelled.len(),
        readings: extraction.associated.len(),
        first_frame: frame(extraction.associated.first()),
        last_frame: frame(extraction.associated.last()),
        outliers: extraction.outliers.len(),
        left_out: extraction.outliers.contains(&arc),
        residual_rms: extraction.residual_rms,
        opinion: extraction.opinion.support.name(),
        chi2_line: extraction.opinion.chi2_line,
        chi2_point: extraction.opinion.chi2_point,
        action,
        reason: reason.map(Rejection::name),
        map_id,
        in_the_end: map_id.and_then(|id| in_the_end(id, outcome)),
    }
}
