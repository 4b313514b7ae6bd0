//! What is odd about the stamps of a log: clocks that were set or do not agree, stamps that go back or
//! come twice, readings that no odometry covers.

use crate::config::Frames;
use crate::event::{OdometrySample, RangeReading};

/// A stamp that moves so much otherwise than the time of recording was made by a clock that was set,
/// nanoseconds.
const JUMP: i64 = 1_000_000_000;
/// So much more or less delay of the ranges than of the odometry is worth a word, nanoseconds.
const SKEW: i64 = 100_000_000;
/// So many delays are kept of each clock at the most.
const KEPT: usize = 1024;
/// From this share of readings without a pose on, a word is worth it even if nothing was interrupted.
const SHARE: f64 = 0.01;

/// The stamps of one sonar, or of the odometry, while a log is read.
#[derive(Debug, Clone, Default)]
pub struct Clock {
    first_logged: Option<i64>,
    last: Option<(i64, i64)>,
    backward: u64,
    farthest_back: i64,
    jumps: u64,
    /// By how much the largest jump moved the clock and when it was recorded, nanoseconds.
    largest: Option<(i64, i64)>,
    stamped: u64,
    /// From stamp to recording, of every so-many-th message.
    delays: Vec<i64>,
    stride: u64,
    /// The last message in the file, stamp and recording.
    before: Option<(i64, i64)>,
    /// First and last stamp between one jump of both clocks and the next.
    runs: Vec<(i64, i64)>,
    returns: u64,
    pauses: u64,
    /// The farthest return, nanoseconds.
    farthest_return: i64,
}

/// Parts of one log in another order leave no such hole between them, nanoseconds.
const HOLE: i64 = 10_000_000_000;
/// More runs than this are not told apart.
const MOST_RUNS: usize = 512;

impl Clock {
    /// Takes a message, with 0 for no stamp. Nanoseconds.
    pub fn take(&mut self, stamp_ns: i64, logged_ns: i64) {
        self.first_logged.get_or_insert(logged_ns);
        if stamp_ns == 0 {
            return;
        }
        self.follow(stamp_ns, logged_ns);
        // A message out of its place in the file says nothing of the clock.
        let in_order = self.last.is_none_or(|(_, logged)| logged <= logged_ns);
        let last = self.last.filter(|_| in_order);
        if in_order {
            self.last = Some((stamp_ns, logged_ns));
        }
        if let Some((stamp, logged)) = last {
            let moved = stamp_ns.saturating_sub(stamp);
            let passed = logged_ns.saturating_sub(logged);
            let ahead = moved.saturating_sub(passed);
            if moved < 0 {
                self.backward += 1;
                self.farthest_back = self.farthest_back.min(moved);
            }
            // Messages that come late leave the stamps behind, but never turn them back.
            if ahead > JUMP || (ahead < -JUMP && moved < -JUMP) {
                self.jumps += 1;
                if self
                    .largest
                    .is_none_or(|(by, _)| by.unsigned_abs() < ahead.unsigned_abs())
                {
                    self.largest = Some((ahead, logged_ns));
                }
            }
        }
        if self.stamped.is_multiple_of(self.stride.max(1)) {
            if self.delays.len() == KEPT {
                self.stride = self.stride.max(1) * 2;
                let mut keep = false;
                self.delays.retain(|_| {
                    keep = !keep;
                    keep
                });
            }
            self.delays.push(logged_ns.saturating_sub(stamp_ns));
        }
        self.stamped += 1;
    }
}

impl Clock {
    /// Follows stamps to where they and the time of recording go back together, or ahead.
    fn follow(&mut self, stamp_ns: i64, logged_ns: i64) {
        let before = self.before.replace((stamp_ns, logged_ns));
        let (back, ahead) = before.map_or((0, 0), |(stamp, logged)| {
            let (moved, passed) = (
                stamp_ns.saturating_sub(stamp),
                logged_ns.saturating_sub(logged),
            );
            (moved.max(passed).saturating_neg(), moved.min(passed))
        });
        let is_full = self.runs.len() >= MOST_RUNS;
        match self.runs.last_mut() {
            Some((first, last)) if back <= JUMP && ahead <= JUMP => {
                *first = (*first).min(stamp_ns);
                *last = (*last).max(stamp_ns);
            }
            _ if !is_full => self.runs.push((stamp_ns, stamp_ns)),
            _ => {}
        }
        if back > JUMP {
            self.returns += 1;
            self.farthest_return = self.farthest_return.max(back);
        } else if ahead > JUMP {
            self.pauses += 1;
        }
    }

