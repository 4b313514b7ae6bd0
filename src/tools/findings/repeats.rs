//! Echoes that are the sonar's last one again although it moved: a driver that publishes faster than the sonar
//! measures, or goes on with the last echo where nothing comes back.

use super::examined::{Examined, in_words};
use super::finding::{Finding, Weight, percent, which_sonars};
use super::sonar::between;
use super::sonars::SonarFacts;
use super::stand_in;

/// So many echoes of a moving sensor say how often they repeat ...
const ENOUGH: u64 = 20;
/// ... which is no chance for a sonar with a fine raster from this share on ...
const REPEATS: f64 = 0.1;
/// ... and for one with a coarse raster, which sees a wall beside it as the same for long, from this on.
const QUANTISED_REPEATS: f64 = 0.5;
/// Where more of the arcs is explained, repeats do no harm.
const EXPLAINED: f64 = 0.95;
/// A raster finer than this is fine, metres.
const FINE: f64 = 0.002;

const KEY: &str = "input.drop_repeats = true";

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let (readings, sonars) = (&of.survey.log.events.readings, &of.facts.sonars);
    let stands_in = |sonar: &SonarFacts| stand_in::has_spike(readings, sonar);
    let repeat = sonars
        .iter()
        .filter(|sonar| sonar.moved >= ENOUGH && sonar.repeated() > REPEATS && !stands_in(sonar));
    let repeating: Vec<&SonarFacts> = repeat.collect();
    if repeating.is_empty() || stand_in::shared(sonars).is_some() {
        return None;
    }
    let tried = of.tried(KEY);
    let told: Vec<&SonarFacts> = match tried {
        Some(_) => repeating,
        // A wall that is passed is as far all along it.
        None => repeating
            .into_iter()
            .filter(|sonar| repeats_too_often(sonar))
            .collect(),
    };
    let names: Vec<&str> = told.iter().map(|sonar| sonar.name.as_str()).collect();
    (!told.is_empty()).then(|| {
        // A wall that is passed without noise repeats, too, and is explained.
        let is_harmless = tried.is_none() && of.explained().is_some_and(|it| it.share > EXPLAINED);
        Finding::new(
            if is_harmless {
                Weight::Notable
            } else {
                Weight::Serious
            },
            "repeats",
            format!(
                "{}: {} of the echoes repeat the last one although the sensor moved",
                which_sonars(&names, sonars.len()),
                between(&told, SonarFacts::repeated, percent)
            ),
            "equal ranges from different places look like a wall along the path",
            match &tried {
                Some(_) => format!(
                    "set {KEY}{}; look whether the driver publishes faster than the sonar measures",
                    in_words(tried.as_ref())
                ),
                None => "look whether the driver publishes faster than the sonar measures; record only new readings"
                    .to_owned(),
            },
        )
        .with(tried)
    })
}

fn repeats_too_often(sonar: &SonarFacts) -> bool {
    let coarse = sonar
        .resolution
        .is_none_or(|r| r.quantised && r.step > FINE);
    let bound = if coarse { QUANTISED_REPEATS } else { REPEATS };
    sonar.republished() > bound
}
