//! From a file to all that a replay needs of it.

use std::io::{Read, Seek};
use std::path::Path;

use super::assemble::assemble;
use super::channels::{ChannelReport, Channels};
use super::container::{self, Channel, Loss, OpenError, RawMessage, Unchecked};
use super::error::LogError;
use super::gather::Gatherer;
use super::message::Content;
use super::truth::RecordedTruth;
use crate::core::config::Config;
use crate::core::legible::name;
use crate::core::log::Log;

/// The messages of a log, decoded once, to be put together under one configuration after another.
#[derive(Debug)]
pub struct Gathered {
    file: String,
    gatherer: Gatherer,
    channels: Vec<ChannelReport>,
    losses: Vec<Loss>,
    truth: RecordedTruth,
}

/// Reads a log.
///
/// # Errors
/// When nothing of it could be replayed; see [`LogError`]. Damage is no error: what could not be
/// read is in [`Log::losses`].
pub fn read(path: &Path, config: &Config) -> Result<Log, LogError> {
    let gathered = Gathered::open(path, config, false)?;
    gathered.into_log(config).map(|(log, _)| log)
}

/// Reads a log together with the truth that it carries.
///
/// # Errors
/// As [`read`].
pub fn read_with_truth(path: &Path, config: &Config) -> Result<(Log, RecordedTruth), LogError> {
    Gathered::read(path, config)?.into_log(config)
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
    let walk = |take: &mut Take<'_>| container::walk_in(input, unchecked(config), take);
    Gathered::new(Path::new(file), config, true, walk)?.into_log(config)
}

type Take<'t> = dyn FnMut(&Channel, RawMessage<'_>) + 't;

impl Gathered {
    /// Reads a log with its truth. Of the configuration only what chooses and decodes messages matters:
    /// topics and `channel`.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn read(path: &Path, config: &Config) -> Result<Self, LogError> {
        Self::open(path, config, true)
    }

    fn open(path: &Path, config: &Config, with_truth: bool) -> Result<Self, LogError> {
        let drives = container::drives(path);
        if let [first, _, ..] = drives.as_slice() {
            return Err(LogError::Several {
                folder: path.to_owned(),
                logs: drives.len(),
                first: first.clone(),
            });
        }
        let walk = |take: &mut Take<'_>| container::walk(path, unchecked(config), take);
        Self::new(path, config, with_truth, walk)
    }

    fn new(
        path: &Path,
        config: &Config,
        with_truth: bool,
        walk: impl FnOnce(&mut Take<'_>) -> Result<Vec<Loss>, OpenError>,
    ) -> Result<Self, LogError> {
        let mut channels = Channels::new(config)?;
        let mut gatherer = Gatherer::new(config);
        take_mounts_from(config, &mut gatherer)?;
        let mut truth = RecordedTruth::default();
        let losses = walk(&mut |channel, message| {
            if with_truth {
                truth.take(channel, message);
            }
            if let Some(read) = channels.read(channel, message) {
                gatherer.take(read, message.log_time);
            }
        });
        let losses = losses.map_err(|error| LogError::open(path, error))?;
        let file = file_name(path);
        Ok(Self {
            channels: channels.into_reports(&file)?,
            file,
            gatherer,
            losses,
            truth,
        })
    }

    /// The log under a configuration.
    ///
    /// # Errors
    /// As [`read`].
    pub fn log(&self, config: &Config) -> Result<Log, LogError> {
        self.assembled(self.gatherer.clone(), config)
    }

    fn into_log(mut self, config: &Config) -> Result<(Log, RecordedTruth), LogError> {
        let gatherer = std::mem::take(&mut self.gatherer);
        Ok((self.assembled(gatherer, config)?, self.truth))
    }

    fn assembled(&self, gatherer: Gatherer, config: &Config) -> Result<Log, LogError> {
        let (file, channels) = (self.file.clone(), self.channels.clone());
        let found = assemble(gatherer, file, config, channels, &self.losses);
        let mut log = (found.map_err(|stopped| stopped.into_error(&self.losses))?).log;
        log.losses.extend(self.truth.losses());
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

/// Takes what another log says of the robot's frames that never move, where the configuration names one.
///
/// # Errors
/// When that log cannot be read.
pub fn take_mounts_from(config: &Config, gatherer: &mut Gatherer) -> Result<(), LogError> {
    let Some(path) = config.input.mounts_from.as_deref().map(Path::new) else {
        return Ok(());
    };
    let mut channels = Channels::new(config)?;
    let walked = container::walk(path, unchecked(config), &mut |channel, message| {
        if let Some(read) = channels.read(channel, message)
            && match read.content {
                Content::Transforms(_) => read.topic.ends_with("tf_static"),
                Content::Description(_) => true,
                _ => false,
            }
        {
            gatherer.take(read, message.log_time);
        }
    });
    gatherer.messages = 0;
    walked.map_err(|error| LogError::open(path, error))?;
    Ok(())
}

/// What the configuration says of messages without a checksum that holds.
pub fn unchecked(config: &Config) -> Unchecked {
    match config.input.trust_unchecked {
        true => Unchecked::Used,
        false => Unchecked::LeftOut,
    }
}

/// A file's name, without its directories.
pub fn file_name(path: &Path) -> String {
    let file = path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    );
    name(&file).into_owned()
}
