//! Odometry that leaps: from one sample to the next farther than a robot drives, or farther, or farther round, than by
//! its speed before and behind.

use std::collections::BTreeSet;

use crate::core::event::{OdometrySample, Readings};
use crate::core::geometry::{Pose2, Vec2, wrap_angle};
use crate::core::statistics::{median, seconds};

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
    readings: &Readings,
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

/// A robot with sonars gains less speed in a second, m/s and rad/s.
const ACCELERATION: [f64; 2] = [4.0, 12.0];
/// Less is within what wheels do, metres and radians.
const LEAST: [f64; 2] = [0.05, 2.0 * std::f64::consts::PI / 180.0];
/// A jump stands out so far from what is usual.
const UNUSUAL: f64 = 10.0;
/// Where more of the steps are jumps, it is how the robot moves.
const MOST: f64 = 0.1;

/// A jump: the samples before and behind it, and what of way and turn no speed explains.
pub struct Jump<'a> {
    pub from: &'a OdometrySample,
    pub to: &'a OdometrySample,
    pub excess: [f64; 2],
}

/// The jumps among samples in stamp order, but for those at times that the stamps were in twice; none where there
/// are so many that it is how the robot moves.
pub fn jumps<'a>(samples: &'a [OdometrySample], twice: &'a [(i64, i64)]) -> Vec<Jump<'a>> {
    let steps: Vec<&[OdometrySample; 2]> = neighbours(samples, twice).collect();
    let excess: Vec<Option<[f64; 2]>> = (0..steps.len()).map(|k| excess(&steps, k)).collect();
    let usual = |i: usize| {
        let all = excess
            .iter()
            .flatten()
            .filter_map(|excess| excess.get(i).copied());
        let mut all: Vec<f64> = all.collect();
        all.sort_by(f64::total_cmp);
        UNUSUAL * median(&all).unwrap_or_default()
    };
    let usual = [usual(0), usual(1)];
    let jumps = steps
        .iter()
        .zip(&excess)
        .filter_map(|([from, to], excess)| {
            let took = seconds(from.stamp_ns, to.stamp_ns);
            let way = (to.world_from_robot.position() - from.world_from_robot.position()).norm();
            let excess = (*excess)?;
            let bounds = ACCELERATION.iter().zip(LEAST).zip(usual);
            let mut beyond =
                excess
                    .iter()
                    .zip(bounds)
                    .map(|(excess, ((acceleration, least), usual))| {
                        *excess > (acceleration * took * took).max(least).max(usual)
                    });
            let jumps = is_leap(way, took) || beyond.any(|is_beyond| is_beyond);
            jumps.then_some(Jump { from, to, excess })
        });
    let jumps: Vec<Jump<'_>> = jumps.collect();
    match jumps.len() as f64 > MOST * steps.len() as f64 {
        true => Vec::new(),
        false => jumps,
    }
}

/// What of a step's way and turn neither the speed before nor that behind it explains: metres and radians.
fn excess(steps: &[&[OdometrySample; 2]], place: usize) -> Option<[f64; 2]> {
    let speed = |place: usize| steps.get(place).and_then(|[a, b]| speed(a, b));
    let [from, to] = steps.get(place)?;
    let took = seconds(from.stamp_ns, to.stamp_ns);
    let (a, b) = (from.world_from_robot, to.world_from_robot);
    let around = [place.checked_sub(1), Some(place + 1)];
    let speeds = around.into_iter().flatten().filter_map(speed);
    let off = speeds.map(|(v, w)| {
        let way = b.position() - a.position() - v * took;
        [way.norm(), wrap_angle(b.yaw - a.yaw - w * took).abs()]
    });
    off.reduce(|[way, turn], [other, otherwise]| [way.min(other), turn.min(otherwise)])
}

fn speed(a: &OdometrySample, b: &OdometrySample) -> Option<(Vec2, f64)> {
    let took = seconds(a.stamp_ns, b.stamp_ns);
    let (from, to) = (a.world_from_robot, b.world_from_robot);
    let way = to.position() - from.position();
    (took > 0.0).then(|| (way / took, wrap_angle(to.yaw - from.yaw) / took))
}

/// Takes the jumps out of samples in stamp order: behind each the robot goes on as it drove before.
pub fn take_out_jumps(samples: &mut [OdometrySample], twice: &[(i64, i64)]) {
    let behind: BTreeSet<i64> = jumps(samples, twice)
        .iter()
        .map(|jump| jump.to.stamp_ns)
        .collect();
    let mut mended_from_said = Pose2::new(0.0, 0.0, 0.0);
    let mut last: Option<OdometrySample> = None;
    let mut step = (0.0, Pose2::new(0.0, 0.0, 0.0));
    for sample in samples {
        if let Some(last) = last {
            let took = seconds(last.stamp_ns, sample.stamp_ns);
            let before = last.world_from_robot;
            if behind.contains(&sample.stamp_ns) {
                let share = if step.0 > 0.0 { took / step.0 } else { 0.0 };
                let way = step.1;
                let on = Pose2::new(way.x * share, way.y * share, way.yaw * share);
                mended_from_said = before
                    .compose(&on)
                    .compose(&sample.world_from_robot.inverse());
            }
            sample.world_from_robot = mended_from_said.compose(&sample.world_from_robot);
            if !behind.contains(&sample.stamp_ns) {
                step = (took, before.inverse().compose(&sample.world_from_robot));
            }
        }
        last = Some(*sample);
    }
}

