//! Single stamps and poses amid others with which they do not go together: damage that no checksum caught.

use std::collections::BTreeSet;

use super::sonars::Source;
use super::stamps::Clock;
use crate::core::event::{OdometrySample, RangeReading};
use crate::core::wording::counted;

/// A pose so far from the one before it and the one behind it, metres, is no drive ...
const FAR: f64 = 100.0;
/// ... where these are nearer to each other by so many times.
const TIMES: f64 = 10.0;

/// Takes out the readings whose stamps are strays. What is told of them is returned.
pub fn readings(sources: &[Source], readings: &mut Vec<RangeReading>) -> Vec<String> {
    let strays: Vec<BTreeSet<i64>> = (sources.iter())
        .map(|source| source.clock.strays().into_iter().collect())
        .collect();
    let mut lost = vec![0_u64; sources.len()];
    if strays.iter().all(BTreeSet::is_empty) {
        return Vec::new();
    }
    let mut all = vec![0_u64; sources.len()];
    readings.retain(|reading| {
        let sonar = reading.sonar.index();
        let is_stray = strays
            .get(sonar)
            .is_some_and(|s| s.contains(&reading.stamp_ns));
        let counts = [all.get_mut(sonar), lost.get_mut(sonar).filter(|_| is_stray)];
        for count in counts.into_iter().flatten() {
            *count += 1;
        }
        !is_stray
    });
    let counts = lost.into_iter().zip(all);
    (sources.iter().zip(counts))
        .filter(|(_, (lost, _))| *lost > 0)
        .map(|(source, (lost, all))| {
            stray_stamps(lost, &counted(all, "reading"), &source.key.topic)
        })
        .collect()
}

/// Takes out the samples of a topic whose stamps are strays, and then lone ones that are far from those
/// before and behind them; sorts them by stamp. What is told of them is returned.
pub fn samples(samples: &mut Vec<OdometrySample>, clock: &Clock, topic: &str) -> Vec<String> {
    let all = samples.len();
    let of_all = counted(all as u64, "odometry sample");
    let strays: BTreeSet<i64> = clock.strays().into_iter().collect();
    samples.retain(|sample| !strays.contains(&sample.stamp_ns));
    samples.sort_by_key(|sample| sample.stamp_ns);
    let mut told = Vec::new();
    if let lost @ 1.. = (all - samples.len()) as u64 {
        told.push(stray_stamps(lost, &of_all, topic));
    }
    let far: BTreeSet<usize> = (samples.array_windows().enumerate())
        .filter(|(_, three)| is_lone(three))
        .map(|(index, _)| index + 1)
        .collect();
    if !far.is_empty() {
        let mut place = 0..;
        samples.retain(|_| place.next().is_none_or(|place| !far.contains(&place)));
        let one = far.len() == 1;
        told.push(format!(
            "{} of {of_all} on {topic} {} more than {FAR} m away from the one before and the one behind: {} \
             taken for damaged and left out",
            far.len(),
            if one { "is" } else { "are" },
            if one { "it is" } else { "they are" }
        ));
    }
    told
}

fn is_lone([before, sample, behind]: &[OdometrySample; 3]) -> bool {
    let position = |sample: &OdometrySample| sample.world_from_robot.position();
    let (to, from) = (
        (position(sample) - position(before)).norm(),
        (position(behind) - position(sample)).norm(),
    );
    let past = (position(behind) - position(before)).norm();
    to.min(from) > FAR && to.min(from) > TIMES * past
}

fn stray_stamps(lost: u64, of_all: &str, topic: &str) -> String {
    format!(
        "{lost} of {of_all} on {topic} {} a stamp that is more than a second off from those of the messages before \
         and behind: {} taken for damaged and left out",
        if lost == 1 { "has" } else { "have" },
        if lost == 1 { "it is" } else { "they are" }
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;

    fn sample(k: i64, x: f64) -> OdometrySample {
        OdometrySample {
            stamp_ns: k * 50_000_000,
            world_from_robot: Pose2::new(x, 0.0, 0.0),
        }
    }

    #[test]
    fn a_lone_pose_far_away_is_left_out_and_a_leap_that_lasts_is_not() {
        let drive = |far: &[i64]| -> Vec<OdometrySample> {
            (0..100)
                .map(|k| {
                    sample(
                        k,
                        k as f64 * 0.01 + if far.contains(&k) { 1e7 } else { 0.0 },
                    )
                })
                .collect()
        };
        let mut lone = drive(&[30]);
        let told = samples(&mut lone, &Clock::default(), "/odom");
        assert_eq!(lone.len(), 99);
        assert!(lone.iter().all(|s| s.world_from_robot.x < 10.0));
        assert!(
            told[0].starts_with("1 of 100 odometry samples on /odom is more than 100 m away"),
            "{told:?}"
        );
        let mut leap = drive(&(30..100).collect::<Vec<_>>());
        assert_eq!(samples(&mut leap, &Clock::default(), "/odom").len(), 0);
        assert_eq!(leap.len(), 100);
    }

    #[test]
    fn a_sample_with_a_stray_stamp_is_left_out() {
        for odd in [5_000_000_000, 2_000_000_000_000] {
            let mut clock = Clock::default();
            let mut drive = Vec::new();
            for k in 0..100_i64 {
                let logged = 100_000_000_000 + k * 50_000_000;
                let stamp_ns = if k == 50 { odd } else { logged };
                clock.take(stamp_ns, logged);
                let pose = sample(0, k as f64 * 0.01).world_from_robot;
                drive.push(OdometrySample {
                    stamp_ns,
                    world_from_robot: pose,
                });
            }
            let told = samples(&mut drive, &clock, "/odom");
            assert_eq!(drive.len(), 99);
            assert!(
                told[0].starts_with("1 of 100 odometry samples on /odom has a stamp"),
                "{told:?}"
            );
        }
    }
}
