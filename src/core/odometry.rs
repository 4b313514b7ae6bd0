//! The robot's pose at any instant, from odometry samples.

use crate::core::config::{Config, Frames};
use crate::core::event::{OdometrySample, RangeReading};
use crate::core::geometry::{Pose2, wrap_angle};

/// A track of odometry samples, sorted by stamp.
#[derive(Debug, Clone, Copy)]
pub struct Track<'a> {
    samples: &'a [OdometrySample],
    max_gap: f64,
    max_extrapolation: f64,
    range_delay_ns: i64,
    clock_rate: f64,
}

/// So many samples are looked through for the next stamp before they are halved.
const AHEAD: usize = 8;

/// Why a stamp has no pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoPose {
    /// Before the first sample.
    Before,
    /// After the last sample.
    After,
    /// The samples around it lie too far apart.
    Gap,
}

impl<'a> Track<'a> {
    /// A track over samples sorted by stamp.
    pub fn new(samples: &'a [OdometrySample], bounds: &Frames) -> Self {
        Self {
            samples,
            max_gap: bounds.max_odometry_gap,
            max_extrapolation: bounds.max_extrapolation,
            range_delay_ns: 0,
            clock_rate: 0.0,
        }
    }

    /// A track over samples sorted by stamp, for the ranges of a configuration.
    pub fn of_ranges(samples: &'a [OdometrySample], config: &Config) -> Self {
        Self::new(samples, &config.frames)
            .with_range_delay(config.input.range_delay)
            .with_clock_rate(config.input.range_clock_rate)
    }

    /// The same for readings that were taken `seconds` before their stamps.
    pub fn with_range_delay(self, seconds: f64) -> Self {
        Self {
            // A float too large for a stamp becomes the largest one.
            range_delay_ns: libm::rint(seconds * 1e9) as i64,
            ..self
        }
    }

    /// The same for readings whose clock runs fast by this share, counted from the first sample.
    pub fn with_clock_rate(self, clock_rate: f64) -> Self {
        Self { clock_rate, ..self }
    }

    /// When a reading was taken, on the odometry's clock.
    pub fn instant_ns(&self, reading: &RangeReading) -> i64 {
        self.instant_of_ns(reading.stamp_ns)
    }

    /// When a reading of this stamp was taken, on the odometry's clock.
    pub fn instant_of_ns(&self, stamp_ns: i64) -> i64 {
        let gained = match self.samples.first() {
            Some(first) if self.clock_rate != 0.0 => {
                let passed = stamp_ns.saturating_sub(first.stamp_ns) as f64;
                libm::rint(self.clock_rate * passed) as i64
            }
            _ => 0,
        };
        let late = self.range_delay_ns.saturating_add(gained);
        stamp_ns.saturating_sub(late)
    }

    /// The robot's pose when a reading was taken.
    ///
    /// # Errors
    /// As [`Self::world_from_robot`].
    pub fn world_from_robot_at(&self, reading: &RangeReading) -> Result<Pose2, NoPose> {
        self.world_from_robot(self.instant_ns(reading))
    }

    /// The same for readings one after the other in time: `near` is where among the samples the last one was.
    ///
    /// # Errors
    /// As [`Self::world_from_robot`].
    pub fn world_from_robot_next(
        &self,
        reading: &RangeReading,
        near: &mut usize,
    ) -> Result<Pose2, NoPose> {
        let stamp_ns = self.instant_ns(reading);
        let is_before = |sample: &OdometrySample| sample.stamp_ns < stamp_ns;
        let (passed, coming) = self.samples.split_at_checked(*near).unwrap_or_default();
        let ahead = coming
            .iter()
            .take(AHEAD)
            .position(|sample| !is_before(sample));
        *near = match ahead.filter(|_| passed.last().is_none_or(is_before)) {
            Some(ahead) => passed.len() + ahead,
            None => self.samples.partition_point(is_before),
        };
        self.world_from_robot_behind(*near, stamp_ns)
    }

    /// The robot's pose at a stamp: the sample's own, or interpolated between the two around it
    /// (position linear, heading on the shortest arc).
    ///
    /// # Errors
    /// Outside the samples, or between two that lie more than the allowed gap apart.
    pub fn world_from_robot(&self, stamp_ns: i64) -> Result<Pose2, NoPose> {
        let after = self.samples.partition_point(|s| s.stamp_ns < stamp_ns);
        self.world_from_robot_behind(after, stamp_ns)
    }

    /// The pose at a stamp behind so many samples.
    fn world_from_robot_behind(&self, after: usize, stamp_ns: i64) -> Result<Pose2, NoPose> {
        if let Some(exact) = self.samples.get(after).filter(|s| s.stamp_ns == stamp_ns) {
            return Ok(exact.world_from_robot);
        }
        let (earlier, later) = self.samples.split_at(after);
        match (earlier, later) {
            ([.., a], [b, ..]) => {
                let gap = seconds(a.stamp_ns, b.stamp_ns);
                (gap <= self.max_gap)
                    .then(|| between(a, b, stamp_ns))
                    .ok_or(NoPose::Gap)
            }
            ([], [first, ..]) => self
                .beyond(
                    seconds(stamp_ns, first.stamp_ns),
                    later.first_chunk(),
                    stamp_ns,
                )
                .ok_or(NoPose::Before),
            ([.., last], []) => self
                .beyond(
                    seconds(last.stamp_ns, stamp_ns),
                    earlier.last_chunk(),
                    stamp_ns,
                )
                .ok_or(NoPose::After),
            ([], []) => Err(NoPose::Before),
        }
    }

