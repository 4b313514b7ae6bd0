//! Limits between which ranges do not lie: equal ones, zeros, those of another sonar, or in another unit than the
//! ranges (mit-aera/FlightGoggles#57, ros-simulation/gazebo_ros_pkgs#1158).

use std::collections::BTreeSet;

use super::distances::in_unit;
use super::examined::Examined;
use super::finding::{Finding, Weight, which_sonars};
use super::sonars::SonarFacts;
use super::stamps::used;
use super::units::UNITS;
use crate::core::event::{RangeReading, Return};
use crate::core::statistics::fraction;

/// A sonar that measures has so many values beyond its limits ...
const ENOUGH: usize = 20;
/// ... and such a share of its ranges.
const MANY: f64 = 0.1;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let sonars = &of.facts.sonars;
    let readings = &of.survey.log.events.readings;
    let measured = |reading: &RangeReading| reading.range.is_finite() && reading.range > 0.0;
    let is_wrong = |sonar: &&SonarFacts| {
        let (mut all, mut beyond, mut values) = (0, 0, BTreeSet::new());
        for reading in readings.of_sonar(sonar.id).filter(measured) {
            all += 1;
            if reading.classify() != Return::Echo {
                beyond += 1;
                if values.len() < ENOUGH {
                    values.insert(reading.range.to_bits());
                }
            }
        }
        let is_beyond = values.len() >= ENOUGH && fraction(beyond, all) > MANY;
        sonar.limits_are_senseless() || is_beyond
    };
    let wrong: Vec<&SonarFacts> = sonars.iter().filter(is_wrong).collect();
    let first = *wrong.first()?;
    let names: Vec<&str> = wrong.iter().map(|sonar| sonar.name.as_str()).collect();
    let mut ranges: Vec<f64> = readings
        .iter()
        .filter(measured)
        .map(|reading| reading.range)
        .collect();
    ranges.sort_by(f64::total_cmp);
    let (nearest, farthest) = (*ranges.first()?, *ranges.last()?);
    // A value that is there again and again at the end stands for no echo.
    let at_end = ranges.len() - ranges.partition_point(|range| *range < farthest);
    let is_stand_in = fraction(at_end as u64, ranges.len() as u64) > MANY;
    let limits = |metres: f64| {
        let end = farthest * metres * if is_stand_in { 0.999 } else { 1.02 };
        format!(
            "sonars.min_range = {}\nsonars.max_range = {}",
            rounded(nearest * metres * 0.9, libm::floor),
            rounded(end, if is_stand_in { libm::floor } else { libm::ceil })
        )
    };
    let topics: Vec<&str> = used(of.facts, "range").map(|c| c.topic.as_str()).collect();
    let scaled = UNITS.iter().flat_map(|(_, metres)| {
        let keys = in_unit(of, &topics, *metres).into_iter();
        keys.map(|keys| format!("{keys}\n{}", limits(*metres)))
    });
    let tried = of.best(
        &std::iter::once(limits(1.0))
            .chain(scaled)
            .collect::<Vec<_>>(),
    );
    if tried.is_none() && first.echoes > 0 && !first.limits_are_senseless() {
        return None;
    }
    Some(
        Finding::new(
            Weight::Serious,
            "limits",
            format!(
                "{}: ranges from {nearest:.2} to {farthest:.2} m do not lie between min_range {} m and max_range {} m",
                which_sonars(&names, sonars.len()),
                first.min_range as f32,
                first.max_range as f32
            ),
            "what lies beyond them counts as no echo or as invalid",
            match &tried {
                Some(tried) => format!("set {}{tried}; mend the limits in the driver", tried.named()),
                None => "set sonars.min_range and sonars.max_range from the data sheet".to_owned(),
            },
        )
        .with(tried),
    )
}

/// To the millimetre, in the direction of `to`.
fn rounded(metres: f64, to: fn(f64) -> f64) -> f64 {
    to(metres * 1000.0) / 1000.0
}
