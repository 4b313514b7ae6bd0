//! The stamps of one topic while a log is read.

/// A stamp that moves so much otherwise than the time of recording was made by a clock that was set,
/// nanoseconds.
pub(super) const JUMP: i64 = 1_000_000_000;
/// Stamps and times of recording that both go back by more were set back where the log has been through
/// these times before, nanoseconds.
pub(super) const BACK: i64 = 150_000_000;
/// They have been through so many messages at least, or else neighbours may only have changed places.
const SWAPPED: i64 = 4;
/// A clock that was set stamps more messages than this, and a damaged stamp is no more.
const FEW: usize = 3;
/// So many delays are kept of each clock at the most.
pub(super) const KEPT: usize = 1024;

/// The stamps of one sonar, or of the odometry, while a log is read.
#[derive(Debug, Clone, Default)]
pub struct Clock {
    pub(super) first_logged: Option<i64>,
    pub(super) last: Option<(i64, i64)>,
    /// The messages since then, whose stamps do not go on from there.
    suspects: Vec<(i64, i64)>,
    /// Stamps that do not go on from those before them, while those behind them do.
    strays: Vec<i64>,
    pub(super) backward: u64,
    pub(super) farthest_back: i64,
    pub(super) jumps: u64,
    /// Where jumps turned the stamps back: the stamp behind each and the one before it.
    pub(super) turned: Vec<(i64, i64)>,
    /// By how much the largest jump moved the clock and when it was recorded, nanoseconds.
    pub(super) largest: Option<(i64, i64)>,
    pub(super) stamped: u64,
    /// From stamp to recording, of every so-many-th message.
    pub(super) delays: Vec<i64>,
    pub(super) stride: u64,
    /// The last message in the file, stamp and recording.
    pub(super) before: Option<(i64, i64)>,
    /// First and last stamp between one jump of both clocks and the next.
    pub(super) runs: Vec<(i64, i64)>,
    pub(super) returns: u64,
    pub(super) pauses: u64,
    /// The farthest return, nanoseconds.
    pub(super) farthest_return: i64,
}

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
                let strays = self.suspects.drain(..).map(|(stamp, _)| stamp);
                self.strays.extend(strays);
                self.go_on(message);
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

    /// Stamps that a few messages have amid others with which they do not go together: damaged ones.
    pub fn strays(&self) -> Vec<i64> {
        let mut strays = self.strays.clone();
        // At the end of a log no others follow.
        if self.jumps == 0 && self.stamped > 10 * self.suspects.len() as u64 {
            strays.extend(self.suspects.iter().map(|(stamp, _)| *stamp));
        }
        strays
    }

    /// Takes the strays of another clock, whose other messages count for nothing.
    pub fn absorb(&mut self, other: Self) {
        self.strays.extend(other.strays());
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
    pub(super) fn overlap_and_hole(&self) -> (i64, i64) {
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
    pub(super) fn twice(&self) -> Vec<(i64, i64)> {
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
