//! What is odd about the stamps of a log: clocks that were set or do not agree, stamps that go back or
//! come twice, readings that no odometry covers.

use crate::core::config::Frames;
use crate::core::event::{OdometrySample, RangeReading, Readings};
use crate::core::wording::{counted, seconds_between, times};

/// A stamp that moves so much otherwise than the time of recording was made by a clock that was set,
/// nanoseconds.
const JUMP: i64 = 1_000_000_000;
/// Stamps and times of recording that both go back by more were set back where the log has been through
/// these times before, nanoseconds.
const BACK: i64 = 150_000_000;
/// They have been through so many messages at least, or else neighbours may only have changed places.
const SWAPPED: i64 = 4;
/// A clock that was set stamps more messages than this, and a damaged stamp is no more.
const FEW: usize = 3;
/// A drive does not pause for longer, nanoseconds.
const AWAY: i64 = 3_600_000_000_000;
/// Nor does a robot with sonars drive as far from one pose to the next, metres.
const FAR: f64 = 1000.0;

/// The stamps of one sonar, or of the odometry, while a log is read.
#[derive(Debug, Clone, Default)]
pub struct Clock {
    first_logged: Option<i64>,
    last: Option<(i64, i64)>,
    /// The messages since then, whose stamps do not go on from there.
    suspects: Vec<(i64, i64)>,
    backward: u64,
    farthest_back: i64,
    jumps: u64,
    /// Where jumps turned the stamps back: the stamp behind each and the one before it.
    turned: Vec<(i64, i64)>,
    /// By how much the largest jump moved the clock and when it was recorded, nanoseconds.
    largest: Option<(i64, i64)>,
    stamped: u64,
    /// The last message in the file, stamp and recording.
    before: Option<(i64, i64)>,
    /// First and last stamp between one jump of both clocks and the next.
    runs: Vec<(i64, i64)>,
    returns: u64,
    pauses: u64,
    /// The farthest return, nanoseconds.
    farthest_return: i64,
}

/// No clock is set back as often.
const MOST_RETURNS: u64 = 20;
/// More runs than this are not told apart.
const MOST_RUNS: usize = 512;

impl Clock {
    /// Takes a message, with 0 for no stamp. Nanoseconds.
    pub fn take(&mut self, stamp_ns: i64, logged_ns: i64) {
        self.first_logged.get_or_insert(logged_ns);
        if stamp_ns == 0 {
            return;
        }
        let message = (stamp_ns, logged_ns);
        // A message out of its place in the file says nothing of the clock.
        match self.last {
            Some(last) if logged_ns < last.1 => self.follow(stamp_ns, logged_ns),
            Some(last) if is_jump(last, message) => {
                self.suspects.push(message);
                if self.suspects.len() > FEW {
                    self.go_on_with_suspects();
                }
            }
            _ => {
                self.suspects.clear(); // a few damaged stamps
                self.go_on(message);
            }
        }
        self.stamped += 1;
    }
}

/// Whether the stamps moved otherwise than the time of recording. Messages that come late leave the
/// stamps behind, but never turn them back.
fn is_jump(last: (i64, i64), next: (i64, i64)) -> bool {
    let moved = next.0.saturating_sub(last.0);
    let ahead = moved.saturating_sub(next.1.saturating_sub(last.1));
    ahead > JUMP || (ahead < -JUMP && moved < -JUMP)
}

impl Clock {
    /// Takes a message that comes after the last one.
    fn go_on(&mut self, message: (i64, i64)) {
        let (stamp_ns, logged_ns) = message;
        self.follow(stamp_ns, logged_ns);
        let Some(last) = self.last.replace(message) else {
            return;
        };
        let moved = stamp_ns.saturating_sub(last.0);
        if moved < 0 {
            self.backward += 1;
            self.farthest_back = self.farthest_back.min(moved);
        }
        if is_jump(last, message) {
            self.jumps += 1;
            if moved < 0 && self.turned.len() < MOST_RUNS {
                self.turned.push((stamp_ns, last.0));
            }
            let ahead = moved.saturating_sub(logged_ns.saturating_sub(last.1));
            if self
                .largest
                .is_none_or(|(by, _)| by.unsigned_abs() < ahead.unsigned_abs())
            {
                self.largest = Some((ahead, logged_ns));
            }
        }
    }

