//! What one step of the machine hands to its observers.

use std::sync::Arc as Shared;

use super::arc::{Arc, ArcId};
use super::feature::{Action, MapFeature, Shape};
use super::hypothesis::HypothesisTest;
use super::label::Kind;
use super::report::ArcReport;
use crate::core::geometry::Vec2;

/// Everything that one frame brought about.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Step {
    /// The frame's echoes, sorted by sonar. Their labels follow in later steps, when the next
    /// readings of the sonar have come, or at the end.
    pub arcs: Vec<Arc>,
    /// Arcs of this and earlier frames that have their label now, in the order they got it. Their
    /// runs are still open.
    pub labelled: Vec<ArcReport>,
    /// Of each of these, the arc between its neighbours, where the three make a triple.
    pub triples: Vec<Option<[Arc; 3]>>,
    /// Features extracted from the runs that closed now, each with what became of it in the map.
    pub extractions: Vec<Extraction>,
    /// Map features that changed at the end of the log: their status, or where they end.
    pub settled: Vec<MapFeature>,
    /// Map features that turned out, at the end of the log, to be the same as others, and are gone.
    pub absorbed: Vec<u32>,
    /// At the end of the log, what pulled the path straight, where poses were corrected.
    pub closures: Vec<Closure>,
    /// At the end of the log, the features that the predictions in `reports` name.
    pub predicting: Vec<MapFeature>,
    /// At the end of the log, every arc by frame and sonar, with all that is known of it.
    pub reports: Shared<Vec<ArcReport>>,
}

/// A feature that was seen again after the robot was elsewhere, and taken for another one until the poses
/// were corrected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closure {
    /// Line or point.
    pub kind: Kind,
    /// Where it is, in the world.
    pub place: Vec2,
    /// The frames from which on it was seen, as the one and as the other.
    pub frames: [u32; 2],
}

/// One closed run of equally labelled arcs, and what it gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Extraction {
    /// Counts from 0 in the order of extraction.
    pub id: u32,
    /// What the run's label says.
    pub kind: Kind,
    /// The run: its labelled arcs, in order.
    pub labelled: Vec<ArcId>,
    /// The associated arcs: the run and its neighbour on either side.
    pub associated: Vec<ArcId>,
    /// The estimate; `None` where there was none to speak of.
    pub shape: Option<Shape>,
    /// Root mean square of range minus prediction, metres; 0 without an estimate.
    pub residual_rms: f64,
    /// Iterations of (10) that were made.
    pub iterations: u32,
    /// Whether the stopping rule was met.
    pub converged: bool,
    /// What all its readings together support, but for those that the fit left out; `None` by other methods.
    pub opinion: Option<HypothesisTest>,
    /// Associated arcs that the fit left out.
    pub outliers: Vec<ArcId>,
    /// What became of it.
    pub action: Action,
    /// The map feature after this extraction; `None` where it was rejected.
    pub map_feature: Option<MapFeature>,
    /// Map features that turned out to be the same as this one, and are gone.
    pub absorbed: Vec<u32>,
}
