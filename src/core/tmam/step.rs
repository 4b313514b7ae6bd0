//! What one step of the machine hands to its observers.

use super::arc::Arc;
use super::feature::{Extraction, MapFeature};
use super::stream::ArcReport;
use super::triple::Verdict;

/// Everything that one frame brought about.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Step {
    /// The frame's echoes, sorted by sonar. Their verdicts follow in later steps, when the next
    /// reading of the sonar has come, or at the end.
    pub arcs: Vec<Arc>,
    /// Arcs of this and earlier frames that are decided now, in the order they were decided.
    pub verdicts: Vec<Verdict>,
    /// Features extracted from the runs that closed now, each with what became of it in the map.
    pub extractions: Vec<Extraction>,
    /// Map features that changed at the end of the log: their status, or where they end.
    pub settled: Vec<MapFeature>,
    /// Arcs of this and earlier frames of which all is known now: the label, the opinion of the
    /// widest window and that of the run. By sonar in the order of the arcs.
    pub judgements: Vec<ArcReport>,
}
