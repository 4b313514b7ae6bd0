//! What one step of the machine hands to its observers.

use super::arc::Arc;
use super::feature::{Extraction, MapFeature};
use super::report::ArcReport;

/// Everything that one frame brought about.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Step {
    /// The frame's echoes, sorted by sonar. Their labels follow in later steps, when the next
    /// readings of the sonar have come, or at the end.
    pub arcs: Vec<Arc>,
    /// Arcs of this and earlier frames that have their label now, in the order they got it. Their
    /// runs are still open.
    pub labelled: Vec<ArcReport>,
    /// Features extracted from the runs that closed now, each with what became of it in the map.
    pub extractions: Vec<Extraction>,
    /// Map features that changed at the end of the log: their status, or where they end.
    pub settled: Vec<MapFeature>,
    /// At the end of the log, every arc by frame and sonar, with all that is known of it.
    pub reports: Vec<ArcReport>,
}
