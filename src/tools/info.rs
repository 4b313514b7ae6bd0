//! What a log holds and whether it can be replayed.
//!
//! [`Info`] goes as far as the log does: what stands in the way of a replay becomes a [`Finding`],
//! and what a configuration can mend becomes a line of the [`skeleton`]. It reads events, not
//! files, and is shown as [`text`] for people or as JSON (`tmam.info/1`, `docs/formats.md`) for machines.

pub mod facts;
pub mod finding;
pub mod findings;
mod obstacles;
pub mod odometry;
pub mod skeleton;
pub mod sonars;
pub mod text;
pub mod trial;

use std::io::{self, Write};

use serde::Serialize;

use crate::io::log::survey::Survey;
use crate::tools::document;
use facts::Facts;
use finding::Finding;
use trial::Replayable;

/// Everything that is told of a log.
#[derive(Debug, Serialize)]
pub struct Info {
    #[serde(flatten)]
    pub facts: Facts,
    /// The weightiest first.
    pub findings: Vec<Finding>,
    /// What the configuration lacks.
    pub skeleton: Option<String>,
}

impl Info {
    /// Tells all of a surveyed log.
    pub fn new(mut survey: Survey) -> Self {
        let notes = std::mem::take(&mut survey.log.notes);
        let obstacles = std::mem::take(&mut survey.obstacles);
        let facts = Facts::new(survey, &obstacles);
        Self {
            skeleton: skeleton::skeleton(&facts, &obstacles),
            findings: findings::findings(&facts, &obstacles, &notes),
            facts,
        }
    }

    /// Whether the log is whole, can be replayed as it is, and holds an echo.
    pub fn is_fine(&self) -> bool {
        let Facts { source, replay, .. } = &self.facts;
        let echoes = replay.outcome.as_ref().map_or(0, |o| o.tally.echoes);
        replay.possible == Replayable::Yes && source.lost.is_empty() && echoes > 0
    }

    /// Writes it in JSON.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        document::write(out, "tmam.info/1", self)
    }
}

#[cfg(test)]
mod tests;