    /// How long the stamps were at times where they had been before, and the widest hole that they
    /// left: nanoseconds. Parts of a log in another order have neither once they are sorted.
    fn overlap_and_hole(&self) -> (i64, i64) {
        let mut runs = self.runs.clone();
        runs.sort_unstable();
        let (mut overlap, mut hole) = (0_i64, 0_i64);
        let mut reached: Option<i64> = None;
        for (first, last) in runs {
            if let Some(reached) = reached {
                overlap = overlap.saturating_add(reached.min(last).saturating_sub(first).max(0));
                hole = hole.max(first.saturating_sub(reached));
            }
            reached = Some(reached.map_or(last, |reached| reached.max(last)));
        }
        if self.pauses > 0 {
            hole = 0; // which a pause may have left
        }
        (overlap, hole)
    }
}

/// Stamps that went back together with the time of recording, to times that the log had been through
/// or far before them.
pub fn returned(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let clocks = || ranges.iter().copied().chain([odometry]);
    let overlap = clocks().map(|clock| clock.overlap_and_hole().0).max()?;
    let hole = clocks().map(|clock| clock.overlap_and_hole().1).max()?;
    let returns = clocks().map(|clock| clock.returns).max()?;
    let farthest = seconds(clocks().map(|clock| clock.farthest_return).max()?);
    let times = if returns == 1 {
        "once".to_owned()
    } else {
        format!("{returns} times")
    };
    if overlap > JUMP {
        return Some(format!(
            "the clock was set back while the log was recorded, {times}, by up to {farthest:.3} s: stamps and times \
             of recording were twice at {:.3} s of the log, and readings from before and after meet each \
             other's poses",
            seconds(overlap)
        ));
    }
    (hole > HOLE).then(|| {
        format!(
            "stamps and times of recording go back together, {times}, by up to {farthest:.3} s, and leave a hole of \
             {:.3} s: the clock was set back, or two logs were put together",
            seconds(hole)
        )
    })
}

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

/// Clocks that were set while the log was recorded.
pub fn jump(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let all = || ranges.iter().copied().chain([odometry]);
    let (by, logged) = all()
        .filter_map(|clock| clock.largest)
        .max_by_key(|(by, logged)| (by.unsigned_abs(), std::cmp::Reverse(*logged)))?;
    let start = all().filter_map(|clock| clock.first_logged).min()?;
    let sonars = ranges.iter().filter(|clock| clock.jumps > 0).count();
    let whose = match (sonars, odometry.jumps > 0) {
        (0, _) => "the odometry".to_owned(),
        (n, false) => format!("{n} of {} sonars", ranges.len()),
        (n, true) => format!("{n} of {} sonars and of the odometry", ranges.len()),
    };
    Some(format!(
        "the clock that stamps the messages of {whose} was set while they were recorded: by {:+.3} s, {:.3} s \
         after the first message. What lies before and behind it does not fit together in time",
        seconds(by),
        seconds(logged.saturating_sub(start))
    ))
}

/// Ranges and odometry that are under way for different times.
pub fn skew(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let of_ranges = median(ranges.iter().flat_map(|clock| &clock.delays))?;
    let of_odometry = median(odometry.delays.iter())?;
    (of_ranges.saturating_sub(of_odometry).saturating_abs() > SKEW).then(|| {
        format!(
            "from stamp to recording ranges take {:.3} s and odometry {:.3} s: if their clocks differ, \
             readings meet the poses of another time",
            seconds(of_ranges),
            seconds(of_odometry)
        )
    })
}

fn median<'a>(delays: impl Iterator<Item = &'a i64>) -> Option<i64> {
    let mut delays: Vec<i64> = delays.copied().collect();
    delays.sort_unstable();
    delays.get(delays.len() / 2).copied()
}

