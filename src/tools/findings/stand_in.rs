//! Values that stand for no echo and are taken for echoes: 0.0, a cap below max_range, max_range with noise on it
//! (DFRobot/pxt-maqueen#7, purduesigbots/pros#32).

use super::examined::{Examined, Tried, in_words};
use super::finding::{Finding, Weight, percent, which_sonars};
use super::sonars::SonarFacts;
use crate::core::event::{Readings, Return};
use crate::core::statistics::{fraction, median};

/// So many echoes of a sonar are enough to see a spike.
const ENOUGH: usize = 40;
/// A spike holds at least this share of the echoes.
const SPIKE: f64 = 0.1;
/// The values in it lie no farther apart than this share of them.
const WIDTH: f64 = 0.01;
/// So many sonars with one farthest value have no walls there.
const SEVERAL: usize = 3;
/// A spike holds so many times as many echoes as lie as near to each other elsewhere.
const TIMES: f64 = 6.0;

/// A value that stands for no echo.
#[derive(Clone, Copy)]
pub enum StandIn {
    /// Nothing is nearer; the smallest and the largest of its values.
    Nearest([f64; 2]),
    /// Nothing is farther; the smallest of its values.
    Farthest(f64),
    /// One and the same value of several sonars.
    Same(f64),
}

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    at_an_end(of)
        .into_iter()
        .chain(same_of_several(of))
        .min_by(|a, b| {
            let bits = |finding: &Finding| {
                finding
                    .tried
                    .as_ref()
                    .map_or(f64::INFINITY, |it| it.with.bits)
            };
            bits(a).total_cmp(&bits(b))
        })
}

