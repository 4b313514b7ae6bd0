//! Two tracks on one odometry topic: two publishers, whose poses alternate (introlab/rtabmap_ros#760,
//! ros-navigation/navigation2_tutorials#130).

use super::examined::Examined;
use super::finding::{Finding, Weight};
use crate::core::event::OdometrySample;
use crate::core::geometry::wrap_angle;
use crate::core::statistics::{median, seconds};
use crate::core::wording::counted;

/// Fewer samples than this show no pattern.
const ENOUGH: usize = 50;
/// Tracks that are nearer are one, metres and radians.
const NEAR: [f64; 2] = [0.01, 0.01];
/// Samples lie so much farther from their neighbours than from the next but one.
const FARTHER: f64 = 4.0;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    let samples = &of.survey.log.events.odometry;
    let [way, turn] = apart(samples)?;
    let topic = of.survey.odometry_topic.as_deref().unwrap_or_default();
    Some(Finding::new(
        Weight::Serious,
        "two-tracks",
        format!(
            "the {} on {topic} are of two tracks that alternate, {way:.3} m and {:.2} deg apart in the middle: two \
             nodes publish it",
            counted(samples.len() as u64, "sample"),
            turn.to_degrees()
        ),
        "readings are placed by one and then by the other, and walls are drawn twice",
        "stop one of the two publishers (ros2 topic info -v names them), or have it publish to a topic of its own and \
         choose with --odom-topic; where their frames differ, input.world_frame chooses",
    ))
}

/// How far apart two alternating tracks are in the middle, metres and radians; `None` of one track.
pub fn apart(samples: &[OdometrySample]) -> Option<[f64; 2]> {
    if samples.len() < ENOUGH {
        return None;
    }
    let (mut near, mut next) = ([const { Vec::new() }; 2], [const { Vec::new() }; 2]);
    for [a, b, c, d, e] in samples.array_windows() {
        for (list, off) in near.iter_mut().zip(off(b, c, d)) {
            list.push(off);
        }
        for (list, off) in next.iter_mut().zip(off(a, c, e)) {
            list.push(off);
        }
    }
    let middle = |mut list: Vec<f64>| {
        list.sort_by(f64::total_cmp);
        median(&list).unwrap_or_default()
    };
    let (near, next) = (near.map(middle), next.map(middle));
    let is_apart = |i: usize| {
        let (near, next, least) = (near.get(i), next.get(i), NEAR.get(i));
        match (near, next, least) {
            (Some(near), Some(next), Some(least)) => near > least && *near > FARTHER * next,
            _ => false,
        }
    };
    (is_apart(0) || is_apart(1)).then_some(near)
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
        let [way, _] = apart(&drive(0.07)).unwrap();
        assert!((way - 0.07).abs() < 1e-9, "{way}");
        assert_eq!(apart(&drive(0.0)), None);
    }
}
