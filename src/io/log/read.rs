//! From a file to all that a replay needs of it.

use std::io::{Read, Seek};
use std::path::Path;

use super::LogError;
use super::budget::Budget;
use super::channels::{ChannelReport, Channels};
use super::container::{self, Channel, Loss, RawMessage, Unchecked};
use super::gather::Gatherer;
use super::truth::RecordedTruth;
use crate::core::config::Config;
use crate::core::log::Log;

/// Reads a log.
///
/// # Errors
/// When nothing of it could be replayed; see [`LogError`]. Damage is no error: what could not be
/// read is in [`Log::losses`].
pub fn read(path: &Path, config: &Config) -> Result<Log, LogError> {
    let mut visits = Visits::new(config, length(path))?;
    let take = &mut |channel: &Channel, message: RawMessage<'_>| visits.take(channel, message);
    let walked = container::walk(path, unchecked(config), take);
    let losses = walked.map_err(|error| LogError::open(path, error))?;
    visits.finish(file_name(path), config, losses)
}

/// Reads a log together with the truth that it carries.
///
/// # Errors
/// As [`read`].
pub fn read_with_truth(path: &Path, config: &Config) -> Result<(Log, RecordedTruth), LogError> {
    let mut visits = Visits::new(config, length(path))?;
    let mut truth = RecordedTruth::default();
    let walked = container::walk(path, unchecked(config), &mut |channel, message| {
        truth.take(channel, message);
        visits.take(channel, message);
    });
    let losses = walked.map_err(|error| LogError::open(path, error))?;
    finish_with_truth(visits, truth, file_name(path), config, losses)
}

/// [`read_with_truth`] over anything that can be read from any place; `file` is what it is called.
///
/// # Errors
/// As [`read`].
pub fn read_with_truth_in<R: Read + Seek>(
    mut input: R,
    file: &str,
    config: &Config,
) -> Result<(Log, RecordedTruth), LogError> {
    let failed = |error: container::OpenError| LogError::open(Path::new(file), error);
    let bytes = input.seek(std::io::SeekFrom::End(0));
    let bytes = bytes.map_err(|error| failed(error.into()))?;
    let mut visits = Visits::new(config, bytes)?;
    let mut truth = RecordedTruth::default();
    let walked = container::walk_in(input, unchecked(config), &mut |channel, message| {
        truth.take(channel, message);
        visits.take(channel, message);
    });
    let losses = walked.map_err(failed)?;
    finish_with_truth(visits, truth, file.to_owned(), config, losses)
}

fn finish_with_truth(
    visits: Visits,
    truth: RecordedTruth,
    file: String,
    config: &Config,
    losses: Vec<Loss>,
) -> Result<(Log, RecordedTruth), LogError> {
    let mut log = visits.finish(file, config, losses)?;
    log.losses.extend(truth.loss());
    Ok((log, truth))
}

/// What the messages of a log give, one after the other.
pub(super) struct Visits {
    channels: Channels,
    gatherer: Gatherer,
    budget: Budget,
}

impl Visits {
    pub(super) fn new(config: &Config, file_bytes: u64) -> Result<Self, LogError> {
        Ok(Self {
            channels: Channels::new(config)?,
            gatherer: Gatherer::default(),
            budget: Budget::new(config, file_bytes),
        })
    }

    pub(super) fn take(&mut self, channel: &Channel, message: RawMessage<'_>) {
        let budget = &mut self.budget;
        if let Some(read) = self.channels.read(channel, message, budget) {
            self.gatherer.take(read, message.log_time);
        }
    }

    fn finish(self, file: String, config: &Config, losses: Vec<Loss>) -> Result<Log, LogError> {
        let (gatherer, channels) = self.into_parts(&file)?;
        let lost = losses.clone();
        match gatherer.finish(file, config, channels, losses) {
            Ok(finished) => Ok(finished.log),
            Err(stopped) => Err(stopped.into_error(&lost)),
        }
    }

    /// What was gathered, and of which channels.
    ///
    /// # Errors
    /// When it was more than is held.
    pub(super) fn into_parts(self, file: &str) -> Result<(Gatherer, Vec<ChannelReport>), LogError> {
        self.budget.check(file)?;
        Ok((self.gatherer, self.channels.into_reports()))
    }
}

/// Bytes of a file; 0 where it cannot be told, which opening it will say.
pub(super) fn length(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |metadata| metadata.len())
}

/// What the configuration says of messages without a checksum that holds.
pub(super) fn unchecked(config: &Config) -> Unchecked {
    if config.input.trust_unchecked {
        Unchecked::Used
    } else {
        Unchecked::LeftOut
    }
}

/// A file's name, without its directories.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}
