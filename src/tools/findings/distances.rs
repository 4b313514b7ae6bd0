//! Ranges in another unit or scale (OpenRoberta/robertalab#788, ArduPilot/ardupilot#19323, utexas-bwi/segbot#22).

use super::examined::{Examined, Tried};
use super::finding::{Finding, Weight, which_sonars};
use super::heading::against_speeds;
use super::sonars::SonarFacts;
use super::stamps::used;
use super::units::UNITS;

/// A driver that forgets, or twice makes, the way there and back; one in metres that is scaled as if it were not.
const SCALES: [f64; 4] = [0.5, 2.0, 100.0, 1000.0];
/// A sonar in the air reaches no farther, metres.
const FARTHEST: f64 = 50.0;
/// Half of its echoes are nearer, metres.
const MIDDLE: f64 = 15.0;
/// Where a map explains more of the arcs, the scale is right.
const WELL: f64 = 0.6;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    units(of).or_else(|| scale(of)).into_iter().collect()
}

fn units(of: &Examined<'_>) -> Option<Finding> {
    let sonars = &of.facts.sonars;
    let is_long = |sonar: &&SonarFacts| {
        sonar.median.is_some_and(|median| median > MIDDLE)
            && (sonar.median > Some(FARTHEST)
                || (sonar.max_range.is_finite() && sonar.max_range > FARTHEST))
    };
    let long: Vec<&SonarFacts> = sonars.iter().filter(is_long).collect();
    let nearest = long.iter().filter_map(|sonar| sonar.median);
    let nearest = nearest.reduce(f64::min)?;
    let limits = long.iter().map(|sonar| sonar.max_range);
    let limit = limits.fold(f64::INFINITY, f64::min);
    let names: Vec<&str> = long.iter().map(|sonar| sonar.name.as_str()).collect();
    // Where some are otherwise, only these are scaled.
    let topics: Vec<&str> = match 2 * long.len() > sonars.len() {
        true => used(of.facts, "range").map(|c| c.topic.as_str()).collect(),
        false => long.iter().map(|sonar| sonar.topic.as_str()).collect(),
    };
    let tried = best(of, &topics, &UNITS.map(|(_, metres)| metres));
    let unit = tried.as_ref().and_then(|tried| {
        let mut units = UNITS.iter();
        units.find(|(_, metres)| is_meant(of, &topics, *metres, tried))
    });
    let advice = tried
        .as_ref()
        .zip(unit)
        .map(|(tried, (unit, _))| format!("they seem to be in {unit}: {}{tried}", tried.named()));
    Some(
        Finding::new(
            Weight::Serious,
            "units",
            format!(
                "{}: half of the echoes are farther than {nearest:.0} m{}: no sonar in the air reaches so far",
                which_sonars(&names, sonars.len()),
                match limit.is_finite() {
                    true => format!(", and max_range is {} m or more", limit as f32),
                    false => String::new(),
                }
            ),
            "the map is as much too large",
            advice.unwrap_or_else(|| {
                "ranges are metres: does the driver write centimetres or millimetres? [channel.\"/topic\"] \
                 metres_per_unit = 0.01 scales them"
                    .to_owned()
            }),
        )
        .with(tried),
    )
}

/// Another unit that no range gives away, or half or twice the true distance.
fn scale(of: &Examined<'_>) -> Option<Finding> {
    let explained = of.explained()?;
    // Poses in another unit ask for ranges in the same one.
    if explained.share > WELL || of.is_long() || against_speeds(of).is_some() {
        return None;
    }
    let topics: Vec<&str> = used(of.facts, "range").map(|c| c.topic.as_str()).collect();
    let units = UNITS.iter().map(|(_, metres)| *metres);
    let factors: Vec<f64> = SCALES.into_iter().chain(units).collect();
    let tried = best(of, &topics, &factors).filter(|tried| tried.with.share > WELL)?;
    let factor = factors
        .iter()
        .find(|factor| is_meant(of, &topics, **factor, &tried))?;
    let unit = UNITS.iter().find(|(_, metres)| metres == factor);
    Some(
        Finding::new(
            Weight::Serious,
            "scale",
            format!(
                "the map explains {:.0} % of the arcs; with all ranges multiplied by {factor} it explains more",
                100.0 * explained.share
            ),
            "walls lie where they are not, and those that are seen from two places do not join",
            match unit {
                Some((unit, _)) => format!("does the driver write {unit}? {}{tried}", tried.named()),
                None => format!(
                    "does the driver mend the way there and back? Until then {}{tried}",
                    tried.named()
                ),
            },
        )
        .with(Some(tried)),
    )
}

/// The keys that scale ranges so that most of the log is explained.
fn best(of: &Examined<'_>, topics: &[&str], factors: &[f64]) -> Option<Tried> {
    let keys: Vec<String> = (factors.iter())
        .flat_map(|factor| in_unit(of, topics, *factor))
        .collect();
    of.best(&keys)
}

/// Whether these are the keys of a factor.
fn is_meant(of: &Examined<'_>, topics: &[&str], factor: f64, tried: &Tried) -> bool {
    in_unit(of, topics, factor).contains(&tried.keys)
}

/// The keys that scale the ranges on topics, with their variance and without it: a driver that forgets the unit of the
/// one may know that of the other.
pub fn in_unit(of: &Examined<'_>, topics: &[&str], metres_per_unit: f64) -> Vec<String> {
    let keys = keys(of, topics, metres_per_unit);
    let mut readings = of.survey.log.events.readings.iter();
    let has_variance = readings.any(|reading| reading.variance > 0.0);
    let without = format!("{keys}\nnoise.trust_variance = false");
    std::iter::once(keys)
        .chain(has_variance.then_some(without))
        .collect()
}

/// The keys that scale the ranges on topics: one for the folder of them, where no others are in it.
fn keys(of: &Examined<'_>, topics: &[&str], metres_per_unit: f64) -> String {
    let key = |topic: &str| {
        let topic = toml::Value::from(topic);
        format!("channel.{topic}.metres_per_unit = {metres_per_unit}")
    };
    match folder(of, topics) {
        Some(pattern) => key(&pattern),
        None => topics
            .iter()
            .map(|topic| key(topic))
            .collect::<Vec<_>>()
            .join("\n"),
    }
}

/// The pattern of all topics in the folder of these, where no others are in it.
fn folder(of: &Examined<'_>, topics: &[&str]) -> Option<String> {
    let [first, _, ..] = topics else { return None };
    let (folder, _) = first.rsplit_once('/')?;
    let is_in = |topic: &str| topic.starts_with(&format!("{folder}/"));
    let others = of
        .facts
        .channels
        .iter()
        .filter(|c| !topics.contains(&c.topic.as_str()));
    let is_alone =
        topics.iter().all(|topic| is_in(topic)) && !others.into_iter().any(|c| is_in(&c.topic));
    is_alone.then(|| format!("{folder}/*"))
}
