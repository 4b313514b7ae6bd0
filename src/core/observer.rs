//! What watches a replay, and what it is told before the first frame.

use serde::Serialize;

use crate::core::config::Config;
use crate::core::event::{Events, Sonar};
use crate::core::frames::Frame;
use crate::core::geometry::Vec2;
use crate::core::tmam::step::Step;

/// Where the events came from: what a reader of an output file must know of its source.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Source {
    /// File name of the log, without its directory.
    pub file: String,
    /// Messages read from the channels in use.
    pub messages: u64,
    /// Stamp of the first reading used.
    pub start_ns: i64,
    /// Stamp of the last reading used.
    pub end_ns: i64,
    /// Whether the log was read to its end without loss.
    pub complete: bool,
    /// What could not be read; empty for a complete log.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lost: Vec<String>,
    /// What else a person should know of the log.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

/// What stands fixed before the first frame.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// Every sonar of the log, sorted by name.
    pub sonars: &'a [Sonar],
    /// Every parameter in use.
    pub config: &'a Config,
    /// The log.
    pub source: &'a Source,
    /// All that was read from it.
    pub events: &'a Events,
    /// The SHA-256 of its events.
    pub events_sha256: &'a str,
    /// Stamp of the log's first reading, in the window or not: what seconds are counted from.
    pub origin_ns: i64,
    /// Where the robot was first, metres in the world; the origin where that is not known.
    pub start: Vec2,
}

/// Something that watches a replay and changes nothing in it.
pub trait Observer {
    /// One frame and what it brought about.
    ///
    /// # Errors
    /// When what it saw cannot be written.
    fn frame(&mut self, frame: &Frame, step: &Step) -> Result<(), ObserverError>;

    /// The end: `step` holds the labels and features that waited for a next reading, and a report on
    /// every arc.
    ///
    /// # Errors
    /// When what it saw cannot be written.
    fn finish(&mut self, step: &Step) -> Result<(), ObserverError>;
}

/// Keeps what a replay brought about, for an observer that must know first what it comes to.
#[derive(Debug, Default)]
pub struct Kept {
    frames: Vec<(Frame, Step)>,
    last: Step,
}

impl Kept {
    /// Shows all of it.
    ///
    /// # Errors
    /// When what the observer saw cannot be written.
    pub fn show(&self, observer: &mut dyn Observer) -> Result<(), ObserverError> {
        for (frame, step) in &self.frames {
            observer.frame(frame, step)?;
        }
        observer.finish(&self.last)
    }
}

impl Observer for Kept {
    fn frame(&mut self, frame: &Frame, step: &Step) -> Result<(), ObserverError> {
        self.frames.push((frame.clone(), step.clone()));
        Ok(())
    }

    fn finish(&mut self, step: &Step) -> Result<(), ObserverError> {
        self.last = step.clone();
        Ok(())
    }
}

/// Why an observer could not go on; says itself what it could not do.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ObserverError(Box<dyn std::error::Error + Send + Sync>);

impl ObserverError {
    /// Wraps an observer's own error.
    pub fn new(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self(Box::new(error))
    }
}
