//! The stamps of one topic while a log is read.

/// A stamp that moves so much otherwise than the time of recording was made by a clock that was set,
/// nanoseconds.
pub(super) const JUMP: i64 = 1_000_000_000;
/// So many delays are kept of each clock at the most.
pub(super) const KEPT: usize = 1024;

/// The stamps of one sonar, or of the odometry, while a log is read.
#[derive(Debug, Clone, Default)]
pub struct Clock {
    pub(super) first_logged: Option<i64>,
    pub(super) last: Option<(i64, i64)>,
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
                if moved < 0 && self.turned.len() < MOST_RUNS {
                    self.turned.push((stamp_ns, stamp));
                }
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
        let (mut overlaps, mut hole) = (Vec::new(), 0_i64);
        let mut reached: Option<i64> = None;
        for (first, last) in runs {
            if let Some(reached) = reached {
                let end = reached.min(last);
                if end > first {
                    overlaps.push((first, end));
                }
                hole = hole.max(first.saturating_sub(reached));
            }
            reached = Some(reached.map_or(last, |reached| reached.max(last)));
        }
        (overlaps, hole)
    }
}
