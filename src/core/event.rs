//! What a log yields: sonars, range readings and odometry samples, in stamp order.

use std::cmp::Ordering;
use std::ops::Range;

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

/// Readings in less than half of their memory: what a sonar says again with reading after reading is held once.
#[derive(Debug, Clone, Default)]
pub struct Readings {
    rows: Vec<Row>,
    beams: Vec<Beam>,
    /// The place of the beam of each sonar's last reading; beyond all beams for a sonar without one.
    last: Vec<u32>,
}

/// What each reading says anew.
#[derive(Debug, Clone, Copy)]
struct Row {
    stamp_ns: i64,
    range: f64,
    /// Its place in the list of beams.
    beam: u32,
    sonar: SonarId,
}

/// What a sonar says of itself with a reading; as in [`RangeReading`].
#[derive(Debug, Clone, Copy)]
struct Beam {
    min_range: f64,
    max_range: f64,
    beam_width: f64,
    variance: f64,
}

impl Beam {
    /// The same to the bit: limits may be NaN.
    fn is(&self, other: &Self) -> bool {
        let bits = |beam: &Self| {
            [
                beam.min_range,
                beam.max_range,
                beam.beam_width,
                beam.variance,
            ]
            .map(f64::to_bits)
        };
        bits(self) == bits(other)
    }
}

impl Readings {
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    pub fn iter(
        &self,
    ) -> impl DoubleEndedIterator<Item = RangeReading> + ExactSizeIterator + Clone {
        self.range(0..self.len())
    }

    /// Those at these places.
    pub fn range(
        &self,
        places: Range<usize>,
    ) -> impl DoubleEndedIterator<Item = RangeReading> + ExactSizeIterator + Clone {
        let rows = self.rows.get(places).unwrap_or_default();
        rows.iter().map(|row| unpacked(row, &self.beams))
    }

    /// Those of one sonar.
    pub fn of_sonar(&self, id: SonarId) -> impl Iterator<Item = RangeReading> {
        let rows = self.rows.iter().filter(move |row| row.sonar == id);
        rows.map(|row| unpacked(row, &self.beams))
    }

    pub fn first(&self) -> Option<RangeReading> {
        self.iter().next()
    }

    pub fn last(&self) -> Option<RangeReading> {
        self.iter().next_back()
    }

    /// How many come before the first that is not so, where all that are come first.
    pub fn partition_point(&self, is_so: impl Fn(&RangeReading) -> bool) -> usize {
        self.rows
            .partition_point(|row| is_so(&unpacked(row, &self.beams)))
    }

