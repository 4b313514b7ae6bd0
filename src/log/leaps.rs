//! Odometry that leaps: from one sample to the next farther than a robot drives.

use crate::event::{OdometrySample, RangeReading};

/// A robot with sonars does not drive faster, metres per second.
const TOO_FAST: f64 = 3.0;
/// A shorter leap is within what wheels do, metres.
const SHORT: f64 = 0.3;

/// Whether a way, metres, is too far for its time, seconds.
pub fn is_leap(distance: f64, seconds: f64) -> bool {
    distance > SHORT && distance > TOO_FAST * seconds
}

/// What is told of samples in stamp order that leap; times count from the first reading.
pub fn note(samples: &[OdometrySample], readings: &[RangeReading]) -> Option<String> {
    let mut count = 0_u64;
    let mut largest: Option<(f64, f64, i64)> = None;
    for [a, b] in samples.array_windows() {
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
    let at = seconds(start, stamp_ns);
    Some(format!(
        "the odometry jumps {} by more than {SHORT} m and {TOO_FAST} m/s, farthest by {distance:.2} m in {took:.3} s, \
         at {at:.1} s: the map before and behind does not fit together. --end and --start replay the parts by \
         themselves",
        if count == 1 {
            "once".to_owned()
        } else {
            format!("{count} times")
        }
    ))
}

fn seconds(from_ns: i64, to_ns: i64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;

    #[test]
    fn a_robot_does_not_drive_five_metres_between_two_samples() {
        let sample = |k: i64, x: f64| OdometrySample {
            stamp_ns: k * 100_000_000,
            world_from_robot: Pose2::new(x, 0.0, 0.0),
        };
        let drive: Vec<_> = (0..50).map(|k| sample(k, k as f64 * 0.2)).collect();
        assert_eq!(note(&drive, &[]), None);
        let leap: Vec<_> = (0..50)
            .map(|k| sample(k, k as f64 * 0.2 + if k > 30 { 5.0 } else { 0.0 }))
            .collect();
        let text = note(&leap, &[]).unwrap();
        assert!(
            text.contains("jumps once") && text.contains("by 5.20 m in 0.100 s"),
            "{text}"
        );
    }
}
