//! Two tracks on one odometry topic: two publishers, whose poses alternate (introlab/rtabmap_ros#760,
//! ros-navigation/navigation2_tutorials#130).

use crate::core::event::OdometrySample;
use crate::core::geometry::{Vec2, wrap_angle};
use crate::core::statistics::{median, seconds};

/// Fewer samples than this show no pattern.
const ENOUGH: usize = 50;
/// The rarer track has at least one sample in so many.
const RAREST: usize = 20;
/// Tracks that are nearer are one, metres and radians.
const NEAR: [f64; 2] = [0.01, 0.01];
/// Samples lie so much farther from the other track than from their own.
const FARTHER: f64 = 4.0;

/// Two tracks in one.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoTracks {
    /// Of each sample, whether it is of another track than the first one.
    is_second: Vec<bool>,
    /// How far the tracks are apart in the middle, metres and radians.
    pub apart: [f64; 2],
}

/// The samples of one of two tracks, 1 or 2; all where there are no two.
pub fn one_track(samples: Vec<OdometrySample>, track: u8) -> Vec<OdometrySample> {
    let Some(tracks) = two_tracks(&samples) else {
        return samples;
    };
    let of_track = samples.into_iter().zip(tracks.is_second);
    let of_track = of_track.filter(|(_, is_second)| *is_second == (track == 2));
    of_track.map(|(sample, _)| sample).collect()
}

/// The tracks of samples in stamp order; `None` of one track.
pub fn two_tracks(samples: &[OdometrySample]) -> Option<TwoTracks> {
    if samples.len() < ENOUGH {
        return None;
    }
    // The longest step leads from one track to the other.
    let steps = samples.array_windows().enumerate();
    let (seed, [a, b]) =
        steps.max_by(|(_, [a, b]), (_, [c, d])| misfit(a, b).total_cmp(&misfit(c, d)))?;
    let mut tracks = [a, b].map(|start| Course {
        last: *start,
        speed: None,
    });
    for sample in samples.iter().skip(seed + 2) {
        follow(&mut tracks, sample);
    }
    tracks.iter_mut().for_each(|track| track.speed = None);
    let mut is_second: Vec<bool> = samples
        .iter()
        .rev()
        .map(|sample| follow(&mut tracks, sample))
        .collect();
    is_second.reverse();
    let first = is_second.first().copied()?;
    is_second.iter_mut().for_each(|of| *of ^= first);
    let second = is_second.iter().filter(|of| **of).count();
    let rarer = second.min(samples.len() - second);
    let switches = is_second.array_windows().filter(|[a, b]| a != b).count();
    if rarer * RAREST < samples.len() || switches < rarer {
        return None;
    }
    let apart = apart(samples, &is_second)?;
    Some(TwoTracks { is_second, apart })
}

/// Where a track is, and how it goes on: metres and radians a second.
struct Course {
    last: OdometrySample,
    speed: Option<(Vec2, f64)>,
}

/// Takes a sample for the track that it lies nearer to; whether that is the second.
fn follow(tracks: &mut [Course; 2], sample: &OdometrySample) -> bool {
    let off = tracks.each_ref().map(|track| {
        let mut expected = track.last;
        if let Some((speed, turn)) = track.speed {
            let took = seconds(track.last.stamp_ns, sample.stamp_ns);
            expected.world_from_robot.x += speed.x * took;
            expected.world_from_robot.y += speed.y * took;
            expected.world_from_robot.yaw += turn * took;
        }
        misfit(&expected, sample)
    });
    let [one, other] = off;
    let is_second = other < one;
    let [first, second] = tracks;
    let track = if is_second { second } else { first };
    let took = seconds(track.last.stamp_ns, sample.stamp_ns);
    let (from, to) = (track.last.world_from_robot, sample.world_from_robot);
    let way = to.position() - from.position();
    track.speed = (took != 0.0).then(|| (way / took, wrap_angle(to.yaw - from.yaw) / took));
    track.last = *sample;
    is_second
}

