//! How the robot moved and how well the odometry covers the readings.

use serde::Serialize;

use crate::core::config::Config;
use crate::core::event::{Events, OdometrySample, RangeReading};
use crate::core::geometry::angle_between;
use crate::core::odometry::Track;
use crate::core::rounding::{number, optional};
use crate::core::statistics::{median, quantile, rate, seconds};
use crate::io::log::leaps::neighbours;

/// The odometry.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OdometryFacts {
    /// Its topic.
    pub topic: String,
    /// Samples with a pose.
    pub samples: u64,
    /// Stamp of the first one, nanoseconds.
    pub first_ns: i64,
    /// Stamp of the last one, nanoseconds.
    pub last_ns: i64,
    /// Samples per second.
    #[serde(serialize_with = "optional")]
    pub rate: Option<f64>,
    /// Time from sample to sample, in the middle of all, seconds.
    #[serde(serialize_with = "optional")]
    pub median_interval: Option<f64>,
    /// Time from sample to sample that 95 of 100 keep below, seconds.
    #[serde(serialize_with = "optional")]
    pub usual_interval: Option<f64>,
    /// `frames.max_odometry_gap` by which gaps are counted, seconds.
    #[serde(skip)]
    pub gap_bound: f64,
    /// Pairs of neighbouring samples farther apart than `frames.max_odometry_gap`.
    pub gaps: u64,
    /// The longest time between neighbouring samples.
    pub longest_gap: Option<Leap>,
    /// The longest way between neighbouring samples.
    pub largest_jump: Option<Leap>,
    /// Way driven, metres.
    #[serde(serialize_with = "number")]
    pub distance: f64,
    /// All turns, left and right, radians.
    #[serde(serialize_with = "number")]
    pub turning: f64,
    /// Range readings of the log.
    pub readings: u64,
    /// Those that have a pose.
    pub readings_with_pose: u64,
    /// Those before the first sample.
    pub readings_before: u64,
    /// Those after the last sample.
    pub readings_after: u64,
}

/// Two neighbouring samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Leap {
    /// Stamp of the earlier one, nanoseconds.
    pub stamp_ns: i64,
    /// Time between them, seconds.
    #[serde(serialize_with = "number")]
    pub seconds: f64,
    /// Way between them, metres.
    #[serde(serialize_with = "number")]
    pub distance: f64,
}

/// The facts of the odometry on a topic; `None` where there is none. At the times that its stamps were
/// in `twice`, ways and turns are not known.
pub fn odometry(
    topic: Option<&str>,
    events: &Events,
    twice: &[(i64, i64)],
    config: &Config,
) -> Option<OdometryFacts> {
    let samples = events.odometry.as_slice();
    let (first, last) = (samples.first()?, samples.last()?);
    let leaps: Vec<Leap> = samples.array_windows().map(|[a, b]| leap(a, b)).collect();
    let mut intervals: Vec<f64> = leaps.iter().map(|leap| leap.seconds).collect();
    intervals.sort_by(f64::total_cmp);
    let ways: Vec<Leap> = neighbours(samples, twice)
        .map(|[a, b]| leap(a, b))
        .collect();
    // Of equal ones the first.
    let largest = |leaps: &[Leap], of: fn(&Leap) -> f64| {
        let found = leaps.iter().rev().max_by(|a, b| of(a).total_cmp(&of(b)));
        found.copied()
    };
    let gap = |leap: &&Leap| leap.seconds > config.frames.max_odometry_gap;
    let turn = |[a, b]: &[OdometrySample; 2]| {
        angle_between(b.world_from_robot.yaw, a.world_from_robot.yaw)
    };
    let track = Track::of_ranges(samples, config);
    let count = |test: &dyn Fn(i64) -> bool| {
        let instants = events.readings.iter().map(|r| track.instant_ns(&r));
        instants.filter(|instant| test(*instant)).count() as u64
    };
    let mut near = 0;
    let with_pose = |r: &RangeReading| track.world_from_robot_next(r, &mut near).is_ok();
    Some(OdometryFacts {
        topic: topic.unwrap_or_default().to_owned(),
        samples: samples.len() as u64,
        first_ns: first.stamp_ns,
        last_ns: last.stamp_ns,
        rate: rate(samples.len(), first.stamp_ns, last.stamp_ns),
        median_interval: median(&intervals),
        usual_interval: quantile(&intervals, 0.95),
        gap_bound: config.frames.max_odometry_gap,
        gaps: leaps.iter().filter(gap).count() as u64,
        longest_gap: largest(&leaps, |leap| leap.seconds),
        largest_jump: largest(&ways, |leap| leap.distance),
        distance: ways.iter().map(|leap| leap.distance).sum(),
        turning: neighbours(samples, twice).map(turn).sum(),
        readings: events.readings.len() as u64,
        readings_with_pose: events.readings.iter().filter(with_pose).count() as u64,
        readings_before: count(&|instant| instant < first.stamp_ns),
        readings_after: count(&|instant| instant > last.stamp_ns),
    })
}

fn leap(a: &OdometrySample, b: &OdometrySample) -> Leap {
    let way = b.world_from_robot.position() - a.world_from_robot.position();
    Leap {
        stamp_ns: a.stamp_ns,
        seconds: seconds(a.stamp_ns, b.stamp_ns),
        distance: way.norm(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::{Readings, SonarId};
    use crate::core::geometry::Pose2;

    #[test]
    fn gaps_jumps_and_what_the_readings_find() {
        let sample = |seconds: f64, x: f64, yaw: f64| OdometrySample {
            stamp_ns: (seconds * 1e9) as i64,
            world_from_robot: Pose2::new(x, 0.0, yaw),
        };
        let reading = |seconds: f64| RangeReading {
            stamp_ns: (seconds * 1e9) as i64,
            sonar: SonarId(0),
            range: 1.0,
            min_range: 0.0,
            max_range: 5.0,
            beam_width: 0.4,
            variance: 0.0,
        };
        let events = Events {
            sonars: Vec::new(),
            readings: Readings::from_iter([-1.0, 0.1, 1.0, 2.1, 9.0].map(reading)),
            odometry: vec![
                sample(0.0, 0.0, 0.0),
                sample(0.25, 0.5, 3.0),
                sample(2.0, 0.5, -3.0),
                sample(2.25, 3.5, -3.0),
            ],
        };
        let facts = odometry(Some("/odom"), &events, &[], &Config::default()).unwrap();
        assert_eq!(facts.gaps, 1);
        assert_eq!(facts.longest_gap.unwrap().stamp_ns, 250_000_000);
        assert_eq!(facts.largest_jump.unwrap().distance, 3.0);
        assert_eq!(facts.distance, 3.5);
        let turned = 3.0 + 2.0 * (std::f64::consts::PI - 3.0);
        assert!((facts.turning - turned).abs() < 1e-12);
        assert_eq!((facts.readings, facts.readings_with_pose), (5, 2));
        assert_eq!((facts.readings_before, facts.readings_after), (1, 1));
        assert_eq!(facts.median_interval, Some(0.25));
        assert_eq!(
            odometry(None, &Events::default(), &[], &Config::default()),
            None
        );
    }
}
