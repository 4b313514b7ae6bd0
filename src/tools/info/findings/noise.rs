//! Whether the ranges are as precise as they are taken to be.

use super::{Finding, Info, Weight};
use crate::core::noise_estimate::{NoiseEstimate, VarianceFrom};

/// Finer noise than this is never too fine, metres: a raster hides it.
const FINEST: f64 = 1e-3;

/// Whether the noise that is assumed is the noise that is there.
pub fn findings(info: &Info, findings: &mut Vec<Finding>) {
    let Some(outcome) = &info.trial.outcome else {
        return;
    };
    let Some(scatter) = outcome.scattering.overall() else {
        return;
    };
    let NoiseEstimate { sigma, ratio } = scatter;
    let measured = matches!(
        outcome.variance_from,
        VarianceFrom::Ranges | VarianceFrom::Nothing
    );
    if measured || scatter.is_as_expected() || (ratio < 1.0 && sigma < FINEST) {
        return;
    }
    let (weight, effect) = if ratio > 1.0 {
        (
            Weight::Serious,
            "readings that belong together seem not to: arcs stay unidentified (neither), and right \
             labels are called suspect",
        )
    } else {
        (
            Weight::Notable,
            "walls and corners seem to fit alike: arcs stay unidentified (ambiguous) for longer than \
             they need to",
        )
    };
    findings.push(Finding::new(
        weight,
        "noise",
        scatter.complaint(),
        effect,
        scatter.mend(outcome.variance_from),
    ));
}
