//! Odometry that leaps: from one sample to the next farther than a robot drives.

use crate::core::event::{OdometrySample, RangeReading};
use crate::core::wording::{seconds_between, times};

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

/// What is told of samples in stamp order that leap; times count from the first reading.
pub fn note(
    samples: &[OdometrySample],
    readings: &[RangeReading],
    twice: &[(i64, i64)],
) -> Option<String> {
    let mut count = 0_u64;
    let mut largest: Option<(f64, f64, i64)> = None;
    for [a, b] in neighbours(samples, twice) {
        let way = b.world_from_robot.position() - a.world_from_robot.position();
        let (distance, seconds) = (way.norm(), seconds(a.stamp_ns, b.stamp_ns));
        if is_leap(distance, seconds) {
            count += 1;
            if largest.is_none_or(|(known, ..)| distance > known) {
                largest = Some((distance, seconds, a.stamp_ns));
            }
        }
    }
    let (distance, took, stamp_ns) = largest?;
    let start = readings.first().map_or(stamp_ns, |r| r.stamp_ns);
    let at = seconds_between(start, stamp_ns, 1);
    Some(format!(
        "the odometry jumps {} by more than {SHORT} m and {TOO_FAST} m/s, farthest by {distance:.2} m in {took:.3} s, \
         at {at} s: the map before and behind does not fit together. --end and --start replay the parts by \
         themselves",
        times(count)
    ))
}

fn seconds(from_ns: i64, to_ns: i64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;

    #[test]
    fn a_robot_does_not_drive_five_metres_between_two_samples() {
        let sample = |k: i64, x: f64| OdometrySample {
            stamp_ns: k * 100_000_000,
            world_from_robot: Pose2::new(x, 0.0, 0.0),
        };
        let drive: Vec<_> = (0..50).map(|k| sample(k, k as f64 * 0.2)).collect();
        assert_eq!(note(&drive, &[], &[]), None);
        let leap: Vec<_> = (0..50)
            .map(|k| sample(k, k as f64 * 0.2 + if k > 30 { 5.0 } else { 0.0 }))
            .collect();
        let text = note(&leap, &[], &[]).unwrap();
        assert!(
            text.contains("jumps once") && text.contains("by 5.20 m in 0.100 s"),
            "{text}"
        );
        // Where the clock was set back, samples of two times lie side by side.
        let at = 30 * 100_000_000;
        assert_eq!(note(&leap, &[], &[(at - 5, at + 5)]), None);
        assert!(note(&leap, &[], &[(0, at - 5)]).is_some());
    }

    #[test]
    fn a_leap_outside_of_the_window_is_none_of_its() {
        let samples: Vec<_> = (0..50)
            .map(|k| OdometrySample {
                stamp_ns: k * 100_000_000,
                world_from_robot: Pose2::new(if k > 30 { 5.0 } else { 0.0 }, 0.0, 0.0),
            })
            .collect();
        let reading = RangeReading {
            stamp_ns: 0,
            sonar: crate::core::event::SonarId(0),
            range: 1.0,
            min_range: 0.1,
            max_range: 5.0,
            beam_width: 0.4,
            variance: 0.0,
        };
        let told = |start, end| {
            let readings = [reading];
            note(window(&samples, &readings, start, end), &readings, &[]).is_some()
        };
        assert!(told(None, None) && told(Some(2.0), Some(4.0)));
        assert!(!told(None, Some(2.95)) && !told(Some(3.05), None));
    }
}
