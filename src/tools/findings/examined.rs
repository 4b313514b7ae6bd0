//! What the checks look at, and how advice is tried before it is given.

use std::fmt;

use super::facts::Facts;
use super::sonars::SonarFacts;
use super::trial::{Attempt, Explained};
use crate::core::config::{Config, Method};
use crate::io::config::file::overridden;
use crate::io::log::survey::Survey;
use crate::io::log::traits::MountTraits;

/// A log of more readings is not replayed to try what nothing in it points at.
const LONG: usize = 100_000;

/// Of the arcs of a log in which nothing is wrong more are explained.
const NEARLY_ALL: f64 = 0.95;

/// Keys that were tried, and that help.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// A line each.
    pub keys: String,
    /// What a replay explains with them.
    pub with: Explained,
    /// What it explains as it is; `None` where it cannot be replayed.
    pub without: Option<Explained>,
}

impl Tried {
    /// The keys as text: `a = 1, b = 2`.
    pub fn named(&self) -> String {
        self.keys.lines().collect::<Vec<_>>().join(", ")
    }

    /// Whether nearly all is explained with them, or at least half of what was not: they mend what is wrong, and do
    /// not merely help.
    pub fn is_most(&self) -> bool {
        self.with.share > NEARLY_ALL || self.leaves_half()
    }

    /// Whether no more than half of what was not explained is left.
    pub fn leaves_half(&self) -> bool {
        let without = self.without.map_or(0.0, |without| without.share);
        1.0 - self.with.share <= (1.0 - without) / 2.0
    }
}

/// For the end of advice.
impl fmt::Display for Tried {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let with = 100.0 * self.with.share;
        write!(f, " (tried: its map explains {with:.0} % of the arcs")?;
        match self.without {
            Some(without) => write!(f, ", {:.0} % without)", 100.0 * without.share),
            None => f.write_str(")"),
        }
    }
}

/// What came of a trial in words, or nothing where there was none.
pub fn in_words(tried: Option<&Tried>) -> String {
    tried.map(Tried::to_string).unwrap_or_default()
}

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

    /// Whether many replays of it would take long.
    pub fn is_long(&self) -> bool {
        self.survey.log.events.readings.len() > LONG
    }

    /// What a replay of the log as it is explains; `None` where there was none.
    pub fn explained(&self) -> Option<Explained> {
        self.facts.replay.explained()
    }

    /// What a replay explains with other keys, where that is plainly more than as it is, or where there was
    /// none.
    pub fn tried(&self, keys: &str) -> Option<Tried> {
        self.tried_for(0.0, keys)
    }

    /// The same where it explains at least such a share of the arcs.
    pub fn tried_for(&self, least: f64, keys: &str) -> Option<Tried> {
        let with = self.explained_with(keys)?;
        let without = self.explained();
        let helps = with.share >= least && without.is_none_or(|without| with.beats(without));
        helps.then(|| Tried {
            keys: keys.to_owned(),
            with,
            without,
        })
    }

    /// Of several keys those with which a replay's map takes the fewest bits, where that is plainly more than as it
    /// is.
    pub fn best(&self, keys: &[String]) -> Option<Tried> {
        let tried = keys.iter().filter_map(|keys| self.tried(keys));
        tried.min_by(|a, b| a.with.bits.total_cmp(&b.with.bits))
    }

    /// Whether a replay explains less with other keys.
    pub fn worsens(&self, keys: &str) -> bool {
        let both = self.explained_with(keys).zip(self.explained());
        both.is_some_and(|(with, without)| with.bits > without.bits && with.share <= without.share)
    }

    /// What a replay explains with other keys.
    fn explained_with(&self, keys: &str) -> Option<Explained> {
        // The map of a rival does not say what should have echoed, so that nothing it is tried with outdoes it.
        let is_rival = self.survey.config.method != Method::Tmam;
        if is_rival && self.facts.replay.outcome.is_some() {
            return None;
        }
        let config: Config = overridden(&self.survey.config, keys).ok()?;
        (self.attempt)(&config)
    }
}