    /// So many do not go on from the last one that the clock was set.
    fn go_on_with_suspects(&mut self) {
        for suspect in std::mem::take(&mut self.suspects) {
            self.go_on(suspect);
        }
    }

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
            Some((first, last)) if back <= BACK && ahead <= JUMP => {
                *first = (*first).min(stamp_ns);
                *last = (*last).max(stamp_ns);
            }
            _ if !is_full => self.runs.push((stamp_ns, stamp_ns)),
            _ => {}
        }
        if back > BACK {
            self.returns += 1;
            self.farthest_return = self.farthest_return.max(back);
        } else if ahead > JUMP {
            self.pauses += 1;
        }
    }

    /// How long the stamps were at times where they had been before, and the widest hole that they
    /// left: nanoseconds. Parts of a log in another order have neither once they are sorted.
    fn overlap_and_hole(&self) -> (i64, i64) {
        let (overlaps, mut hole) = self.overlaps();
        let overlap = overlaps.iter().fold(0_i64, |sum, (first, last)| {
            sum.saturating_add(last.saturating_sub(*first))
        });
        if self.pauses > 0 {
            hole = 0; // which a pause may have left
        }
        (overlap, hole)
    }

    /// The times that the stamps were in twice: first and last of each, nanoseconds.
    fn twice(&self) -> Vec<(i64, i64)> {
        let mut twice = self.overlaps().0;
        twice.extend(&self.turned);
        twice
    }

    /// What the runs share with those before them, and the widest hole between them.
    fn overlaps(&self) -> (Vec<(i64, i64)>, i64) {
        let mut runs = self.runs.clone();
        runs.sort_unstable();
        let spans = runs.iter().map(|(first, last)| last.saturating_sub(*first));
        let span = spans.fold(0, i64::saturating_add);
        let messages = i64::try_from(self.stamped).unwrap_or(i64::MAX).max(1);
        let least = (span / messages).saturating_mul(SWAPPED).clamp(BACK, JUMP);
        let (mut overlaps, mut hole) = (Vec::new(), 0_i64);
        let mut reached: Option<i64> = None;
        for (first, last) in runs {
            if let Some(reached) = reached {
                let end = reached.min(last);
                if end.saturating_sub(first) > least {
                    overlaps.push((first, end));
                }
                hole = hole.max(first.saturating_sub(reached));
            }
            reached = Some(reached.map_or(last, |reached| reached.max(last)));
        }
        (overlaps, hole)
    }
}

/// Parts of one log in another order leave no such hole between them, nanoseconds.
const HOLE: i64 = 10_000_000_000;

/// A clock that was set while the log was recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClockSet {
    /// What happened, with its numbers.
    pub what: String,
    /// How to replay what fits together; may be empty.
    pub advice: String,
    /// Times that the stamps of the odometry were in twice: first and last of each, nanoseconds.
    pub twice: Vec<(i64, i64)>,
}

impl ClockSet {
    /// All of it in one sentence.
    pub fn text(&self) -> String {
        if self.advice.is_empty() {
            self.what.clone()
        } else {
            format!("{}; {}", self.what, self.advice)
        }
    }

    fn new(what: String, ranges: &[&Clock], odometry: &Clock) -> Self {
        Self {
            what,
            advice: around(ranges, odometry).unwrap_or_default(),
            twice: odometry.twice(),
        }
    }
}

/// Stamps that went back together with the time of recording, to times that the log had been through
/// or far before them.
pub fn returned(ranges: &[&Clock], odometry: &Clock) -> Option<ClockSet> {
    let clocks = || ranges.iter().copied().chain([odometry]);
    let overlap = clocks().map(|clock| clock.overlap_and_hole().0).max()?;
    let hole = clocks().map(|clock| clock.overlap_and_hole().1).max()?;
    let returns = clocks().map(|clock| clock.returns).max()?;
    if returns > MOST_RETURNS {
        return None; // the order of the file, which is no clock
    }
    let farthest = seconds(clocks().map(|clock| clock.farthest_return).max()?);
    let times = times(returns);
    if overlap > BACK {
        let what = format!(
            "the clock was set back while the log was recorded, {times}, by up to {farthest:.3} s: {:.3} s \
             of stamps and times of recording come twice, in which readings from before and after meet each \
             other's poses and the odometry seems to jump to and fro",
            seconds(overlap)
        );
        return Some(ClockSet::new(what, ranges, odometry));
    }
    (hole > HOLE).then(|| {
        let what = format!(
            "stamps and times of recording go back together, {times}, by up to {farthest:.3} s, and leave a hole of \
             {:.3} s: the clock was set back, or two logs were put together",
            seconds(hole)
        );
        ClockSet::new(what, ranges, odometry)
    })
}