    /// Extrapolates from the two samples at one end of the track, where that is allowed.
    fn beyond(&self, by: f64, end: Option<&[OdometrySample; 2]>, stamp_ns: i64) -> Option<Pose2> {
        let [a, b] = end?;
        let allowed =
            by <= self.max_extrapolation && seconds(a.stamp_ns, b.stamp_ns) <= self.max_gap;
        (allowed && a.stamp_ns != b.stamp_ns).then(|| between(a, b, stamp_ns))
    }
}

fn seconds(from_ns: i64, to_ns: i64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64 * 1e-9
}

fn between(a: &OdometrySample, b: &OdometrySample, stamp_ns: i64) -> Pose2 {
    let span = b.stamp_ns.saturating_sub(a.stamp_ns) as f64;
    let t = stamp_ns.saturating_sub(a.stamp_ns) as f64 / span;
    let (from, to) = (a.world_from_robot, b.world_from_robot);
    Pose2::new(
        from.x + t * (to.x - from.x),
        from.y + t * (to.y - from.y),
        from.yaw + t * wrap_angle(to.yaw - from.yaw),
    )
}

impl NoPose {
    /// The word under which such readings are counted.
    pub fn name(self) -> &'static str {
        match self {
            Self::Before => "before-odometry",
            Self::After => "after-odometry",
            Self::Gap => "odometry-gap",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(seconds: f64, x: f64, yaw: f64) -> OdometrySample {
        OdometrySample {
            stamp_ns: (seconds * 1e9) as i64,
            world_from_robot: Pose2::new(x, 0.0, yaw),
        }
    }

    fn track(samples: &[OdometrySample], max_extrapolation: f64) -> Track<'_> {
        let bounds = Frames {
            max_extrapolation,
            ..Frames::default()
        };
        Track::new(samples, &bounds)
    }

    #[test]
    fn headings_take_the_short_way_round() {
        let samples = [sample(0.0, 0.0, 3.0), sample(0.4, 1.0, -3.0)];
        let pose = track(&samples, 0.0).world_from_robot(200_000_000).unwrap();
        assert!((pose.x - 0.5).abs() < 1e-12);
        assert!(
            (pose.yaw.abs() - std::f64::consts::PI).abs() < 1e-12,
            "{}",
            pose.yaw
        );
    }

    #[test]
    fn a_stamp_of_a_sample_takes_its_pose_even_next_to_a_gap() {
        let samples = [sample(0.0, 1.0, 0.1), sample(9.0, 2.0, 0.2)];
        let track = track(&samples, 0.0);
        assert_eq!(track.world_from_robot(0), Ok(samples[0].world_from_robot));
        assert_eq!(
            track.world_from_robot(9_000_000_000),
            Ok(samples[1].world_from_robot)
        );
        assert_eq!(track.world_from_robot(1), Err(NoPose::Gap));
        assert_eq!(track.world_from_robot(-1), Err(NoPose::Before));
        assert_eq!(track.world_from_robot(9_000_000_001), Err(NoPose::After));
    }

    #[test]
    fn extrapolation_goes_only_as_far_as_allowed() {
        let samples = [sample(0.0, 0.0, 0.0), sample(0.4, 0.4, 0.0)];
        let track = track(&samples, 0.1);
        assert!((track.world_from_robot(450_000_000).unwrap().x - 0.45).abs() < 1e-12);
        assert!((track.world_from_robot(-50_000_000).unwrap().x + 0.05).abs() < 1e-12);
        assert_eq!(track.world_from_robot(600_000_000), Err(NoPose::After));
    }

    #[test]
    fn readings_one_after_the_other_find_the_same_poses() {
        let samples: Vec<_> = (0..60_u8)
            .map(|k| sample(f64::from(k / 3) * 0.1, f64::from(k), 0.01 * f64::from(k)))
            .collect();
        let track = track(&samples, 0.05);
        let mut near = 0;
        let stamps = (-20..250)
            .chain((0..200).rev().step_by(7))
            .map(|k| k * 10_000_000);
        for stamp_ns in stamps {
            let reading = RangeReading {
                stamp_ns,
                sonar: crate::core::event::SonarId(0),
                range: 1.0,
                min_range: 0.1,
                max_range: 5.0,
                beam_width: 0.4,
                variance: 0.0,
            };
            let found = track.world_from_robot_next(&reading, &mut near);
            assert_eq!(found, track.world_from_robot_at(&reading), "{stamp_ns}");
        }
    }

    #[test]
    fn no_samples_no_pose() {
        assert_eq!(track(&[], 9.0).world_from_robot(5), Err(NoPose::Before));
        let lone = [sample(0.0, 1.0, 0.0)];
        assert_eq!(track(&lone, 9.0).world_from_robot(5), Err(NoPose::After));
    }

    #[test]
    fn stamps_at_the_ends_of_time_do_not_overflow() {
        let far = OdometrySample {
            stamp_ns: i64::MAX,
            world_from_robot: Pose2::IDENTITY,
        };
        let near = OdometrySample {
            stamp_ns: i64::MIN,
            ..far
        };
        assert_eq!(
            track(&[near, far], 0.0).world_from_robot(0),
            Err(NoPose::Gap)
        );
    }
}
