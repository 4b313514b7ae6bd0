//! Ranges in another unit or scale (OpenRoberta/robertalab#788, ArduPilot/ardupilot#19323, utexas-bwi/segbot#22).

use super::examined::Examined;
use super::finding::{Finding, Weight, which_sonars};
use super::sonars::SonarFacts;

/// A sonar in the air reaches no farther, metres.
const FARTHEST: f64 = 50.0;
/// Half of its echoes are nearer, metres.
const MIDDLE: f64 = 15.0;
/// Where a map explains more of the arcs, the scale is right.
const WELL: f64 = 0.6;
/// Longer logs are not replayed to try scales.
const LONGEST: usize = 200_000;

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
    let medians = long.iter().filter_map(|sonar| sonar.median);
    let (nearest, limit) = (
        medians.reduce(f64::min)?,
        long.iter()
            .map(|sonar| sonar.max_range)
            .fold(f64::INFINITY, f64::min),
    );
    let names: Vec<&str> = long.iter().map(|sonar| sonar.name.as_str()).collect();
    let tried = [("centimetres", 0.01), ("millimetres", 0.001)]
        .into_iter()
        .find_map(|(unit, metres)| {
            Some(format!(
                "they seem to be in {unit}: {}",
                tried(of, metres, 0.0)?
            ))
        });
    Some(Finding::new(
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
        tried.unwrap_or_else(|| {
            "ranges are metres: does the driver write centimetres or millimetres? [channel.\"/topic\"] \
             metres_per_unit = 0.01 scales them"
                .to_owned()
        }),
    ))
}

/// Half or twice the true distance: a driver that forgets, or twice makes, the way there and back.
fn scale(of: &Examined<'_>) -> Option<Finding> {
    let explained = of.explained()?;
    if explained.share > WELL || of.survey.log.events.readings.len() > LONGEST {
        return None;
    }
    let (factor, tried) = [2.0, 0.5]
        .into_iter()
        .find_map(|factor| Some((factor, tried(of, factor, WELL)?)))?;
    Some(Finding::new(
        Weight::Serious,
        "scale",
        format!(
            "the map explains {:.0} % of the arcs; with all ranges multiplied by {factor} it explains more",
            100.0 * explained.share
        ),
        "walls lie where they are not, and those that are seen from two places do not join",
        format!("does the driver mend the way there and back? Until then {tried}"),
    ))
}

/// The key that scales all ranges, where it makes more of the log, and at least such a share is explained.
fn tried(of: &Examined<'_>, metres_per_unit: f64, least: f64) -> Option<String> {
    let ranges = of
        .facts
        .channels
        .iter()
        .filter(|c| c.used && c.role == Some("range"));
    let topics: Vec<&str> = ranges.map(|channel| channel.topic.as_str()).collect();
    let keys = match folder(of, &topics) {
        Some(pattern) => vec![key(&pattern, metres_per_unit)],
        None => topics
            .iter()
            .map(|topic| key(topic, metres_per_unit))
            .collect(),
    };
    let tried = of.tried_for(least, &keys.join("\n"))?;
    Some(format!("{}{tried}", keys.join(", ")))
}

fn key(topic: &str, metres_per_unit: f64) -> String {
    format!(
        "channel.{}.metres_per_unit = {metres_per_unit}",
        toml::Value::from(topic)
    )
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