    pub fn push(&mut self, reading: RangeReading) {
        let row = self.packed(&reading);
        self.rows.push(row);
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Changes every reading.
    pub fn change(&mut self, mut change: impl FnMut(&mut RangeReading)) {
        self.retain_mut(|reading| {
            change(reading);
            true
        });
    }

    /// Changes every reading, and leaves out those of which `keep` says no.
    pub fn retain_mut(&mut self, mut keep: impl FnMut(&mut RangeReading) -> bool) {
        let Self {
            mut rows, beams, ..
        } = std::mem::take(self);
        rows.retain_mut(|row| {
            let mut reading = unpacked(row, &beams);
            let is_kept = keep(&mut reading);
            if is_kept {
                *row = self.packed(&reading);
            }
            is_kept
        });
        self.rows = rows;
    }

    /// Sorts by stamp and then by sonar; what is of one stamp and sonar, by its values.
    pub fn sort(&mut self) {
        let beams = &self.beams;
        let values = |row: &Row| {
            let reading = unpacked(row, beams);
            let RangeReading {
                range,
                min_range,
                max_range,
                beam_width,
                variance,
                ..
            } = reading;
            [range, min_range, max_range, beam_width, variance]
        };
        self.rows.sort_unstable_by(|a, b| {
            let by_place = place(a).cmp(&place(b));
            by_place.then_with(|| by_values(values(a), values(b)))
        });
    }

    /// Sorts by stamp and then by sonar; what is of one stamp and sonar stays in order.
    pub fn sort_by_place(&mut self) {
        if !self.rows.is_sorted_by_key(place) {
            self.rows.sort_by_key(place); // which takes memory
        }
    }

    fn packed(&mut self, reading: &RangeReading) -> Row {
        let beam = Beam {
            min_range: reading.min_range,
            max_range: reading.max_range,
            beam_width: reading.beam_width,
            variance: reading.variance,
        };
        Row {
            stamp_ns: reading.stamp_ns,
            range: reading.range,
            beam: self.place_of(beam, reading.sonar),
            sonar: reading.sonar,
        }
    }

    /// The place of a beam among the beams, where the sonar's last reading had it, or else a new one.
    fn place_of(&mut self, beam: Beam, sonar: SonarId) -> u32 {
        let sonars = self.last.len().max(sonar.index() + 1);
        self.last.resize(sonars, u32::MAX);
        let Some(last) = self.last.get_mut(sonar.index()) else {
            return u32::MAX;
        };
        if !beam_at(&self.beams, *last).is_some_and(|it| it.is(&beam)) {
            *last = u32::try_from(self.beams.len()).unwrap_or(u32::MAX); // 128 GiB
            self.beams.push(beam);
        }
        *last
    }
}

fn place(row: &Row) -> (i64, SonarId) {
    (row.stamp_ns, row.sonar)
}

fn beam_at(beams: &[Beam], place: u32) -> Option<&Beam> {
    beams.get(usize::try_from(place).ok()?)
}

fn unpacked(row: &Row, beams: &[Beam]) -> RangeReading {
    const UNKNOWN: Beam = Beam {
        min_range: f64::NAN,
        max_range: f64::NAN,
        beam_width: f64::NAN,
        variance: 0.0,
    };
    let beam = beam_at(beams, row.beam).unwrap_or(&UNKNOWN);
    RangeReading {
        stamp_ns: row.stamp_ns,
        sonar: row.sonar,
        range: row.range,
        min_range: beam.min_range,
        max_range: beam.max_range,
        beam_width: beam.beam_width,
        variance: beam.variance,
    }
}

impl PartialEq for Readings {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Extend<RangeReading> for Readings {
    fn extend<I: IntoIterator<Item = RangeReading>>(&mut self, readings: I) {
        readings.into_iter().for_each(|reading| self.push(reading));
    }
}

impl FromIterator<RangeReading> for Readings {
    fn from_iter<I: IntoIterator<Item = RangeReading>>(readings: I) -> Self {
        let mut all = Self::default();
        all.extend(readings);
        all
    }
}

/// All that a replay needs of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Events {
    /// Every sonar that gave a reading, sorted by name.
    pub sonars: Vec<Sonar>,
    /// Range readings by stamp, ties by sonar name.
    pub readings: Readings,
    /// Odometry samples by stamp.
    pub odometry: Vec<OdometrySample>,
}

impl Events {
    /// Sorts by stamp, and readings by sonar. What has one stamp is sorted by its values: the order in
    /// which messages of one stamp were written does not matter.
    pub fn sort(&mut self) {
        self.readings.sort();
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
    fn readings_come_back_as_they_went_in() {
        let all = (0..40).map(|k| RangeReading {
            stamp_ns: 40 - k,
            sonar: SonarId(if k % 3 == 0 { 7 } else { 2 }),
            min_range: if k % 7 == 0 { f64::NAN } else { 0.1 },
            variance: if k > 30 { k as f64 } else { 0.0 },
            ..reading(k as f64)
        });
        let mut all: Vec<RangeReading> = all.collect();
        let mut readings: Readings = all.iter().copied().collect();
        let same = |readings: &Readings, all: &[RangeReading]| {
            let [these, those] = [
                format!("{:?}", readings.iter().collect::<Vec<_>>()),
                format!("{all:?}"),
            ];
            these == those
        };
        assert!(same(&readings, &all));
        assert!(readings.beams.len() < all.len());
        readings.retain_mut(|reading| {
            reading.beam_width += reading.range;
            reading.range < 35.0
        });
        all.retain_mut(|reading| {
            reading.beam_width += reading.range;
            reading.range < 35.0
        });
        assert!(same(&readings, &all));
        readings.sort();
        all.reverse();
        assert!(same(&readings, &all));
        assert_eq!(
            readings.partition_point(|r| r.stamp_ns < 10),
            all.iter().filter(|r| r.stamp_ns < 10).count()
        );
        assert_eq!(size_of::<Row>(), 24);
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
