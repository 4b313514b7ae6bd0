//! What is odd about the stamps of a log: clocks that were set or do not agree, stamps that go back or
//! come twice, readings that no odometry covers.

mod clock;
#[cfg(test)]
mod tests;

pub use clock::Clock;

use crate::config::Frames;
use crate::event::{OdometrySample, RangeReading};
use clock::JUMP;

/// Parts of one log in another order leave no such hole between them, nanoseconds.
const HOLE: i64 = 10_000_000_000;
/// So much more or less delay of the ranges than of the odometry is worth a word, nanoseconds.
const SKEW: i64 = 100_000_000;
/// From this share of readings without a pose on, a word is worth it even if nothing was interrupted.
const SHARE: f64 = 0.01;

/// Stamps that went back together with the time of recording, to times that the log had been through
/// or far before them.
pub fn returned(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let clocks = || ranges.iter().copied().chain([odometry]);
    let overlap = clocks().map(|clock| clock.overlap_and_hole().0).max()?;
    let hole = clocks().map(|clock| clock.overlap_and_hole().1).max()?;
    let returns = clocks().map(|clock| clock.returns).max()?;
    let farthest = seconds(clocks().map(|clock| clock.farthest_return).max()?);
    let times = if returns == 1 {
        "once".to_owned()
    } else {
        format!("{returns} times")
    };
    if overlap > JUMP {
        return Some(format!(
            "the clock was set back while the log was recorded, {times}, by up to {farthest:.3} s: stamps and times \
             of recording were twice at {:.3} s of the log, and readings from before and after meet each \
             other's poses{}",
            seconds(overlap),
            around(ranges, odometry).unwrap_or_default()
        ));
    }
    (hole > HOLE).then(|| {
        format!(
            "stamps and times of recording go back together, {times}, by up to {farthest:.3} s, and leave a hole of \
             {:.3} s: the clock was set back, or two logs were put together",
            seconds(hole)
        )
    })
}

/// How to replay what lies before and behind the times that were twice, where it was one stretch.
fn around(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let first = |clock: &&Clock| clock.runs.iter().map(|(first, _)| *first).min();
    let start = ranges.iter().filter_map(first).min()?;
    let (mut from, mut to) = (i64::MAX, i64::MIN);
    for clock in ranges.iter().copied().chain([odometry]) {
        match clock.runs.as_slice() {
            [_] => {}
            [(a, b), (c, d)] if c < b && a < d => {
                from = from.min(*a.max(c));
                to = to.max(*b.min(d));
            }
            _ => return None,
        }
    }
    // In tenths of a second that do not touch it.
    let tenths = |ns: i64| seconds(ns.saturating_sub(start)) * 10.0;
    let before = (libm::ceil(tenths(from)) - 1.0) / 10.0;
    let behind = (libm::floor(tenths(to)) + 1.0) / 10.0;
    Some(if before > 0.0 {
        format!(
            "; --end {before:.1} replays what lies before these times, --start {behind:.1} what lies behind"
        )
    } else {
        format!("; --start {behind:.1} replays what lies behind these times")
    })
}

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

/// Clocks that were set while the log was recorded.
pub fn jump(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let all = || ranges.iter().copied().chain([odometry]);
    let (by, logged) = all()
        .filter_map(|clock| clock.largest)
        .max_by_key(|(by, logged)| (by.unsigned_abs(), std::cmp::Reverse(*logged)))?;
    let start = all().filter_map(|clock| clock.first_logged).min()?;
    let sonars = ranges.iter().filter(|clock| clock.jumps > 0).count();
    let whose = match (sonars, odometry.jumps > 0) {
        (0, _) => "the odometry".to_owned(),
        (n, false) => format!("{n} of {} sonars", ranges.len()),
        (n, true) => format!("{n} of {} sonars and of the odometry", ranges.len()),
    };
    Some(format!(
        "the clock that stamps the messages of {whose} was set while they were recorded: by {:+.3} s, {:.3} s \
         after the first message. What lies before and behind it does not fit together in time",
        seconds(by),
        seconds(logged.saturating_sub(start))
    ))
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

/// Stamps that go back.
pub fn backward(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let of_ranges: u64 = ranges.iter().map(|clock| clock.backward).sum();
    let all = || ranges.iter().copied().chain([odometry]);
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
            "{count} of {} readings carry the stamp of another one of the same sonar: a driver that \
             publishes twice, or messages that were recorded twice",
            readings.len()
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
            "{within} in {gaps} {} of the odometry wider than {} s, the longest {:.1} s at {:.1} s",
            if gaps == 1 { "gap" } else { "gaps" },
            bounds.max_odometry_gap,
            longest.0,
            seconds(longest.1.saturating_sub(start))
        ));
    }
    Some(format!(
        "{lost} of {} readings have no pose and are dropped: {}",
        readings.len(),
        parts.join(", ")
    ))
}
