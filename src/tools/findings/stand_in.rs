//! Values that stand for no echo and are taken for echoes: 0.0, a cap below max_range, max_range with noise on it
//! (DFRobot/pxt-maqueen#7, purduesigbots/pros#32).

use super::examined::Examined;
use super::finding::{Finding, Weight, percent, which_sonars};
use super::sonars::SonarFacts;
use crate::core::event::{RangeReading, Return};
use crate::core::statistics::{fraction, median};

/// So many echoes of a sonar are enough to see a spike.
const ENOUGH: usize = 40;
/// A spike holds at least this share of the echoes.
const SPIKE: f64 = 0.1;
/// The values in it lie no farther apart than this share of them.
const WIDTH: f64 = 0.01;
/// A spike holds so many times as many echoes as lie as near to each other elsewhere.
const TIMES: f64 = 6.0;

/// A value that stands for no echo.
#[derive(Clone, Copy)]
pub enum StandIn {
    /// Nothing is nearer.
    Nearest(f64),
    /// Nothing is farther; the smallest of its values.
    Farthest(f64),
}

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let readings = &of.survey.log.events.readings;
    let spikes = of.facts.sonars.iter().filter_map(|sonar| {
        let (stand_in, count) = spike(readings, sonar)?;
        Some((sonar, stand_in, count))
    });
    let spikes: Vec<(&SonarFacts, StandIn, usize)> = spikes.collect();
    let (_, first, _) = spikes.first()?;
    let in_spikes = spikes.iter().map(|(_, _, count)| *count as u64).sum();
    let echoes = spikes.iter().map(|(sonar, ..)| sonar.echoes).sum();
    let share = fraction(in_spikes, echoes);
    let names: Vec<&str> = spikes
        .iter()
        .map(|(sonar, ..)| sonar.name.as_str())
        .collect();
    let (value, key) = match first {
        StandIn::Nearest(value) => {
            let above = spikes.iter().filter_map(|(_, spike, _)| match spike {
                StandIn::Nearest(value) => Some(*value),
                StandIn::Farthest(_) => None,
            });
            let above = above.fold(*value, f64::max) + 0.01;
            (*value, format!("sonars.min_range = {}", thousandths(above)))
        }
        StandIn::Farthest(value) => {
            let below = spikes.iter().filter_map(|(_, spike, _)| match spike {
                StandIn::Farthest(value) => Some(*value),
                StandIn::Nearest(_) => None,
            });
            let below = below.fold(*value, f64::min) - 0.001;
            (*value, format!("sonars.max_range = {}", thousandths(below)))
        }
    };
    let tried = of.tried(&key);
    // A wall beside the way is as far all along it where there is no noise: a map without it explains less.
    if tried.is_none() && matches!(first, StandIn::Farthest(_)) && of.explained().is_some() {
        return None;
    }
    let tried = tried.unwrap_or_default();
    Some(Finding::new(
        Weight::Serious,
        "stand-in",
        format!(
            "{}: {} of their echoes lie at {value:.3} m{}, where so many cannot be: the driver writes that when nothing \
             echoes",
            which_sonars(&names, of.facts.sonars.len()),
            percent(share),
            match first {
                StandIn::Nearest(_) => ", nearer than all others",
                StandIn::Farthest(_) => " or a little more, farther than all others",
            }
        ),
        "what is no echo becomes arcs, and walls that are not there",
        format!("set {key}{tried}; the driver should write +inf"),
    ))
}

fn thousandths(metres: f64) -> f64 {
    libm::round(metres * 1000.0) / 1000.0
}

/// A spike at the end of a sonar's histogram, and how many echoes are in it.
pub fn spike(readings: &[RangeReading], sonar: &SonarFacts) -> Option<(StandIn, usize)> {
    let of_sonar = readings.iter().filter(|reading| reading.sonar == sonar.id);
    let echoes = of_sonar.filter(|reading| reading.classify() == Return::Echo);
    let mut ranges: Vec<f64> = echoes.map(|reading| reading.range).collect();
    ranges.sort_by(f64::total_cmp);
    let (low, high) = (*ranges.first()?, *ranges.last()?);
    let middle = median(&ranges)?;
    let width = WIDTH * middle.max(high / 2.0);
    let within = |from: f64, to: f64| {
        let end = ranges.partition_point(|range| *range <= to);
        end.saturating_sub(ranges.partition_point(|range| *range < from))
    };
    let usual = ranges.len() as f64 * width / (high - low).max(width);
    let is_spike = |count: usize| {
        let share = fraction(count as u64, ranges.len() as u64);
        share > SPIKE && count as f64 > TIMES * usual
    };
    if ranges.len() < ENOUGH || high - low < 10.0 * width {
        return None;
    }
    // A wall that is passed fills the neighbourhood as well; a stand-in leaves it empty.
    let beside = |from: f64, to: f64, count: usize| 10 * within(from, to) < count;
    let nearest = within(low, low + width);
    if is_spike(nearest) && low <= 0.05 && beside(low + width, low + 3.0 * width, nearest) {
        return Some((StandIn::Nearest(low), nearest));
    }
    let farthest = within(high - width, high);
    let is_cap = ranges.iter().filter(|range| **range == high).count() * 2 > farthest
        || (sonar.max_range.is_finite() && high > 0.98 * sonar.max_range);
    let from = ranges
        .iter()
        .copied()
        .find(|range| *range >= high - width)?;
    (is_spike(farthest) && is_cap && beside(high - 3.0 * width, high - width, farthest))
        .then_some((StandIn::Farthest(from), farthest))
}
