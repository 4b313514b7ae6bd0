//! What the paper counts of its experiment.

use std::collections::BTreeSet;

use super::paper;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::feature::{Kind, MapFeature};
use crate::core::tmam::step::Extraction;

/// The numbers that the paper gives. Of pairs the points come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    pub readings: u64,
    pub associated: u64,
    pub extracted: [u64; 2],
    pub registered: [u64; 2],
}

impl Counts {
    pub const OF_THE_PAPER: Self = Self {
        readings: paper::READINGS,
        associated: paper::ASSOCIATED,
        extracted: paper::EXTRACTED,
        registered: paper::REGISTERED,
    };

    /// Of a replay of so many readings.
    pub fn of(readings: u64, extractions: &[&Extraction], map: &[MapFeature]) -> Self {
        let used = extractions
            .iter()
            .filter(|one| one.action.rejection().is_none());
        let used: Vec<&&Extraction> = used.collect();
        let arcs: BTreeSet<ArcId> = used
            .iter()
            .flat_map(|extraction| extraction.associated.iter().copied())
            .collect();
        let both = [Kind::Point, Kind::Line];
        Self {
            readings,
            associated: arcs.len() as u64,
            extracted: both.map(|kind| {
                used.iter()
                    .filter(|extraction| extraction.kind == kind)
                    .count() as u64
            }),
            registered: both
                .map(|kind| map.iter().filter(|f| f.shape.kind() == kind).count() as u64),
        }
    }

    /// How far they are from the paper's: the sum of the logarithms of their ratios, without sign.
    pub fn distance(&self) -> f64 {
        let pairs = self.all().into_iter().zip(Self::OF_THE_PAPER.all());
        let ratios = pairs.map(|(ours, papers)| (ours as f64 + 1.0) / (papers as f64 + 1.0));
        ratios.fold(0.0, |sum, ratio| sum + libm::log(ratio).abs())
    }

    fn all(&self) -> [u64; 5] {
        let ([ep, el], [rp, rl]) = (self.extracted, self.registered);
        [self.associated, ep, el, rp, rl]
    }
}