/// How far two poses are apart: metres, and radians as if they were metres.
fn misfit(a: &OdometrySample, b: &OdometrySample) -> f64 {
    let [a, b] = [a, b].map(|sample| sample.world_from_robot);
    (b.position() - a.position()).norm() + wrap_angle(b.yaw - a.yaw).abs()
}

/// How far the tracks are apart in the middle; `None` where that is no more than they scatter.
fn apart(samples: &[OdometrySample], is_second: &[bool]) -> Option<[f64; 2]> {
    let of = |track: bool| {
        let samples = samples.iter().zip(is_second);
        let samples = samples.filter(move |(_, is_second)| **is_second == track);
        samples.map(|(sample, _)| *sample).collect::<Vec<_>>()
    };
    let (first, second) = (of(false), of(true));
    let to_other = second.iter().filter_map(|sample| {
        let behind = first.partition_point(|other| other.stamp_ns <= sample.stamp_ns);
        let before = first.get(behind.checked_sub(1)?)?;
        Some(off(before, sample, first.get(behind)?))
    });
    let to_own = second.array_windows().map(|[a, b, c]| off(a, b, c));
    let (near, next) = (middles(to_other), middles(to_own));
    let bounds = near.iter().zip(next).zip(NEAR);
    let mut are_apart = bounds.map(|((near, next), least)| *near > least && *near > FARTHER * next);
    are_apart.any(|is_apart| is_apart).then_some(near)
}

fn middles(all: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let (ways, turns): (Vec<f64>, Vec<f64>) = all.map(|[way, turn]| (way, turn)).unzip();
    [ways, turns].map(|mut list| {
        list.sort_by(f64::total_cmp);
        median(&list).unwrap_or_default()
    })
}

/// How far a sample is off the straight way between two others, metres and radians.
fn off(a: &OdometrySample, b: &OdometrySample, c: &OdometrySample) -> [f64; 2] {
    let whole = seconds(a.stamp_ns, c.stamp_ns);
    let share = if whole > 0.0 {
        seconds(a.stamp_ns, b.stamp_ns) / whole
    } else {
        0.5
    };
    let [a, b, c] = [a, b, c].map(|sample| sample.world_from_robot);
    let between = a.position() + share * (c.position() - a.position());
    let heading = a.yaw + share * wrap_angle(c.yaw - a.yaw);
    [
        (b.position() - between).norm(),
        wrap_angle(b.yaw - heading).abs(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Pose2;

    fn drive(offset: f64) -> Vec<OdometrySample> {
        let sample = |k: i64| {
            let beside = if k % 2 == 0 { 0.0 } else { offset };
            OdometrySample {
                stamp_ns: k * 50_000_000,
                world_from_robot: Pose2::new(0.01 * k as f64, beside, 0.001 * k as f64),
            }
        };
        (0..200).map(sample).collect()
    }

    #[test]
    fn two_tracks_are_told_apart_and_one_is_not() {
        let [way, _] = two_tracks(&drive(0.07)).unwrap().apart;
        assert!((way - 0.07).abs() < 1e-9, "{way}");
        assert!(two_tracks(&drive(0.0)).is_none());
    }

    #[test]
    fn tracks_of_two_rates_are_told_apart_and_a_jump_makes_none() {
        let mut samples = drive(0.0);
        for (k, sample) in samples.iter_mut().enumerate() {
            if k % 5 == 3 {
                sample.world_from_robot.y += 0.1;
            }
        }
        let second = one_track(samples.clone(), 2);
        assert_eq!(second.len(), 40);
        assert!(
            second
                .iter()
                .all(|s| (s.world_from_robot.y - 0.1).abs() < 1e-9)
        );
        assert_eq!(one_track(samples, 1).len(), 160);
        let mut jumps = drive(0.0);
        for sample in &mut jumps[100..] {
            sample.world_from_robot.y += 0.5;
        }
        assert!(two_tracks(&jumps).is_none());
    }
}
