//! A progress bar on a terminal; nothing elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError, Setting};
use crate::core::tmam::step::Step;

/// How far the replay has come in the log's own time.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    start_ns: i64,
}

impl Progress {
    /// A bar on standard error, drawn only where that is a terminal.
    pub fn new(setting: &Setting<'_>) -> Self {
        let source = setting.source;
        let span = source.end_ns.saturating_sub(source.start_ns);
        let bar = ProgressBar::with_draw_target(
            Some(u64::try_from(span).unwrap_or_default()),
            ProgressDrawTarget::stderr(),
        );
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3}%  {msg}") {
            bar.set_style(style);
        }
        Self {
            bar,
            start_ns: source.start_ns,
        }
    }
}

impl Observer for Progress {
    fn frame(&mut self, frame: &Frame, _: &Step) -> Result<(), ObserverError> {
        let passed = frame.stamp_ns.saturating_sub(self.start_ns);
        self.bar
            .set_position(u64::try_from(passed).unwrap_or_default());
        if frame.index.is_multiple_of(64) {
            self.bar.set_message(format!("frame {}", frame.index));
        }
        Ok(())
    }

    fn finish(&mut self, _: &Step) -> Result<(), ObserverError> {
        self.bar.finish_and_clear();
        Ok(())
    }
}

/// How many cells of a sweep are done, from any thread.
#[derive(Debug)]
pub struct CellProgress(ProgressBar);

impl CellProgress {
    /// A bar on standard error, drawn only where that is a terminal.
    pub fn new(cells: usize) -> Self {
        let target = ProgressDrawTarget::stderr();
        let bar = ProgressBar::with_draw_target(Some(cells as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos} of {len} cells, {eta} left")
        {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// One more is done.
    pub fn tick(&self) {
        self.0.inc(1);
    }
}

impl Drop for CellProgress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
