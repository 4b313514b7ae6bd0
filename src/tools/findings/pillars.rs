//! Round pillars: each is a point somewhere else from wherever it is seen, and its ranges seem too short
//! (Kuc and Siegel 1987).

use super::examined::Examined;
use super::finding::{Finding, Weight};

/// In a log of which more is explained they do no harm.
const WELL: f64 = 0.97;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let explained = of.explained()?;
    if explained.share > WELL || of.survey.config.noise_aware.circles || of.is_long() {
        return None;
    }
    // A path that settles otherwise explains more without a single pillar.
    let tried = of
        .tried("noise_aware.circles = true")
        .filter(|tried| tried.leaves_half() && tried.with.circles > 0)?;
    Some(
        Finding::new(
            Weight::Serious,
            "pillars",
            format!(
                "the map explains {:.0} % of the arcs; with round pillars beside walls and points it explains more",
                100.0 * explained.share
            ),
            "a pillar is another point from wherever it is seen",
            format!("set {}{tried}", tried.keys),
        )
        .with(Some(tried)),
    )
}