fn at_an_end(of: &Examined<'_>) -> Option<Finding> {
    let readings = &of.survey.log.events.readings;
    let ends = of.facts.sonars.iter().filter_map(|sonar| {
        let end = end(readings, sonar)?;
        Some((sonar, end))
    });
    let ends: Vec<(&SonarFacts, End)> = ends.collect();
    // Walls lie at other distances from each sonar; a cap with noise on it does not.
    let is_shared = |end: &End| {
        let alike = ends.iter().filter(|(_, other)| end.is_like(other));
        alike.count() >= SEVERAL
    };
    let spikes = ends.iter().filter(|(_, end)| end.is_sure || is_shared(end));
    let spikes = spikes.map(|(sonar, end)| (*sonar, end.stand_in, end.count));
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
        StandIn::Nearest([value, largest]) => {
            let above = spikes.iter().filter_map(|(_, spike, _)| match spike {
                StandIn::Nearest([_, largest]) => Some(*largest),
                StandIn::Farthest(_) | StandIn::Same(_) => None,
            });
            let above = above.fold(*largest, f64::max) + 0.01;
            (*value, format!("sonars.min_range = {}", thousandths(above)))
        }
        StandIn::Farthest(value) | StandIn::Same(value) => {
            let below = spikes.iter().filter_map(|(_, spike, _)| match spike {
                StandIn::Farthest(value) => Some(*value),
                StandIn::Nearest(_) | StandIn::Same(_) => None,
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
    Some(told(of, *first, value, &names, share, &key, tried))
}

/// A value that several sonars have to the bit, wherever they are (a byte of 255 cm, a library's 400 cm).
fn same_of_several(of: &Examined<'_>) -> Option<Finding> {
    let (value, sonars, count) = shared(&of.facts.sonars)?;
    let echoes = sonars.iter().map(|sonar| sonar.echoes).sum();
    let names: Vec<&str> = sonars.iter().map(|sonar| sonar.name.as_str()).collect();
    let key = format!("sonars.no_echo = {}", thousandths(value));
    let tried = of.tried(&key)?;
    let share = fraction(count, echoes);
    Some(told(
        of,
        StandIn::Same(value),
        value,
        &names,
        share,
        &key,
        Some(tried),
    ))
}

/// The commonest value of a sonar that others have as often, these sonars, and how many echoes have it.
pub fn shared(sonars: &[SonarFacts]) -> Option<(f64, Vec<&SonarFacts>, u64)> {
    let common = |sonar: &SonarFacts| {
        let (value, count) = sonar.commonest?;
        (sonar.echoes >= ENOUGH as u64 && fraction(count, sonar.echoes) > SPIKE)
            .then_some((value, count))
    };
    let of_value = |value: f64| {
        let sharing = sonars
            .iter()
            .filter(|sonar| common(sonar).is_some_and(|(other, _)| other == value));
        let sharing: Vec<&SonarFacts> = sharing.collect();
        let count = sharing
            .iter()
            .filter_map(|sonar| common(sonar))
            .map(|(_, count)| count)
            .sum();
        (value, sharing, count)
    };
    let all = sonars
        .iter()
        .filter_map(common)
        .map(|(value, _)| of_value(value));
    let most = all.max_by_key(|(_, sharing, _)| sharing.len())?;
    (most.1.len() > 1).then_some(most)
}

fn told(
    of: &Examined<'_>,
    stand_in: StandIn,
    value: f64,
    names: &[&str],
    share: f64,
    key: &str,
    tried: Option<Tried>,
) -> Finding {
    let came_of = in_words(tried.as_ref());
    Finding::new(
        Weight::Serious,
        "stand-in",
        format!(
            "{}: {} of {} echoes lie at {value:.3} m{}, where so many cannot be: the driver writes that when nothing \
             echoes",
            which_sonars(names, of.facts.sonars.len()),
            percent(share),
            if names.len() == 1 { "its" } else { "their" },
            match stand_in {
                StandIn::Nearest([value, largest]) if largest - value > 0.001 =>
                    " or a little more, nearer than all others",
                StandIn::Nearest(_) => ", nearer than all others",
                StandIn::Farthest(_) => " or a little more, farther than all others",
                StandIn::Same(_) => " to the bit",
            }
        ),
        "what is no echo becomes arcs, and walls that are not there",
        format!("set {key}{came_of}; the driver should write +inf"),
    )
    .with(tried)
}

fn thousandths(metres: f64) -> f64 {
    libm::round(metres * 1000.0) / 1000.0
}

/// A spike at the end of a sonar's histogram.
struct End {
    stand_in: StandIn,
    /// Echoes in it.
    count: usize,
    /// Whether one sonar alone shows that it is no wall.
    is_sure: bool,
}

impl End {
    /// Whether both are the farthest values, and these are the same.
    fn is_like(&self, other: &Self) -> bool {
        match (self.stand_in, other.stand_in) {
            (StandIn::Farthest(own), StandIn::Farthest(other)) => (own - other).abs() < WIDTH * own,
            _ => false,
        }
    }
}

/// Whether a spike at the end of a sonar's histogram stands for no echo.
pub fn has_spike(readings: &Readings, sonar: &SonarFacts) -> bool {
    end(readings, sonar).is_some_and(|end| end.is_sure)
}

fn end(readings: &Readings, sonar: &SonarFacts) -> Option<End> {
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
        let largest = ranges
            .iter()
            .copied()
            .rfind(|range| *range <= low + width)?;
        return Some(End {
            stand_in: StandIn::Nearest([low, largest]),
            count: nearest,
            is_sure: true,
        });
    }
    let farthest = within(high - width, high);
    let is_exact = ranges.iter().filter(|range| **range == high).count() * 2 > farthest;
    let is_sure = is_exact || (sonar.max_range.is_finite() && high > 0.98 * sonar.max_range);
    // Noise has tails.
    let wide = if is_exact { width } else { 2.0 * width };
    let from = ranges.iter().copied().find(|range| *range >= high - wide)?;
    (is_spike(farthest) && beside(high - 3.0 * width, high - width, farthest)).then_some(End {
        stand_in: StandIn::Farthest(from),
        count: farthest,
        is_sure,
    })
}
