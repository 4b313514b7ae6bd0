//! A log as a replay takes it.

use crate::core::event::Events;

/// A log as far as it could be read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Log {
    /// Its file name, without directories.
    pub file: String,
    pub events: Events,
    /// Messages that were used.
    pub messages: u64,
    /// What could not be read of it; empty for a whole log.
    pub losses: Vec<String>,
    /// What is odd about its stamps, the weightiest first.
    pub time_notes: Vec<String>,
    /// What else a person should know of it.
    pub notes: Vec<String>,
}

impl Log {
    /// What a person should know of it, the weightiest first.
    pub fn told(&self) -> Vec<String> {
        [self.time_notes.as_slice(), &self.notes].concat()
    }
}