/// Lays each jump among samples in stamp order over the time since the one before: what corrects a drift is due to
/// all of the way.
pub fn spread_jumps(samples: &mut [OdometrySample], twice: &[(i64, i64)]) {
    let mut smooth = samples.to_vec();
    take_out_jumps(&mut smooth, twice);
    let jumps = jumps(samples, twice);
    let behind: BTreeSet<i64> = jumps.iter().map(|jump| jump.to.stamp_ns).collect();
    let is_first = |sample: &OdometrySample| behind.contains(&sample.stamp_ns);
    let mut rest = samples;
    let mut smooth = smooth.as_slice();
    while let Some(end) = rest.iter().skip(1).position(is_first).map(|at| at + 1)
        && let Some((part, next)) = std::mem::take(&mut rest).split_at_mut_checked(end)
        && let (Some(first), Some(to)) = (part.first().copied(), next.first().copied())
        && let (Some(from), Some(on)) = (smooth.first(), smooth.get(end))
    {
        // Where the robot would be without the jump.
        let on = from
            .world_from_robot
            .inverse()
            .compose(&on.world_from_robot);
        let on = first.world_from_robot.compose(&on);
        let off = to.world_from_robot.position() - on.position();
        let turn = wrap_angle(to.world_from_robot.yaw - on.yaw);
        let whole = seconds(first.stamp_ns, to.stamp_ns);
        for sample in part {
            let share = seconds(first.stamp_ns, sample.stamp_ns) / whole;
            let pose = sample.world_from_robot;
            let at = pose.position() + off * share;
            sample.world_from_robot = Pose2::new(at.x, at.y, wrap_angle(pose.yaw + turn * share));
        }
        rest = next;
        smooth = smooth.get(end..).unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_does_not_drive_five_metres_between_two_samples() {
        assert!(is_leap(5.0, 0.1) && !is_leap(0.2, 0.01) && !is_leap(5.0, 2.0));
    }

    /// Drives 0.2 m/s in a circle, and is put elsewhere at some samples.
    fn drive(jumps: &[(usize, f64, f64)]) -> Vec<OdometrySample> {
        let sample = |k: usize| {
            let put = || jumps.iter().filter(move |(at, ..)| *at <= k);
            let yaw = 0.02 * k as f64 + put().map(|(_, _, turn)| turn).sum::<f64>();
            let along = put().map(|(_, way, _)| way).sum::<f64>();
            OdometrySample {
                stamp_ns: k as i64 * 100_000_000,
                world_from_robot: Pose2::new(
                    libm::sin(0.02 * k as f64) + along,
                    -libm::cos(0.02 * k as f64),
                    wrap_angle(yaw),
                ),
            }
        };
        (0..300).map(sample).collect()
    }

    #[test]
    fn jumps_in_place_and_in_heading_are_seen_and_a_circle_is_none() {
        assert!(jumps(&drive(&[]), &[]).is_empty());
        let put = [(50, 0.12, 0.0), (120, 0.0, -0.7), (200, -5.0, 0.05)];
        let drive = drive(&put);
        let found = jumps(&drive, &[]);
        let at: Vec<i64> = found
            .iter()
            .map(|jump| jump.to.stamp_ns / 100_000_000)
            .collect();
        assert_eq!(at, [50, 120, 200]);
        let [way, turn] = found[0].excess;
        assert!((way - 0.12).abs() < 0.01 && turn < 1e-9, "{way} {turn}");
        assert!((found[1].excess[1] - 0.7).abs() < 1e-9);
    }

    #[test]
    fn corrections_of_a_drift_are_spread_over_the_time_before() {
        let right = drive(&[]);
        let mut drifting = right.clone();
        for (k, sample) in drifting.iter_mut().enumerate() {
            let drift = (k % 50) as f64 / 50.0;
            sample.world_from_robot.x += 0.12 * drift;
            sample.world_from_robot.yaw = wrap_angle(sample.world_from_robot.yaw + 0.05 * drift);
        }
        spread_jumps(&mut drifting, &[]);
        for (mended, right) in drifting.iter().zip(right).take(250) {
            let [a, b] = [mended.world_from_robot, right.world_from_robot];
            assert!((a.position() - b.position()).norm() < 0.01);
            assert!(wrap_angle(a.yaw - b.yaw).abs() < 0.003);
        }
    }

    #[test]
    fn without_its_jumps_a_drive_is_the_one_without_them() {
        let mut put = drive(&[(50, 0.0, -0.7), (120, 0.0, 0.4)]);
        take_out_jumps(&mut put, &[]);
        for (mended, right) in put.iter().zip(drive(&[])) {
            let [a, b] = [mended.world_from_robot, right.world_from_robot];
            assert!(wrap_angle(a.yaw - b.yaw).abs() < 1e-6);
        }
    }
}
