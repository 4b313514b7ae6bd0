//! A sonar of several that hears nothing, or always the same: a wire that is off, a transducer that is clogged.

use super::examined::Examined;
use super::finding::{Finding, Weight, percent, which_sonars};
use super::sonars::SonarFacts;
use crate::core::statistics::fraction;

/// So many readings show that a sonar is dead.
const ENOUGH: u64 = 40;
/// Of a sonar that lives such a share of the readings are echoes.
const LIVELY: f64 = 0.1;
/// Of one that is stuck such a share of the echoes has one value, while it moved.
const STUCK: f64 = 0.9;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    let sonars = &of.facts.sonars;
    let is_lively = |sonar: &&SonarFacts| {
        stuck(sonar).is_none() && fraction(sonar.echoes, sonar.readings) > LIVELY
    };
    // Where few hear something there is little to hear.
    let are_lively = sonars.iter().filter(is_lively).count() * 2 > sonars.len();
    let silent: Vec<&SonarFacts> = sonars.iter().filter(|sonar| sonar.echoes == 0).collect();
    let is_dead = are_lively && silent.iter().any(|sonar| sonar.readings >= ENOUGH);
    let names: Vec<&str> = silent.iter().map(|sonar| sonar.name.as_str()).collect();
    let silent = (!silent.is_empty()).then(|| {
        Finding::new(
            if is_dead {
                Weight::Serious
            } else {
                Weight::Notable
            },
            if is_dead { "dead-sonar" } else { "silent" },
            format!(
                "{}: not a single echo{}",
                which_sonars(&names, sonars.len()),
                if are_lively {
                    ", while most others hear something"
                } else {
                    ""
                }
            ),
            "the map has nothing from there",
            "look at the wiring, or leave it out with --sensor",
        )
    });
    if !are_lively {
        return silent.into_iter().collect();
    }
    let stuck = sonars
        .iter()
        .filter_map(|sonar| Some((sonar, stuck(sonar)?)));
    let stuck = stuck.map(|(sonar, (range, share))| {
        let others = sonars.iter().filter(|other| other.id != sonar.id);
        let others: Vec<String> = others
            .map(|other| toml::Value::from(other.name.as_str()).to_string())
            .collect();
        let key = format!("input.sonars = [{}]", others.join(", "));
        let tried = of.tried(&key).unwrap_or_default();
        Finding::new(
            Weight::Serious,
            "dead-sonar",
            format!(
                "sonar {}: {} of its echoes are {range:.3} m, wherever it is",
                sonar.name,
                percent(share)
            ),
            "its arcs are no echoes of anything",
            format!("look at its wiring; leave it out: {key}{tried}"),
        )
    });
    silent.into_iter().chain(stuck).collect()
}

/// The range at which a sonar is stuck, and the share of its echoes there.
fn stuck(sonar: &SonarFacts) -> Option<(f64, f64)> {
    let (range, count) = sonar.commonest?;
    let share = fraction(count, sonar.echoes);
    (sonar.moved >= ENOUGH && share > STUCK).then_some((range, share))
}
