//! What is kept of a log that differs: what it gives now, and a recording with the differences.

use std::path::{Path, PathBuf};

use super::overlay::overlay;
use super::report::CheckError;
use crate::core::observer::Kept;
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::io::output::{Output, write_whole};
use crate::observe::recording::Recording;
use crate::observe::viewer;
use crate::tools::carried::carried;
use crate::tools::golden::{Comparison, Golden};

/// A replay and all that it brought about: what to mark in a recording is known only at its end.
#[derive(Debug)]
pub struct Replayed<'a> {
    pub replay: Replay<'a>,
    pub outcome: Outcome,
    pub kept: Kept,
}

/// A directory for artefacts.
#[derive(Debug)]
pub struct Artifacts {
    directory: PathBuf,
    around: Option<u32>,
}

impl Artifacts {
    /// Into a directory that exists; `around`: record only so many frames about each difference.
    pub fn new(directory: PathBuf, around: Option<u32>) -> Self {
        Self { directory, around }
    }

    /// Writes the golden file that would make the log pass, and the recording, where this tmam writes
    /// recordings.
    ///
    /// # Errors
    /// When one of them cannot be written.
    pub fn write(
        &self,
        log: &Path,
        replayed: &Replayed<'_>,
        golden: &Golden,
        new: &Golden,
        found: &Comparison,
    ) -> Result<(PathBuf, Option<PathBuf>), CheckError> {
        let written = self.write_golden(log, new)?;
        let (Some(info), true) = (&new.log, viewer::IS_BUILT_IN) else {
            return Ok((written, None));
        };
        let [_, path] = artifacts_of(log, &self.directory);
        let mut out = Output::create(&path)?;
        let setting = replayed.replay.setting();
        let over = overlay(golden, &new.results, found, self.around);
        let mut recording = Recording::new(Some(&mut out), None, setting, over)?;
        replayed
            .kept
            .show(&mut recording)
            .map_err(ReplayError::from)?;
        let carried = carried(&setting, &replayed.outcome, info)?;
        recording.close(Some(&carried))?;
        out.commit()?;
        Ok((written, Some(path)))
    }

    /// Writes a golden file that a log could have.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write_golden(&self, log: &Path, golden: &Golden) -> Result<PathBuf, CheckError> {
        let [path, _] = artifacts_of(log, &self.directory);
        write_whole(&path, &golden.render()?)?;
        Ok(path)
    }

    /// Takes away what an earlier run left of a log.
    pub fn clear(&self, log: &Path) {
        for path in artifacts_of(log, &self.directory) {
            // What is not there need not go.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The files that may be kept of a log: the golden file that it would get, and the recording.
pub fn artifacts_of(log: &Path, directory: &Path) -> [PathBuf; 2] {
    let stem = log.file_stem().unwrap_or(log.as_os_str());
    [".golden.json.new", ".check.rrd"].map(|extension| {
        let mut name = stem.to_owned();
        name.push(extension);
        directory.join(name)
    })
}
