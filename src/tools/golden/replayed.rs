//! A log replayed for what it gives, with nothing recorded.

use std::path::Path;

use super::collect;
use super::error::GoldenError;
use super::file::LogInfo;
use super::range_noise::RangeNoise;
use super::results::Results;
use crate::core::config::Config;
use crate::core::log::Log;
use crate::core::replay::Replay;
use crate::io::log;

/// A log and what its replay gave.
#[derive(Debug)]
pub struct Replayed {
    /// The log.
    pub log: Log,
    /// Its name and digest.
    pub info: LogInfo,
    /// What the replay gave.
    pub results: Results,
    /// Readings in which something echoed.
    pub echoes: u64,
}

/// Replays a log.
///
/// # Errors
/// As a replay fails.
pub fn replay(path: &Path, config: &Config) -> Result<Replayed, GoldenError> {
    let log = log::read(path, config)?;
    let (results, echoes) = {
        let replay = Replay::new(&log, config)?;
        let outcome = replay.run(&mut [])?;
        let results = Results {
            noise: RangeNoise::of(outcome.variance_from, replay.config()),
            ..collect::results(&log.events.sonars, &outcome)
        };
        (results, outcome.tally.echoes)
    };
    Ok(Replayed {
        info: LogInfo::of(&log),
        log,
        results,
        echoes,
    })
}
