//! Noise that is taken to be other than it is.

use super::examined::Examined;
use super::finding::{Finding, Weight};
use crate::core::noise_estimate::{NoiseEstimate, VarianceFrom};
use Weight::{Notable, Serious};

/// Finer noise than this is never too fine, metres: a raster hides it.
const FINEST_NOISE: f64 = 1e-3;

/// Whether the noise that is assumed is the noise that is there.
pub fn check(of: &Examined<'_>) -> Option<Finding> {
    let facts = of.facts;
    let outcome = facts.replay.outcome.as_ref()?;
    let estimate = outcome.scattering.overall()?;
    let NoiseEstimate { sigma, ratio } = estimate;
    let measured = matches!(
        outcome.variance_from,
        VarianceFrom::Ranges | VarianceFrom::Nothing
    );
    if measured || estimate.is_as_expected() || (ratio < 1.0 && sigma < FINEST_NOISE) {
        return None;
    }
    let from_messages = outcome.variance_from == VarianceFrom::Messages;
    let tried = from_messages
        .then(|| of.tried("noise.trust_variance = false"))
        .flatten();
    let (weight, effect) = if ratio > 1.0 || tried.is_some() {
        (
            Serious,
            if ratio > 1.0 {
                "readings that belong together seem not to: arcs stay unidentified (neither), and right \
                 labels are called suspect"
            } else {
                "walls and corners seem to fit alike, and so does much else"
            },
        )
    } else {
        (
            Notable,
            "walls and corners seem to fit alike: arcs stay unidentified (ambiguous) for longer than \
             they need to",
        )
    };
    Some(
        Finding::new(
            weight,
            "noise",
            estimate.complaint(),
            effect,
            match &tried {
                Some(tried) => format!("set {}{tried}", tried.keys),
                None => estimate.mend(outcome.variance_from),
            },
        )
        .with(tried),
    )
}