/// Stamps that go back.
pub fn backward(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let of_ranges: u64 = ranges.iter().map(|clock| clock.backward).sum();
    let all = || ranges.iter().copied().chain([odometry]);
    let farthest = all().map(|clock| clock.farthest_back).min()?;
    (farthest < 0).then(|| {
        format!(
            "messages that are stamped earlier than the one before them: {of_ranges} of ranges, {} of \
             odometry, by up to {:.3} s; all are taken in the order of their stamps",
            odometry.backward,
            seconds(farthest.saturating_neg())
        )
    })
}

/// Readings with the stamp of another one of their sonar; they are in stamp order.
pub fn twins(readings: &[RangeReading]) -> Option<String> {
    let count = readings
        .windows(2)
        .filter(|pair| matches!(pair, [a, b] if (a.stamp_ns, a.sonar) == (b.stamp_ns, b.sonar)))
        .count();
    (count > 0).then(|| {
        format!(
            "{count} of {} readings carry the stamp of another one of the same sonar: a driver that \
             publishes twice, or messages that were recorded twice",
            readings.len()
        )
    })
}

/// Readings that have no pose, where they are many or the odometry was interrupted. Both in stamp
/// order.
pub fn uncovered(
    readings: &[RangeReading],
    samples: &[OdometrySample],
    bounds: &Frames,
) -> Option<String> {
    let (first, last) = (samples.first()?.stamp_ns, samples.last()?.stamp_ns);
    let up_to = |stamp: i64| readings.partition_point(|r| r.stamp_ns <= stamp);
    let below = |stamp: i64| readings.partition_point(|r| r.stamp_ns < stamp);
    let beyond = libm::round(bounds.max_extrapolation * 1e9) as i64;
    let before = below(first.saturating_sub(beyond));
    let after = readings.len() - up_to(last.saturating_add(beyond));
    let (mut gaps, mut within, mut longest) = (0_u64, 0, (0.0, 0));
    for pair in samples.windows(2) {
        let [a, b] = pair else { continue };
        let width = seconds(b.stamp_ns.saturating_sub(a.stamp_ns));
        let lost = below(b.stamp_ns).saturating_sub(up_to(a.stamp_ns));
        if width > bounds.max_odometry_gap && lost > 0 {
            gaps += 1;
            within += lost;
            if width > longest.0 {
                longest = (width, a.stamp_ns);
            }
        }
    }
    let lost = before + after + within;
    if gaps == 0 && lost as f64 <= SHARE * readings.len() as f64 {
        return None;
    }
    let mut parts = Vec::new();
    if before > 0 {
        parts.push(format!("{before} before the first odometry sample"));
    }
    if after > 0 {
        parts.push(format!("{after} after the last odometry sample"));
    }
    if gaps > 0 {
        let start = readings.first()?.stamp_ns;
        parts.push(format!(
            "{within} in {gaps} {} of the odometry wider than {} s, the longest {:.1} s at {:.1} s",
            if gaps == 1 { "gap" } else { "gaps" },
            bounds.max_odometry_gap,
            longest.0,
            seconds(longest.1.saturating_sub(start))
        ));
    }
    Some(format!(
        "{lost} of {} readings have no pose and are dropped: {}",
        readings.len(),
        parts.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::SonarId;
    use crate::geometry::Pose2;

    const S: i64 = 1_000_000_000;

    fn clock(messages: impl IntoIterator<Item = (i64, i64)>) -> Clock {
        let mut clock = Clock::default();
        for (stamp, logged) in messages {
            clock.take(stamp, logged);
        }
        clock
    }

    /// Ten messages a second, stamped 10 ms before they are recorded.
    fn steady(from: i64, to: i64, ahead: i64) -> impl Iterator<Item = (i64, i64)> {
        (from..to).map(move |k| (k * S / 10 + ahead - S / 100, k * S / 10))
    }

    #[test]
    fn a_clock_that_was_set_is_told_from_messages_that_come_late() {
        let even = clock(steady(100, 200, 0));
        assert_eq!(jump(&[&even], &even), None);
        for (by, said) in [(3600 * S, "+3600.000 s"), (-30 * S, "-30.000 s")] {
            let set = clock(steady(1000, 1050, 0).chain(steady(1050, 1100, by)));
            let text = jump(&[&even, &set], &even).unwrap();
            assert!(
                text.contains("1 of 2 sonars") && text.contains(said),
                "{text}"
            );
        }
        // Held up for five seconds, then all at once.
        let late = (0..100).map(|k| (S + k * S / 10, S + (k * S / 10).max(5 * S)));
        let late = clock(late);
        assert_eq!((jump(&[&late], &late), late.backward), (None, 0));
    }

    #[test]
    fn clocks_that_differ_are_told_by_their_delays() {
        let (even, behind) = (clock(steady(0, 5000, 5)), clock(steady(0, 5000, -S / 2)));
        assert!(even.delays.len() <= KEPT);
        assert_eq!(skew(&[&even], &even), None);
        let text = skew(&[&behind], &even).unwrap();
        assert!(text.contains("0.510 s and odometry 0.010 s"), "{text}");
        assert_eq!(skew(&[], &even), None);
    }

    #[test]
    fn stamps_that_go_back_are_counted() {
        let shuffled = clock([(5 * S, 5 * S), (3 * S, 3 * S), (4 * S, 4 * S)]);
        assert_eq!(backward(&[&shuffled], &shuffled), None);
        let set_back = clock([(5 * S, 1), (3 * S, 2), (4 * S, 3), (0, 4)]);
        let text = backward(&[&set_back], &Clock::default()).unwrap();
        assert!(
            text.contains("1 of ranges, 0 of odometry, by up to 2.000 s"),
            "{text}"
        );
    }

    fn reading(stamp_ns: i64) -> RangeReading {
        RangeReading {
            stamp_ns,
            sonar: SonarId(0),
            range: 1.0,
            min_range: 0.1,
            max_range: 4.0,
            beam_width: 0.4,
            variance: 0.0,
        }
    }

    #[test]
    fn what_gaps_of_the_odometry_cost() {
        let sample = |stamp_ns| OdometrySample {
            stamp_ns,
            world_from_robot: Pose2::new(0.0, 0.0, 0.0),
        };
        let readings: Vec<_> = (0..100).map(|k| reading(k * S / 10)).collect();
        let bounds = Frames::default();
        let every = |step: i64| (0..=10 * S / step).map(move |k| sample(k * step));
        let covered: Vec<_> = every(S / 10).collect();
        assert_eq!(uncovered(&readings, &covered, &bounds), None);
        let holed: Vec<_> = every(S / 10)
            .filter(|s| (S..=3 * S).contains(&s.stamp_ns) || s.stamp_ns >= 5 * S)
            .collect();
        let text = uncovered(&readings, &holed, &bounds).unwrap();
        assert!(text.starts_with("29 of 100 readings"), "{text}");
        assert!(text.contains("10 before the first"), "{text}");
        assert!(
            text.contains(
                "19 in 1 gap of the odometry wider than 0.5 s, the longest 2.0 s at 3.0 s"
            ),
            "{text}"
        );
    }

    #[test]
    fn a_clock_set_back_with_the_recorders_is_told_from_parts_in_another_order() {
        let both = |range: std::ops::Range<i64>| range.map(|k| (k * S / 10, k * S / 10));
        let set_back = clock(both(100..200).chain(both(150..260)));
        let text = returned(&[&set_back], &set_back).unwrap();
        assert!(text.contains("once, by up to 4.900 s"), "{text}");
        assert!(text.contains("twice at 4.900 s of the log"), "{text}");
        let far_back = clock(both(1000..1100).chain(both(100..200)));
        let text = returned(&[&far_back], &far_back).unwrap();
        assert!(text.contains("leave a hole of 80.100 s"), "{text}");
        let shuffled = clock(
            both(0..10)
                .chain(both(20..30))
                .chain(both(40..50))
                .chain(both(10..20))
                .chain(both(30..40)),
        );
        assert_eq!(returned(&[&shuffled], &shuffled), None);
        let swapped = clock(both(200..300).chain(both(100..200)));
        assert_eq!(returned(&[&swapped], &swapped), None);
    }

    #[test]
    fn readings_that_come_twice() {
        assert_eq!(twins(&[reading(1), reading(2)]), None);
        let text = twins(&[reading(1), reading(1), reading(2)]).unwrap();
        assert!(text.starts_with("1 of 3 readings"), "{text}");
    }
}
