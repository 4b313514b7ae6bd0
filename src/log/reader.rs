//! Reads a log, with or without the truth that it carries.

use std::io::{Read, Seek};
use std::path::Path;

use super::channels::Channels;
use super::container::{self, Channel, Loss, RawMessage};
use super::gather::Gatherer;
use super::truth::RecordedTruth;
use super::{Log, LogError, file_name};
use crate::config::Config;

/// Reads a log.
///
/// # Errors
/// When nothing of it could be replayed; see [`LogError`]. Damage is no error: what could not be
/// read is in [`Log::losses`].
pub fn read(path: &Path, config: &Config) -> Result<Log, LogError> {
    let mut visits = Visits::new(config)?;
    let walked = container::walk(path, &mut |channel, message| visits.take(channel, message));
    let losses = walked.map_err(|error| LogError::open(path, error))?;
    visits.finish(file_name(path), config, losses)
}

/// Reads a log together with the truth that it carries.
///
/// # Errors
/// As [`read`].
pub fn read_with_truth(path: &Path, config: &Config) -> Result<(Log, RecordedTruth), LogError> {
    let mut visits = Visits::new(config)?;
    let mut truth = RecordedTruth::default();
    let walked = container::walk(path, &mut |channel, message| {
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
    input: R,
    file: &str,
    config: &Config,
) -> Result<(Log, RecordedTruth), LogError> {
    let mut visits = Visits::new(config)?;
    let mut truth = RecordedTruth::default();
    let walked = container::walk_in(input, &mut |channel, message| {
        truth.take(channel, message);
        visits.take(channel, message);
    });
    let losses = walked.map_err(|error| LogError::open(Path::new(file), error))?;
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
struct Visits {
    channels: Channels,
    gatherer: Gatherer,
}

impl Visits {
    fn new(config: &Config) -> Result<Self, LogError> {
        Ok(Self {
            channels: Channels::new(config)?,
            gatherer: Gatherer::default(),
        })
    }

    fn take(&mut self, channel: &Channel, message: RawMessage<'_>) {
        if let Some((role, content)) = self.channels.read(channel, message) {
            let topic = &channel.topic;
            self.gatherer.take(role, topic, message.log_time, content);
        }
    }

    fn finish(self, file: String, config: &Config, losses: Vec<Loss>) -> Result<Log, LogError> {
        let lost: Vec<String> = losses.iter().map(ToString::to_string).collect();
        self.gatherer
            .finish(file, config, self.channels.into_reports(), losses)
            .map_err(|error| match error {
                // What is missing may be what was lost.
                error if !lost.is_empty() => LogError::Damaged {
                    source: Box::new(error),
                    losses: lost,
                },
                error => error,
            })
    }
}
