//! What became of an arc: its runs, what contradicts its label, and what it really was.

use serde::Serialize;

use super::situation::Situation;
use crate::core::geometry::Vec2;
use crate::core::replay::Outcome;
use crate::core::rounding::{number, rounded};
use crate::core::tmam::arc::{Arc, ArcId};
use crate::core::tmam::feature::{Action, MapFeature, Rejection, Shape};
use crate::core::tmam::label::Label;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::step::Extraction;
use crate::core::world::Reflector;
use crate::tools::evaluate::truth::{Origin, Other, Target, Truth};

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
        let xy = |v: Vec2| [rounded(v.x), rounded(v.y)];
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

/// What the map of all readings says of an arc.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MapStory {
    /// Which kind of feature explains it: `line`, `point`, `ambiguous` or `neither`.
    pub says: &'static str,
    /// The feature that does: an id of the map that the noise-aware rule makes of the whole log.
    pub feature: Option<u32>,
}

/// Something that contradicts a label.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Doubt {
    /// Who says so: `map`, `triple`, `window` or `run`.
    pub by: &'static str,
    /// What it says instead: `line`, `point` or `neither`.
    pub says: &'static str,
    /// The map's feature that explains the reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feature: Option<u32>,
    /// How many readings were asked; `None` for the map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readings: Option<usize>,
}

/// Everything that makes an arc suspect; empty for one that is not.
pub fn doubts(report: &ArcReport) -> Vec<Doubt> {
    if !report.is_suspect() {
        return Vec::new();
    }
    if let Some(map) = report.map.filter(|map| map.support.kind().is_some()) {
        return vec![Doubt {
            by: "map",
            says: map.support.name(),
            feature: map.feature,
            readings: None,
        }];
    }
    let tests = report.tests();
    tests
        // The window of a triple that decided is the triple.
        .filter(|(by, test)| *by != "window" || test.readings > 3)
        .filter(|(_, test)| test.contradicts(report.label))
        .map(|(by, test)| Doubt {
            by,
            says: test.support.name(),
            feature: None,
            readings: Some(test.readings),
        })
        .collect()
}

/// chi2 of the model that the label stands for.
pub fn chi2_of_label(report: &ArcReport) -> Option<f64> {
    let kind = report.label.kind()?;
    let triple = report.triple.as_ref().map(|triple| &triple.test);
    Some(report.window().or(triple)?.chi2_of(kind))
}

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
        let xy = |v: &Vec2| [rounded(v.x), rounded(v.y)];
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
