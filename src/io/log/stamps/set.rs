//! Clocks that were set while the log was recorded.

use super::clock::BACK;
use super::{Clock, seconds};
use crate::core::wording::{counted, times};

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