/// How to replay what lies before and behind the times that were twice, where they are one stretch.
fn around(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let first = |clock: &&Clock| clock.runs.iter().map(|(first, _)| *first).min();
    let start = ranges.iter().filter_map(first).min()?;
    let (mut from, mut to) = (i64::MAX, i64::MIN);
    for clock in ranges.iter().copied().chain([odometry]) {
        match clock.twice().as_slice() {
            [] => {}
            [(first, last)] => {
                from = from.min(*first);
                to = to.max(*last);
            }
            _ => return None,
        }
    }
    if from > to {
        return None;
    }
    // In tenths of a second that do not touch it.
    let tenths = |ns: i64| seconds(ns.saturating_sub(start)) * 10.0;
    let before = (libm::ceil(tenths(from)) - 1.0) / 10.0;
    let behind = (libm::floor(tenths(to)) + 1.0) / 10.0;
    Some(if before > 0.0 {
        format!(
            "--end {before:.1} replays what lies before these times, --start {behind:.1} what lies behind"
        )
    } else {
        format!("--start {behind:.1} replays what lies behind these times")
    })
}

/// Clocks that were set while the log was recorded.
pub fn jump(ranges: &[&Clock], odometry: &Clock) -> Option<ClockSet> {
    let all = || ranges.iter().copied().chain([odometry]);
    let (by, logged) = all()
        .filter_map(|clock| clock.largest)
        .max_by_key(|(by, logged)| (by.unsigned_abs(), std::cmp::Reverse(*logged)))?;
    let start = all().filter_map(|clock| clock.first_logged).min()?;
    let sonars = ranges.iter().filter(|clock| clock.jumps > 0).count();
    let whose = match (sonars, odometry.jumps > 0) {
        (0, _) => "the odometry".to_owned(),
        (n, false) => format!("{n} of {}", counted(ranges.len() as u64, "sonar")),
        (n, true) => format!(
            "{n} of {} and of the odometry",
            counted(ranges.len() as u64, "sonar")
        ),
    };
    let what = format!(
        "the clock that stamps the messages of {whose} was set while they were recorded: by {:+.3} s, {:.3} s \
         after the first message, so that what lies before and behind it does not fit together in time",
        seconds(by),
        seconds(logged.saturating_sub(start))
    );
    Some(ClockSet::new(what, ranges, odometry))
}

/// From this share of readings without a pose on, a word is worth it even if nothing was interrupted.
const SHARE: f64 = 0.01;

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

