//! A sonar of several that hears nothing, or always the same: a wire that is off, a transducer that is clogged.

use std::f64::consts::PI;

use super::examined::{Examined, in_words};
use super::finding::{Finding, Weight, percent, which_sonars};
use super::sonars::SonarFacts;
use super::stand_in;
use crate::core::statistics::{fraction, median};

/// So many readings show that a sonar is dead.
const ENOUGH: u64 = 40;
/// Of a sonar that lives such a share of the readings are echoes.
const LIVELY: f64 = 0.1;
/// A way, metres, along which nothing stays the same.
const FAR: f64 = 2.0;
/// Of one that is stuck such a share of the echoes has one value, while it moved.
const STUCK: f64 = 0.97;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    let sonars = &of.facts.sonars;
    let is_lively = |sonar: &&SonarFacts| {
        stuck(of, sonar).is_none() && fraction(sonar.echoes, sonar.readings) > LIVELY
    };
    // Where few hear something there is little to hear.
    let are_lively = sonars.iter().filter(is_lively).count() * 2 > sonars.len();
    let silent: Vec<&SonarFacts> = sonars.iter().filter(|sonar| sonar.echoes == 0).collect();
    let mut usual: Vec<f64> = sonars.iter().filter_map(|sonar| sonar.median).collect();
    usual.sort_by(f64::total_cmp);
    let usual = median(&usual).unwrap_or(f64::INFINITY);
    let hears_so_far = |sonar: &&&SonarFacts| sonar.max_range > usual;
    let is_dead = are_lively
        && silent
            .iter()
            .filter(hears_so_far)
            .any(|sonar| sonar.readings >= ENOUGH);
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
        .filter_map(|sonar| Some((sonar, stuck(of, sonar)?)));
    let stuck = stuck.map(|(sonar, (range, share))| {
        let others = sonars.iter().filter(|other| other.id != sonar.id);
        let others: Vec<String> = others
            .map(|other| toml::Value::from(other.name.as_str()).to_string())
            .collect();
        let key = format!("input.sonars = [{}]", others.join(", "));
        let tried = of.tried(&key);
        Finding::new(
            Weight::Serious,
            "dead-sonar",
            format!(
                "sonar {}: {} of its echoes are {range:.3} m, wherever it is",
                sonar.name,
                percent(share)
            ),
            "its arcs are no echoes of anything",
            format!(
                "look at its wiring; leave it out: {key}{}",
                in_words(tried.as_ref())
            ),
        )
        .with(tried)
    });
    silent.into_iter().chain(stuck).collect()
}

/// The range at which a sonar is stuck, and the share of its echoes there.
fn stuck(of: &Examined<'_>, sonar: &SonarFacts) -> Option<(f64, f64)> {
    let odometry = of.facts.odometry.as_ref()?;
    let has_moved = odometry.distance > FAR && odometry.turning > PI;
    let (range, count) = sonar.commonest?;
    let share = fraction(count, sonar.echoes);
    let is_stuck = has_moved && sonar.echoes >= ENOUGH && share > STUCK;
    // What stands for no echo is no echo.
    let stands_in = || {
        stand_in::has_spike(&of.survey.log.events.readings, sonar)
            || stand_in::shared(&of.facts.sonars).is_some_and(|(value, ..)| value == range)
    };
    (is_stuck && !stands_in()).then_some((range, share))
}
