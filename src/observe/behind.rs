//! An observer on a thread of its own, behind the replay that it watches.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};

use crate::core::frames::Frame;
use crate::core::observer::{Observer, ObserverError};
use crate::core::tmam::step::Step;

/// Frames that may wait for the observer.
const AHEAD: usize = 64;

/// An observer that sees a replay where that runs, or behind it on a thread of its own. What it sees is the same,
/// in the same order.
pub enum Behind<'scope, O> {
    Here(O),
    There {
        /// `None` once the replay has ended.
        seen: Option<SyncSender<Seen>>,
        /// `None` once it was found to have failed.
        thread: Option<ScopedJoinHandle<'scope, Result<O, ObserverError>>>,
    },
}

/// What an observer is shown: a frame and its step, or the end.
type Seen = (Option<Frame>, Step);

impl<'scope, O: Observer + Send + 'scope> Behind<'scope, O> {
    /// On a thread of its own where there is a scope for it.
    pub fn new(observer: O, scope: Option<&'scope Scope<'scope, '_>>) -> Self {
        let Some(scope) = scope else {
            return Self::Here(observer);
        };
        let (seen, shown) = sync_channel(AHEAD);
        Self::There {
            seen: Some(seen),
            thread: Some(scope.spawn(move || watch(observer, &shown))),
        }
    }

    /// The observer, once it has seen all.
    ///
    /// # Errors
    /// When what it saw could not be written.
    pub fn into_observer(self) -> Result<Option<O>, ObserverError> {
        match self {
            Self::Here(observer) => Ok(Some(observer)),
            Self::There { seen, thread } => {
                drop(seen);
                thread.map(joined).transpose()
            }
        }
    }

    fn show(
        seen: Option<&SyncSender<Seen>>,
        thread: &mut Option<ScopedJoinHandle<'scope, Result<O, ObserverError>>>,
        what: Seen,
    ) -> Result<(), ObserverError> {
        if seen.is_some_and(|seen| seen.send(what).is_ok()) {
            return Ok(());
        }
        // It takes nothing more: it has failed.
        thread.take().map(joined).transpose().map(|_| ())
    }
}

fn watch<O: Observer>(mut observer: O, shown: &Receiver<Seen>) -> Result<O, ObserverError> {
    for (frame, step) in shown {
        match frame {
            Some(frame) => observer.frame(&frame, &step)?,
            None => observer.finish(&step)?,
        }
    }
    Ok(observer)
}

fn joined<O>(thread: ScopedJoinHandle<'_, Result<O, ObserverError>>) -> Result<O, ObserverError> {
    let ended = thread.join();
    ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

impl<'scope, O: Observer + Send + 'scope> Observer for Behind<'scope, O> {
    fn frame(&mut self, frame: &Frame, step: &Step) -> Result<(), ObserverError> {
        match self {
            Self::Here(observer) => observer.frame(frame, step),
            Self::There { seen, thread } => {
                let what = (Some(frame.clone()), step.clone());
                Self::show(seen.as_ref(), thread, what)
            }
        }
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        match self {
            Self::Here(observer) => observer.finish(step),
            Self::There { seen, thread } => {
                Self::show(seen.take().as_ref(), thread, (None, step.clone()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts what it sees, and fails at some frame.
    struct Counter {
        frames: u32,
        ends: u32,
        fails_at: u32,
    }

    #[derive(Debug, thiserror::Error)]
    #[error("full")]
    struct Full;

    impl Observer for Counter {
        fn frame(&mut self, frame: &Frame, _: &Step) -> Result<(), ObserverError> {
            assert_eq!(frame.index, self.frames);
            self.frames += 1;
            match frame.index == self.fails_at {
                true => Err(ObserverError::new(Full)),
                false => Ok(()),
            }
        }

        fn finish(&mut self, _: &Step) -> Result<(), ObserverError> {
            self.ends += 1;
            Ok(())
        }
    }

    fn run(with_thread: bool, fails_at: u32) -> Result<(u32, u32), ObserverError> {
        std::thread::scope(|scope| {
            let counter = Counter {
                frames: 0,
                ends: 0,
                fails_at,
            };
            let mut behind = Behind::new(counter, with_thread.then_some(scope));
            for index in 0..500 {
                let frame = Frame {
                    index,
                    stamp_ns: 0,
                    world_from_robot: crate::core::geometry::Pose2::IDENTITY,
                    correction: None,
                    entries: Vec::new(),
                };
                behind.frame(&frame, &Step::default())?;
            }
            behind.finish(&Step::default())?;
            let counter = behind.into_observer()?;
            Ok(counter.map_or((0, 0), |counter| (counter.frames, counter.ends)))
        })
    }

    #[test]
    fn it_sees_all_in_order_and_its_failure_is_told() {
        for with_thread in [false, true] {
            assert_eq!(run(with_thread, 1000).unwrap(), (500, 1));
            for fails_at in [0, 300, 499] {
                let failed = run(with_thread, fails_at).unwrap_err();
                assert_eq!(failed.to_string(), "full", "{with_thread} {fails_at}");
            }
        }
    }
}
