//! How well a replay's own map explains its readings, without the truth.
//!
//! A wrong mount or a late clock puts readings beside the walls that other readings made. A map can be
//! bought with more walls, and a path with more corrections, so these have their price: [`Bits::per_arc`] is
//! what it takes to write down a reading to the millimetre when map and path are known, these included.

use std::f64::consts::{E, LOG2_E, PI, TAU};

use crate::core::replay::Outcome;
use crate::core::statistics::share;

/// To what a reading is written down, metres.
const PRECISION: f64 = 1e-3;
/// Over what a reading that the map does not explain can lie, metres.
const SPAN: f64 = 10.0;
/// What a feature costs, in unexplained readings: it has two parameters.
const FEATURE: f64 = 2.0;
/// As far off as this a heading puts what is heard, metres.
const LEVER: f64 = 1.0;

/// How a replay's map explains its arcs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bits {
    /// Arcs.
    pub arcs: u64,
    /// Those that the map explains.
    pub explained: u64,
    /// Sum of the squares of their misfits, in standard deviations.
    pub chi2: f64,
    /// What all arcs take, with the map and the corrections of the path.
    pub all: f64,
}

impl Bits {
    /// Of a replay; `None` where no map says what should have echoed.
    pub fn of(outcome: &Outcome) -> Option<Self> {
        let prediction = outcome.prediction.as_ref()?;
        let mut bits = Self::default();
        let unexplained = libm::log2(SPAN / PRECISION);
        for report in outcome.reports.iter() {
            bits.arcs += 1;
            let fit = prediction.residual(&report.arc);
            let taken = fit.map_or(unexplained, |fit| {
                bits.explained += 1;
                bits.chi2 += fit.chi2();
                let width = (TAU * fit.variance).sqrt() / PRECISION;
                libm::log2(width) + fit.chi2() / 2.0 * LOG2_E
            });
            bits.all += taken.clamp(0.0, unexplained);
        }
        bits.all += prediction.features() as f64 * FEATURE * unexplained;
        bits.all += of_path(outcome);
        Some(bits)
    }

    /// Bits that an arc takes; `None` without one.
    pub fn per_arc(&self) -> Option<f64> {
        (self.arcs > 0).then(|| self.all / self.arcs as f64)
    }

    /// The share of the arcs that the map explains.
    pub fn explained_share(&self) -> Option<f64> {
        share(self.explained, self.arcs)
    }
}

/// What the corrections of a path take: from key pose to key pose, as far as they are more than the
/// precision.
fn of_path(outcome: &Outcome) -> f64 {
    let Some(joint) = outcome.joint() else {
        return 0.0;
    };
    let taken = |variance: f64| libm::log2((2.0 * PI * E * variance).sqrt() / PRECISION).max(0.0);
    let drift = &joint.path.drift;
    let steps = joint.path.keys.iter().skip(1).map(|key| {
        let along = drift.distance * drift.distance * key.driven;
        let heading =
            drift.heading * drift.heading * key.driven + drift.turn * drift.turn * key.turned;
        taken(along) + taken(heading * LEVER * LEVER)
    });
    steps.fold(0.0, |sum, step| sum + step)
}
