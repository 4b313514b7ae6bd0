//! The messages of a log, decoded once, to be put together under one configuration after another.

use std::path::Path;

use super::LogError;
use super::channels::ChannelReport;
use super::container::{self, Loss};
use super::gather::Gatherer;
use super::read::{Visits, file_name, length, unchecked};
use super::truth::RecordedTruth;
use crate::core::config::Config;
use crate::core::log::Log;

/// What the messages of a log say, before it is known where the sonars sit.
#[derive(Debug)]
pub struct Gathered {
    file: String,
    gatherer: Gatherer,
    channels: Vec<ChannelReport>,
    losses: Vec<Loss>,
    truth: RecordedTruth,
}

impl Gathered {
    /// Reads a log. Of the configuration only what chooses and decodes messages matters: topics and
    /// `channel`.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn read(path: &Path, config: &Config) -> Result<Self, LogError> {
        let mut visits = Visits::new(config, length(path))?;
        let mut truth = RecordedTruth::default();
        let walked = container::walk(path, unchecked(config), &mut |channel, message| {
            truth.take(channel, message);
            visits.take(channel, message);
        });
        let losses = walked.map_err(|error| LogError::open(path, error))?;
        let file = file_name(path);
        let (gatherer, channels) = visits.into_parts(&file)?;
        Ok(Self {
            file,
            channels,
            gatherer,
            losses,
            truth,
        })
    }

    /// The log under a configuration.
    ///
    /// # Errors
    /// As [`super::read`].
    pub fn log(&self, config: &Config) -> Result<Log, LogError> {
        let (gatherer, losses) = (self.gatherer.clone(), self.losses.clone());
        let found = gatherer.finish(self.file.clone(), config, self.channels.clone(), losses);
        let mut log = found
            .map_err(|stopped| stopped.into_error(&self.losses))?
            .log;
        log.losses.extend(self.truth.loss());
        Ok(log)
    }

    /// Its file name, without directories.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The truth that the log carries.
    pub fn truth(&self) -> &RecordedTruth {
        &self.truth
    }
}
