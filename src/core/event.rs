//! What a log yields: sonars, range readings and odometry samples, in stamp order.

use std::cmp::Ordering;

use crate::core::geometry::Pose2;
use crate::core::ties;

/// Index of a sonar in [`Events::sonars`]. Sonars are sorted by name, so ids sort as names do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SonarId(pub u16);

impl SonarId {
    /// The position in a list that has one element per sonar.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// One sonar and where it sits on the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Sonar {
    /// Unique name: the frame id, or the topic where two topics share a frame id.
    pub name: String,
    /// The topic its readings came on.
    pub topic: String,
    /// Mounting pose: sensor at the origin, beam axis along x.
    pub robot_from_sensor: Pose2,
}

/// One range measurement of one sonar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeReading {
    /// When it was taken, nanoseconds on the log's own clock.
    pub stamp_ns: i64,
    /// Which sonar took it.
    pub sonar: SonarId,
    /// Measured distance, metres; may be infinite or NaN, as the driver wrote it.
    pub range: f64,
    /// Closest distance the sonar can measure, metres.
    pub min_range: f64,
    /// A reading at or beyond this means that nothing echoed, metres.
    pub max_range: f64,
    /// Full opening angle of the beam, radians.
    pub beam_width: f64,
    /// Variance of `range` as the driver reports it, square metres; 0 where it does not.
    pub variance: f64,
}

/// What a reading says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Return {
    /// Something echoed at `range`.
    Echo,
    /// Nothing echoed within `max_range`.
    NoEcho,
    /// The value means nothing: NaN, negative, or closer than `min_range`.
    Invalid,
}

/// The name of a sonar of a log; nothing for one that the log does not have.
pub fn name_of(sonars: &[Sonar], id: SonarId) -> &str {
    sonars.get(id.index()).map_or("", |sonar| &sonar.name)
}

impl RangeReading {
    /// Echo, no echo or neither: an echo is finite and `min_range <= range < max_range`, and no limit makes a
    /// negative range one.
    pub fn classify(&self) -> Return {
        if ties::at_least(self.range, self.max_range, ties::RANGE) || self.range == f64::INFINITY {
            Return::NoEcho
        } else if ties::at_least(self.range, self.min_range, ties::RANGE)
            && self.range < self.max_range
            && self.range.is_finite()
            && self.range >= 0.0
        {
            Return::Echo
        } else {
            Return::Invalid
        }
    }
}

/// Where the robot was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometrySample {
    /// When, nanoseconds on the log's own clock.
    pub stamp_ns: i64,
    /// The robot in the odometry frame.
    pub world_from_robot: Pose2,
}

/// All that a replay needs of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Events {
    /// Every sonar that gave a reading, sorted by name.
    pub sonars: Vec<Sonar>,
    /// Range readings by stamp, ties by sonar name.
    pub readings: Vec<RangeReading>,
    /// Odometry samples by stamp.
    pub odometry: Vec<OdometrySample>,
}

impl Events {
    /// Sorts by stamp, and readings by sonar. What has one stamp is sorted by its values: the order in
    /// which messages of one stamp were written does not matter.
    pub fn sort(&mut self) {
        self.readings.sort_unstable_by(|a, b| {
            let by_place = (a.stamp_ns, a.sonar).cmp(&(b.stamp_ns, b.sonar));
            by_place.then(by_values(
                [a.range, a.min_range, a.max_range, a.beam_width, a.variance],
                [b.range, b.min_range, b.max_range, b.beam_width, b.variance],
            ))
        });
        self.odometry.sort_unstable_by(|a, b| {
            let [a_pose, b_pose] = [a, b].map(|s| s.world_from_robot);
            a.stamp_ns.cmp(&b.stamp_ns).then(by_values(
                [a_pose.x, a_pose.y, a_pose.yaw],
                [b_pose.x, b_pose.y, b_pose.yaw],
            ))
        });
    }
}

fn by_values<const N: usize>(a: [f64; N], b: [f64; N]) -> Ordering {
    let pairs = a.iter().zip(&b).map(|(a, b)| a.total_cmp(b));
    pairs.fold(Ordering::Equal, Ordering::then)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(range: f64) -> RangeReading {
        RangeReading {
            stamp_ns: 0,
            sonar: SonarId(0),
            range,
            min_range: 0.1,
            max_range: 5.0,
            beam_width: 0.4,
            variance: 0.0,
        }
    }

    #[test]
    fn only_finite_ranges_inside_the_limits_are_echoes() {
        for (range, expected) in [
            (0.1, Return::Echo),
            (4.999, Return::Echo),
            (5.0, Return::NoEcho),
            (f64::INFINITY, Return::NoEcho),
            (0.0999, Return::Invalid),
            (-1.0, Return::Invalid),
            (f64::NEG_INFINITY, Return::Invalid),
            (f64::NAN, Return::Invalid),
        ] {
            assert_eq!(reading(range).classify(), expected, "{range}");
        }
    }

    #[test]
    fn a_negative_range_is_no_echo_whatever_the_limits() {
        let negative = RangeReading {
            min_range: -1.0,
            ..reading(-0.5)
        };
        assert_eq!(negative.classify(), Return::Invalid);
    }

    #[test]
    fn a_limit_that_is_no_number_makes_no_echo() {
        for (min_range, max_range) in [(f64::NAN, 5.0), (0.1, f64::NAN)] {
            let odd = RangeReading {
                min_range,
                max_range,
                ..reading(1.0)
            };
            assert_eq!(odd.classify(), Return::Invalid);
        }
    }

    #[test]
    fn an_unlimited_sonar_still_has_no_echo_at_infinity() {
        let mut unlimited = reading(f64::INFINITY);
        unlimited.max_range = f64::INFINITY;
        assert_eq!(unlimited.classify(), Return::NoEcho);
        unlimited.range = 1e6;
        assert_eq!(unlimited.classify(), Return::Echo);
    }
}
