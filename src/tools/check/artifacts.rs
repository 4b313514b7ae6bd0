//! What is kept of a log that differs: what it gives now, and a recording with the differences.

use std::path::{Path, PathBuf};

use super::overlay::overlay;
use super::report::CheckError;
use crate::core::replay::Replay;
use crate::io::output::{Output, write_whole};
use crate::observe::recording::Recording;
use crate::tools::carried::carried;
use crate::tools::golden::{Comparison, Golden, LogInfo, Results};

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

    /// Writes the golden file that would make the log pass, and the recording.
    ///
    /// # Errors
    /// When one of them cannot be written.
    pub fn write(
        &self,
        log: &Path,
        replay: &Replay<'_>,
        golden: &Golden,
        results: Results,
        found: &Comparison,
    ) -> Result<[PathBuf; 2], CheckError> {
        let info = LogInfo::of(replay.log());
        let config = golden.config.clone();
        let new = Golden::new(Some(info.clone()), config, golden.tolerances, results);
        let new_path = self.write_golden(log, &new)?;
        let [_, path] = artifacts_of(log, &self.directory);
        let mut out = Output::create(&path)?;
        let setting = replay.setting();
        let over = overlay(golden, &new.results, found, self.around);
        let mut recording = Recording::overlaid(&mut out, setting, over)?;
        let outcome = replay.run(&mut [&mut recording])?;
        let labels = new.results.labels.unwrap_or_default();
        let carried = carried(&setting, &outcome, info, labels)?;
        recording.close(Some(&carried))?;
        out.commit()?;
        Ok([new_path, path])
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
