//! Mounts that are off the robot, and sonars that are one and the same.

use super::examined::Examined;
use super::finding::{Finding, Weight, which_sonars};
use super::sonars::{MountFacts, SonarFacts};
use super::units::UNITS;
use crate::core::event::{Events, RangeReading, SonarId};
use crate::core::rounding::fixed;
use crate::core::statistics::fraction;

/// No sonar sits farther from the middle of its robot, metres.
const FARTHEST: f64 = 3.0;
/// Readings of two sonars that are no farther apart are of one instant, nanoseconds.
const AT_ONCE: i64 = 50_000_000;
/// Ranges of one sonar, raw and filtered, differ by less, metres.
const ALIKE: f64 = 0.02;
/// From this share of like ranges on, two sonars are one.
const MOST: f64 = 0.7;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    far(of).into_iter().chain(twice(of)).collect()
}

/// Mounts in millimetres, as CAD writes them.
fn far(of: &Examined<'_>) -> Option<Finding> {
    let sonars = &of.facts.sonars;
    let distance = |mount: MountFacts| libm::hypot(mount.x, mount.y);
    let is_far = |sonar: &&SonarFacts| sonar.mount.is_some_and(|mount| distance(mount) > FARTHEST);
    let far: Vec<&SonarFacts> = sonars.iter().filter(is_far).collect();
    let (first, mount) = far.first().and_then(|sonar| Some((*sonar, sonar.mount?)))?;
    let names: Vec<&str> = far.iter().map(|sonar| sonar.name.as_str()).collect();
    let transforms = of
        .facts
        .channels
        .iter()
        .filter(|c| c.used && c.role == Some("transform"));
    let of_static = transforms.filter(|channel| channel.topic.ends_with("tf_static"));
    let of_all = of_static.flat_map(|channel| {
        let section = toml::Value::from(channel.topic.as_str());
        UNITS.map(|(_, metres)| format!("channel.{section}.metres_per_unit = {metres}"))
    });
    let of_some = || {
        UNITS.map(|(_, metres)| {
            let keys = far.iter().filter_map(|sonar| {
                let (name, mount) = (toml::Value::from(sonar.name.as_str()), sonar.mount?);
                let [x, y] = [mount.x, mount.y].map(|place| fixed(place * metres, 4));
                Some(format!("sonar.{name}.x = {x}\nsonar.{name}.y = {y}"))
            });
            keys.collect::<Vec<_>>().join("\n")
        })
    };
    let keys = match far.len() == sonars.len() {
        true => of_all.collect(),
        false => of_some().to_vec(),
    };
    let tried = of.best(&keys);
    let advice = tried
        .as_ref()
        .map(|tried| format!("they seem to be in another unit: {}{tried}", tried.named()));
    Some(Finding::new(
        Weight::Serious,
        "far-mount",
        format!(
            "{} {} {:.1} m from the robot's origin ({} at x = {:.3} m, y = {:.3} m), off any robot",
            which_sonars(&names, sonars.len()),
            if names.len() == 1 { "sits" } else { "sit up to" },
            far.iter().filter_map(|sonar| sonar.mount).map(distance).fold(0.0, f64::max),
            first.name,
            mount.x,
            mount.y
        ),
        "a map from wrong mounts is wrong everywhere",
        advice.unwrap_or_else(|| {
            "transforms are in metres: does the robot's description have millimetres? Or give x, y and yaw under \
             [sonar.\"NAME\"]"
                .to_owned()
        }),
    )
    .with(tried))
}

/// Two topics of one sonar, as a driver's raw and filtered ranges.
fn twice(of: &Examined<'_>) -> Option<Finding> {
    let sonars = &of.facts.sonars;
    let pairs = sonars.iter().enumerate().flat_map(|(place, one)| {
        let behind = sonars.get(place + 1..).unwrap_or_default();
        behind.iter().map(move |other| (one, other))
    });
    let mut same = pairs.filter(|(one, other)| {
        one.mount.is_some()
            && one.mount == other.mount
            && are_alike(&of.survey.log.events, one.id, other.id)
    });
    let (one, other) = same.next()?;
    let more = match same.count() {
        0 => String::new(),
        n => format!(", and so do {n} more pairs"),
    };
    Some(Finding::new(
        Weight::Serious,
        "twice",
        format!(
            "{} and {} sit on one mount and measure the same{more}: one sonar on two topics",
            one.name, other.name
        ),
        "every echo counts twice, and the map seems surer than it is",
        format!(
            "leave one of them out with --range-topic: {} or {}",
            one.topic, other.topic
        ),
    ))
}

/// Whether two sonars measure the same at the same time.
pub fn are_alike(events: &Events, one: SonarId, other: SonarId) -> bool {
    let (mut last, mut beside, mut alike) = ([None; 2], 0, 0);
    for reading in events.readings.iter() {
        let Some(which) = [one, other].iter().position(|id| *id == reading.sonar) else {
            continue;
        };
        let [first, second] = &mut last;
        let (own, others): (&mut Option<RangeReading>, _) = match which {
            0 => (first, *second),
            _ => (second, *first),
        };
        *own = Some(reading);
        if let Some(last) = others
            && reading.range.is_finite()
            && reading.stamp_ns.saturating_sub(last.stamp_ns) <= AT_ONCE
        {
            beside += 1;
            alike += u64::from((reading.range - last.range).abs() < ALIKE);
        }
    }
    beside >= 20 && fraction(alike, beside) > MOST
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raw_and_filtered_ranges_are_alike_whichever_comes_first() {
        let reading = |k: i64, sonar: u16| RangeReading {
            stamp_ns: k * 500_000_000 + i64::from(sonar) * 5_000_000,
            sonar: SonarId(sonar),
            range: 1.0 + 0.05 * k as f64,
            min_range: 0.1,
            max_range: 9.0,
            beam_width: 0.4,
            variance: 0.0,
        };
        let events = Events {
            readings: (0..40)
                .flat_map(|k| [reading(k, 0), reading(k, 1)])
                .collect(),
            ..Events::default()
        };
        let (raw, filtered) = (SonarId(0), SonarId(1));
        assert!(are_alike(&events, raw, filtered) && are_alike(&events, filtered, raw));
    }
}
