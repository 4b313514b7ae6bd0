//! What can be wrong with a sonar or with what came back to it.

use super::examined::Examined;
use super::finding::{Finding, Weight, percent, which_sonars};
use super::sonars::SonarFacts;
use crate::core::config::Sequence;
use crate::core::statistics::fraction;
use crate::io::log::WIDEST_BEAM;
use Weight::{Notable, Serious};

/// A share of invalid readings, or of neighbours too far apart, that matters.
const MANY: f64 = 0.25;

/// What can be wrong with a sonar or with what came back to it.
struct SonarCheck {
    weight: Weight,
    code: &'static str,
    is_wrong: fn(&SonarFacts) -> bool,
    /// Told of all sonars of which it holds.
    what: fn(&[&SonarFacts], &Sequence) -> String,
    effect: &'static str,
    mend: &'static str,
    /// What is tried.
    key: fn(&SonarFacts) -> Option<String>,
}

const TOO_FAR_APART: &str = "too-far-apart";

const SONAR_CHECKS: [SonarCheck; 4] = [
    SonarCheck {
        weight: Serious,
        code: "beam-width",
        is_wrong: |s| s.beam_width.is_some_and(|w| w >= WIDEST_BEAM),
        what: |sonars, _| {
            let degrees = |s: &SonarFacts| s.beam_width.unwrap_or(0.0).to_degrees();
            let width = between(sonars, degrees, |degrees| format!("{degrees:.0} deg"));
            format!("the beam is {width} wide")
        },
        effect: "points anywhere around the robot count, and labels mean little",
        mend: "field_of_view is in radians: does the driver write degrees? sonars.beam_width (deg) overrules \
               it; mend the driver",
        key: in_degrees,
    },
    SonarCheck {
        weight: Serious,
        code: TOO_FAR_APART,
        is_wrong: |s| apart(s) > MANY,
        what: |sonars, bounds| {
            format!(
                "{} of the neighbouring readings lie more than {} m or {} s apart",
                between(sonars, apart, percent),
                bounds.max_baseline,
                bounds.max_gap
            )
        },
        effect: "these break the sequence, and arcs at a break are not labelled (gap)",
        mend: "drive slower, let the sonars fire more often, or raise sequence.max_baseline or max_gap",
        key: |_| None,
    },
    SonarCheck {
        weight: Notable,
        code: "invalid",
        is_wrong: |s| invalid(s) > MANY,
        what: |sonars, _| {
            let share = between(sonars, invalid, percent);
            format!("{share} of the readings mean nothing (NaN, -inf or below min_range)")
        },
        effect: "they are left out",
        mend: "look at min_range and at what the driver writes when nothing comes back (+inf would be right)",
        key: |_| None,
    },
    SonarCheck {
        weight: Notable,
        code: "varies",
        is_wrong: |s| s.varies,
        what: |_, _| "beam width or range limits change during the log".to_owned(),
        effect: "each reading is taken with its own",
        mend: "",
        key: |_| None,
    },
];

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    let facts = of.facts;
    let finding = |check: &SonarCheck| {
        let sonars = facts.sonars.iter();
        let wrong: Vec<&SonarFacts> = sonars.filter(|s| (check.is_wrong)(s)).collect();
        let which: Vec<&str> = wrong.iter().map(|s| s.name.as_str()).collect();
        let which = which_sonars(&which, facts.sonars.len());
        if wrong.is_empty() {
            return None;
        }
        let what = (check.what)(&wrong, &facts.replay.config.sequence);
        let key = wrong.first().and_then(|sonar| (check.key)(sonar));
        let tried = key.and_then(|key| of.tried(&key));
        let came_of = tried
            .as_ref()
            .map(|tried| format!("; {}{tried}", tried.keys));
        Some(
            Finding::new(
                check.weight,
                check.code,
                format!("{which}: {what}"),
                check.effect,
                format!("{}{}", check.mend, came_of.unwrap_or_default()),
            )
            .with(tried),
        )
    };
    // Times that come twice put readings of two places next to each other.
    let means_something =
        |check: &&SonarCheck| check.code != TOO_FAR_APART || facts.clock_set.is_none();
    let checks = SONAR_CHECKS.iter().filter(means_something);
    checks.filter_map(finding).collect()
}

/// Of its neighbouring readings.
fn apart(sonar: &SonarFacts) -> f64 {
    fraction(sonar.too_far_apart, sonar.readings.saturating_sub(1))
}

fn invalid(sonar: &SonarFacts) -> f64 {
    fraction(sonar.invalid, sonar.readings)
}

/// `93 %`, or `85 % to 93 %` where sonars differ.
pub fn between(
    sonars: &[&SonarFacts],
    of: impl Fn(&SonarFacts) -> f64,
    told: impl Fn(f64) -> String,
) -> String {
    let values = || sonars.iter().map(|sonar| of(sonar));
    let least = told(values().fold(f64::INFINITY, f64::min));
    let most = told(values().fold(f64::NEG_INFINITY, f64::max));
    match least == most {
        true => most,
        false => format!("{least} to {most}"),
    }
}

/// The key that takes a beam width in radians for one in degrees.
fn in_degrees(sonar: &SonarFacts) -> Option<String> {
    let width = sonar.beam_width.filter(|width| *width < 180.0)?;
    Some(format!("sonars.beam_width = {}", width as f32))
}