/// Stamps that go back otherwise than by a clock that was set, which is told by itself.
pub fn backward(ranges: &[&Clock], odometry: &Clock) -> Option<String> {
    let of_ranges: u64 = ranges.iter().map(|clock| clock.backward).sum();
    let all = || ranges.iter().copied().chain([odometry]);
    if all().all(|clock| clock.backward == clock.turned.len() as u64) {
        return None;
    }
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

/// The few of a log's messages, in stamp order, that are to be left out.
#[derive(Debug)]
pub struct LeftOut {
    /// Whether each of all messages stays.
    stays: Vec<bool>,
    /// What is lost.
    loss: String,
}

impl LeftOut {
    /// Those whose stamps lie more than [`AWAY`] from all others: damaged ones, or those of a clock that was not
    /// set yet.
    pub fn astray(stamps: impl Iterator<Item = i64>, what: &str) -> Option<Self> {
        let stamps: Vec<i64> = stamps.collect();
        let is_apart = |a: &i64, b: &i64| b.saturating_sub(*a) > AWAY;
        Self::apart(&stamps, is_apart, |lost, first| {
            let (lost, first) = (counted(lost, "message"), seconds(*first));
            format!(
                "{lost} on {what} with a stamp more than an hour from all others left out, the first at {first:.3} s"
            )
        })
    }

    /// The poses that lie more than [`FAR`] from those before and behind.
    pub fn far(samples: &[OdometrySample], topic: &str) -> Option<Self> {
        let place = |sample: &OdometrySample| sample.world_from_robot.position();
        let is_apart = |a: &OdometrySample, b: &OdometrySample| (place(b) - place(a)).norm() > FAR;
        Self::apart(samples, is_apart, |lost, first| {
            let (lost, first) = (counted(lost, "pose"), seconds(first.stamp_ns));
            format!(
                "{lost} on {topic} more than {FAR} m from all others left out, the first at {first:.3} s"
            )
        })
    }

    /// What comes by [`FEW`] at the most and is apart from its neighbours, unless that is much of all.
    fn apart<T>(
        items: &[T],
        is_apart: impl Fn(&T, &T) -> bool,
        loss: impl FnOnce(u64, &T) -> String,
    ) -> Option<Self> {
        let mut stays = Vec::with_capacity(items.len());
        for run in items.chunk_by(|a, b| !is_apart(a, b)) {
            stays.extend(std::iter::repeat_n(run.len() > FEW, run.len()));
        }
        let lost = stays.iter().filter(|stays| !**stays).count();
        let first = items.get(stays.iter().position(|stays| !stays)?)?;
        let loss = loss(lost as u64, first);
        (10 * lost < items.len()).then_some(Self { stays, loss })
    }

    /// Takes them out, by a function that retains what stays; says what is lost.
    pub fn take_out(self, retain: impl FnOnce(&mut dyn FnMut() -> bool)) -> String {
        let mut stays = self.stays.into_iter();
        retain(&mut || stays.next() != Some(false));
        self.loss
    }
}

/// Readings with the stamp of another one of their sonar; they are in stamp order.
pub fn twins(readings: &Readings) -> Option<String> {
    let place = |reading: RangeReading| (reading.stamp_ns, reading.sonar);
    let places = readings.iter().map(place);
    let pairs = places.clone().zip(places.skip(1));
    let count = pairs.filter(|(a, b)| a == b).count();
    (count > 0).then(|| {
        format!(
            "{count} of {} {} the stamp of another one of the same sonar: a driver that \
             publishes twice, or messages that were recorded twice",
            counted(readings.len() as u64, "reading"),
            if count == 1 { "carries" } else { "carry" }
        )
    })
}

/// Readings that have no pose, where they are many or the odometry was interrupted. Both in stamp
/// order.
pub fn uncovered(
    readings: &Readings,
    samples: &[OdometrySample],
    bounds: &Frames,
    range_delay: f64,
) -> Option<String> {
    let late = libm::round(range_delay * 1e9) as i64;
    let on_their_clock = |stamp_ns: i64| stamp_ns.saturating_add(late);
    let first = on_their_clock(samples.first()?.stamp_ns);
    let last = on_their_clock(samples.last()?.stamp_ns);
    let up_to = |stamp: i64| readings.partition_point(|r| r.stamp_ns <= stamp);
    let below = |stamp: i64| readings.partition_point(|r| r.stamp_ns < stamp);
    let beyond = libm::round(bounds.max_extrapolation * 1e9) as i64;
    let before = below(first.saturating_sub(beyond));
    let after = readings.len() - up_to(last.saturating_add(beyond));
    let (mut gaps, mut within, mut longest) = (0_u64, 0, (0.0, 0));
    for pair in samples.windows(2) {
        let [a, b] = pair else { continue };
        let width = seconds(b.stamp_ns.saturating_sub(a.stamp_ns));
        if width <= bounds.max_odometry_gap {
            continue;
        }
        let [from, to] = [a, b].map(|sample| on_their_clock(sample.stamp_ns));
        let lost = below(to).saturating_sub(up_to(from));
        if lost > 0 {
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
            "{within} in {} of the odometry wider than {} s, the longest {:.1} s at {} s",
            counted(gaps, "gap"),
            bounds.max_odometry_gap,
            longest.0,
            seconds_between(start, longest.1, 1)
        ));
    }
    Some(format!(
        "{lost} of {} {} no pose and {} dropped: {}",
        counted(readings.len() as u64, "reading"),
        if lost == 1 { "has" } else { "have" },
        if lost == 1 { "is" } else { "are" },
        parts.join(", ")
    ))
}

#[cfg(test)]
mod tests;
