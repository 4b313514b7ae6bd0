//! What a log holds and whether it can be replayed.
//!
//! [`Info`] goes as far as the log does: what stands in the way of a replay becomes a [`Finding`],
//! and what a configuration can mend becomes a line of the [`skeleton`]. It reads events, not
//! files, and is shown as [`text`] for people or as JSON (`tmam.info/1`, `docs/formats.md`) for machines.

pub mod skeleton;
pub mod text;

use std::io::{self, Write};

use serde::Serialize;

use crate::core::least_explained::least_explained;
use crate::core::replay::{CauseTold, Replay, Stretch};
use crate::io::log::survey::Survey;
use crate::observe::causes;
use crate::tools::document;
use crate::tools::findings::examined::Examined;
use crate::tools::findings::facts::Facts;
use crate::tools::findings::finding::Finding;
use crate::tools::findings::trial::{Attempt, Replayable};
use crate::tools::findings::{causes as causes_of, findings};

/// Everything that is told of a log.
#[derive(Debug, Serialize)]
pub struct Info {
    #[serde(flatten)]
    pub facts: Facts,
    /// The weightiest first.
    pub findings: Vec<Finding>,
    /// What is off, the weightiest first; `None` where it was not looked for.
    pub causes: Option<Vec<CauseTold>>,
    /// What the configuration lacks.
    pub skeleton: Option<String>,
}

impl Info {
    /// Tells all of a surveyed log; `attempt` replays it with other keys.
    pub fn new(survey: &Survey, attempt: &Attempt<'_>) -> Self {
        let facts = Facts::new(survey, None);
        let findings = findings(&Examined {
            facts: &facts,
            survey,
            attempt,
        });
        Self {
            skeleton: skeleton::skeleton(&facts, &survey.obstacles),
            findings,
            facts,
            causes: None,
        }
    }

    /// Looks for what is off, where the log can be replayed as it is.
    pub fn look_for_causes(&mut self, survey: &Survey) {
        let trial = &self.facts.replay;
        let replay = Replay::new(&survey.log, &trial.config);
        if let (Replayable::Yes, Some(outcome), Ok(replay)) =
            (trial.possible, &trial.outcome, replay)
        {
            let by_physics = causes_of(&self.findings);
            self.causes = match by_physics.is_empty() {
                true => causes::look_for(&replay, outcome),
                false => Some(by_physics),
            };
            let stretch = least_explained(&replay, outcome);
            if let Some(outcome) = &mut self.facts.replay.outcome {
                outcome.stretch = stretch;
            }
        }
    }

    /// The stretch in which something was off.
    pub fn stretch(&self) -> Option<&Stretch> {
        self.facts.replay.outcome.as_ref()?.stretch.as_ref()
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
