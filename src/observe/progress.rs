//! How far a replay or a sweep has come, on a terminal; nothing elsewhere.

use std::io::{self, IsTerminal as _, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError, Setting};
use crate::core::tmam::step::Step;

/// A line on standard error that is written over and over, and gone at the end.
#[derive(Debug)]
struct ProgressLine {
    whole: u64,
    is_shown: bool,
    written: Option<Instant>,
}

impl ProgressLine {
    fn new(whole: u64, is_wanted: bool) -> Self {
        Self {
            whole,
            is_shown: is_wanted && io::stderr().is_terminal(),
            written: None,
        }
    }

    fn tell(&mut self, done: u64, what: &str) {
        const OFTEN_ENOUGH: Duration = Duration::from_millis(100);
        const WIDTH: usize = 40;
        let is_recent = |at: Instant| at.elapsed() < OFTEN_ENOUGH;
        if !self.is_shown || self.written.is_some_and(is_recent) {
            return;
        }
        self.written = Some(Instant::now());
        let share = (done as f64 / self.whole.max(1) as f64).min(1.0);
        let bar = "#".repeat((share * WIDTH as f64) as usize);
        let percent = 100.0 * share;
        let _ = write!(
            io::stderr(),
            "\r\x1b[2K[{bar:<WIDTH$}] {percent:>3.0} %  {what}"
        );
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if self.written.is_some() {
            let _ = write!(io::stderr(), "\r\x1b[2K");
        }
    }
}

/// What is being done, where nobody knows how much is left of it.
#[derive(Debug)]
pub struct Doing(ProgressLine);

impl Doing {
    pub fn new(is_wanted: bool) -> Self {
        Self(ProgressLine::new(0, is_wanted))
    }

    /// From now on it is this.
    pub fn tell(&mut self, what: &str) {
        if self.0.is_shown {
            self.0.written = Some(Instant::now());
            let _ = write!(io::stderr(), "\r\x1b[2K{what} ...");
        }
    }
}

/// How far a replay has come in the log's own time.
#[derive(Debug)]
pub struct Progress {
    line: ProgressLine,
    start_ns: i64,
}

impl Progress {
    pub fn new(setting: &Setting<'_>, is_wanted: bool) -> Self {
        let source = setting.source;
        let span = source.end_ns.saturating_sub(source.start_ns);
        Self {
            line: ProgressLine::new(u64::try_from(span).unwrap_or_default(), is_wanted),
            start_ns: source.start_ns,
        }
    }
}

impl Observer for Progress {
    fn frame(&mut self, frame: &Frame, _: &Step) -> Result<(), ObserverError> {
        let passed = frame.stamp_ns.saturating_sub(self.start_ns);
        let passed = u64::try_from(passed).unwrap_or_default();
        self.line.tell(passed, &format!("frame {}", frame.index));
        Ok(())
    }

    fn finish(&mut self, _: &Step) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// How many of several replays are done, from any thread.
#[derive(Debug)]
pub struct ReplaysProgress {
    /// What is replayed: `cells`, `logs`.
    of: &'static str,
    done: Mutex<(ProgressLine, u64)>,
}

impl ReplaysProgress {
    pub fn new(replays: usize, of: &'static str, is_wanted: bool) -> Self {
        Self {
            of,
            done: Mutex::new((ProgressLine::new(replays as u64, is_wanted), 0)),
        }
    }

    /// One more is done.
    pub fn tick(&self) {
        let mut held = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        let (line, done) = &mut *held;
        *done += 1;
        line.tell(*done, &format!("{done} of {} {}", line.whole, self.of));
    }
}
