//! What is odd about the stamps of a log: clocks that were set or do not agree, stamps that go back or
//! come twice, readings that no odometry covers.

mod clock;
mod set;
#[cfg(test)]
mod tests;

pub use clock::Clock;
pub use set::{ClockSet, jump, returned};

use crate::core::config::Frames;
use crate::core::event::{OdometrySample, RangeReading};
use crate::core::wording::{counted, seconds_between};

/// So much more or less delay of the ranges than of the odometry is worth a word, nanoseconds.
const SKEW: i64 = 100_000_000;
/// From this share of readings without a pose on, a word is worth it even if nothing was interrupted.
const SHARE: f64 = 0.01;

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

/// Ranges and odometry that are under way for different times.
pub fn skew(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let of_ranges = median(ranges.iter().flat_map(|clock| &clock.delays))?;
    let of_odometry = median(odometry.delays.iter())?;
    (of_ranges.saturating_sub(of_odometry).saturating_abs() > SKEW).then(|| {
        format!(
            "from stamp to recording ranges take {:.3} s and odometry {:.3} s: if their clocks differ, \
             readings meet the poses of another time",
            seconds(of_ranges),
            seconds(of_odometry)
        )
    })
}

fn median<'a>(delays: impl Iterator<Item = &'a i64>) -> Option<i64> {
    let mut delays: Vec<i64> = delays.copied().collect();
    delays.sort_unstable();
    delays.get(delays.len() / 2).copied()
}

/// Stamps that go back otherwise than by a clock that was set, which is told by itself.
pub fn backward(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let of_ranges: u64 = ranges.iter().map(|clock| clock.backward).sum();
    let all = || ranges.iter().copied().chain([odometry]);
    if all().all(|clock| clock.backward == clock.turned.len() as u64) {
        return None;
    }
    let farthest = all().map(|clock| clock.farthest_back).min()?;
    (farthest < 0).then(|| {
        format!(
            "messages that are stamped earlier than the one before them: {of_ranges} of ranges, {} of \
             odometry, by up to {:.3} s; all are taken in the order of their stamps",
            odometry.backward,
            seconds(farthest.saturating_neg())
        )
    })
}

/// Readings with the stamp of another one of their sonar; they are in stamp order.
pub fn twins(readings: &[RangeReading]) -> Option<String> {
    let count = readings
        .windows(2)
        .filter(|pair| matches!(pair, [a, b] if (a.stamp_ns, a.sonar) == (b.stamp_ns, b.sonar)))
        .count();
    (count > 0).then(|| {
        format!(
            "{count} of {} {} the stamp of another one of the same sonar: a driver that \
             publishes twice, or messages that were recorded twice",
            counted(readings.len() as u64, "reading"),
            if count == 1 { "carries" } else { "carry" }
        )
    })
}

/// Readings that have no pose, where they are many or the odometry was interrupted. Both in stamp
/// order.
pub fn uncovered(
    readings: &[RangeReading],
    samples: &[OdometrySample],
    bounds: &Frames,
) -> Option<String> {
    let (first, last) = (samples.first()?.stamp_ns, samples.last()?.stamp_ns);
    let up_to = |stamp: i64| readings.partition_point(|r| r.stamp_ns <= stamp);
    let below = |stamp: i64| readings.partition_point(|r| r.stamp_ns < stamp);
    let beyond = libm::round(bounds.max_extrapolation * 1e9) as i64;
    let before = below(first.saturating_sub(beyond));
    let after = readings.len() - up_to(last.saturating_add(beyond));
    let (mut gaps, mut within, mut longest) = (0_u64, 0, (0.0, 0));
    for pair in samples.windows(2) {
        let [a, b] = pair else { continue };
        let width = seconds(b.stamp_ns.saturating_sub(a.stamp_ns));
        let lost = below(b.stamp_ns).saturating_sub(up_to(a.stamp_ns));
        if width > bounds.max_odometry_gap && lost > 0 {
            gaps += 1;
            within += lost;
            if width > longest.0 {
                longest = (width, a.stamp_ns);
            }
        }
    }
    let lost = before + after + within;
    if gaps == 0 && lost as f64 <= SHARE * readings.len() as f64 {
        return None;
    }
    let mut parts = Vec::new();
    if before > 0 {
        parts.push(format!("{before} before the first odometry sample"));
    }
    if after > 0 {
        parts.push(format!("{after} after the last odometry sample"));
    }
    if gaps > 0 {
        let start = readings.first()?.stamp_ns;
        parts.push(format!(
            "{within} in {} of the odometry wider than {} s, the longest {:.1} s at {} s",
            counted(gaps, "gap"),
            bounds.max_odometry_gap,
            longest.0,
            seconds_between(start, longest.1, 1)
        ));
    }
    Some(format!(
        "{lost} of {} {} no pose and {} dropped: {}",
        counted(readings.len() as u64, "reading"),
        if lost == 1 { "has" } else { "have" },
        if lost == 1 { "is" } else { "are" },
        parts.join(", ")
    ))
}
