//! Odometry that leaps: from one sample to the next farther than a robot drives.

use crate::core::event::{OdometrySample, RangeReading};

/// A robot with sonars does not drive faster, metres per second.
const TOO_FAST: f64 = 3.0;
/// A shorter leap is within what wheels do, metres.
const SHORT: f64 = 0.3;

/// Whether a way, metres, is too far for its time, seconds.
pub fn is_leap(distance: f64, seconds: f64) -> bool {
    distance > SHORT && distance > TOO_FAST * seconds
}

/// The samples, in stamp order, from `start` to `end` seconds after the first reading.
pub fn window<'a>(
    samples: &'a [OdometrySample],
    readings: &[RangeReading],
    start: Option<f64>,
    end: Option<f64>,
) -> &'a [OdometrySample] {
    let Some(first) = readings.first().map(|r| r.stamp_ns) else {
        return samples;
    };
    let after = |s: &OdometrySample| seconds(first, s.stamp_ns);
    let from = start.map_or(0, |start| samples.partition_point(|s| after(s) < start));
    let to = end.map_or(samples.len(), |end| {
        samples.partition_point(|s| after(s) <= end)
    });
    samples.get(from..to).unwrap_or_default()
}

/// Neighbours among samples in stamp order, but for those at times that the stamps were in twice: there
/// they are of two parts of the drive.
pub fn neighbours<'a>(
    samples: &'a [OdometrySample],
    twice: &'a [(i64, i64)],
) -> impl Iterator<Item = &'a [OdometrySample; 2]> {
    let is_mixed = move |stamp: i64| {
        twice
            .iter()
            .any(|(from, to)| (*from..=*to).contains(&stamp))
    };
    samples
        .array_windows()
        .filter(move |[a, b]| !is_mixed(a.stamp_ns) && !is_mixed(b.stamp_ns))
}

fn seconds(from_ns: i64, to_ns: i64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_does_not_drive_five_metres_between_two_samples() {
        assert!(is_leap(5.0, 0.1) && !is_leap(0.2, 0.01) && !is_leap(5.0, 2.0));
    }
}
