//! What the checks look at, and how advice is tried before it is given.

use super::facts::Facts;
use super::sonars::SonarFacts;
use super::trial::{Attempt, Explained};
use crate::core::config::Config;
use crate::io::config::file::overridden;
use crate::io::log::survey::Survey;
use crate::io::log::traits::MountTraits;

/// What the checks look at.
pub struct Examined<'a> {
    pub facts: &'a Facts,
    pub survey: &'a Survey,
    /// Replays the log with other keys.
    pub attempt: &'a Attempt<'a>,
}

impl Examined<'_> {
    /// The sonars with what their messages and mounts say besides.
    pub fn sonars(&self) -> impl Iterator<Item = (&SonarFacts, &MountTraits)> {
        let mounts = &self.survey.traits.mounts;
        let sonars = self.facts.sonars.iter();
        sonars.filter_map(|sonar| Some((sonar, mounts.get(sonar.id.index())?)))
    }

    /// What a replay of the log as it is explains; `None` where there was none.
    pub fn explained(&self) -> Option<Explained> {
        self.facts.replay.outcome.as_ref().map(Explained::new)
    }

    /// What a replay explains with other keys, where that is plainly more than as it is, or where there was
    /// none; in words for the end of advice.
    pub fn tried(&self, keys: &str) -> Option<String> {
        self.tried_for(0.0, keys)
    }

    /// The same where it explains at least such a share of the arcs.
    pub fn tried_for(&self, least: f64, keys: &str) -> Option<String> {
        let with = self.explained_with(keys)?;
        (with.share >= least).then(|| self.in_words(with)).flatten()
    }

    /// Of several keys the one with which a replay's map takes the fewest bits, in words, where that is plainly
    /// more than as it is.
    pub fn best<'k>(&self, keys: &'k [String]) -> Option<(&'k str, String)> {
        let tried = keys
            .iter()
            .filter_map(|keys| Some((keys, self.explained_with(keys)?)));
        let (keys, with) = tried.min_by(|(_, a), (_, b)| a.bits.total_cmp(&b.bits))?;
        Some((keys, self.in_words(with)?))
    }

    /// What came of a trial, where that is plainly more than without it.
    fn in_words(&self, with: Explained) -> Option<String> {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        match self.explained() {
            None => Some(format!(
                " (tried: its map explains {} of the arcs)",
                percent(with.share)
            )),
            Some(without) => with.beats(without).then(|| {
                format!(
                    " (tried: its map explains {} of the arcs, {} without)",
                    percent(with.share),
                    percent(without.share)
                )
            }),
        }
    }

    /// What a replay explains with other keys.
    fn explained_with(&self, keys: &str) -> Option<Explained> {
        let config: Config = overridden(&self.survey.config, keys).ok()?;
        (self.attempt)(&config)
    }
}
