//! What is kept of a log that differs: what it gives now, and a recording with the differences.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::CheckError;
use super::judge::unfit;
use super::overlay::overlay;
use super::suite::Job;
use crate::core::config::Config;
use crate::core::observer::Observer;
use crate::core::replay::Replay;
use crate::io::output::Output;
use crate::observe::recording::Recording;
use crate::observe::viewer;
use crate::tools::carried::carried;
use crate::tools::golden::{
    Comparison, Golden, GoldenError, Replayed, Tolerance, as_recorded, replay,
};

/// A directory for artefacts.
#[derive(Debug)]
pub struct Artifacts {
    directory: PathBuf,
    around: Option<u32>,
}

impl Artifacts {
    /// Into a directory that exists; `around`: record only so many frames about each difference.
    pub fn new(directory: &Path, around: Option<u32>) -> Self {
        Self {
            directory: directory.to_owned(),
            around,
        }
    }

    /// Writes the golden file that would make the log pass, and the recording.
    pub fn write(
        &self,
        job: &Job,
        golden: &Golden,
        config: &Config,
        replayed: &Replayed,
        comparison: &Comparison,
    ) -> Result<(Vec<PathBuf>, Option<PathBuf>), CheckError> {
        let [new, recording] = self.paths(job);
        write_new(&new, replayed, config, golden.tolerances)?;
        if !viewer::IS_BUILT_IN {
            return Ok((vec![new], None));
        }
        let mut out = Output::create(&recording)?;
        let replay = Replay::new(&replayed.log, config).map_err(GoldenError::from)?;
        let over = overlay(golden, &replayed.results, comparison, self.around);
        let setting = replay.setting();
        let mut recorder = Recording::new(Some(&mut out), None, setting, over)?;
        let outcome = replay
            .run(&mut [&mut recorder as &mut dyn Observer])
            .map_err(GoldenError::from)?;
        let carried = carried(&setting, &outcome, &replayed.info)?;
        recorder.close(Some(&carried))?;
        out.commit()?;
        Ok((vec![new, recording.clone()], Some(recording)))
    }

    /// Writes the golden file that a log without one would get with the default configuration;
    /// `None` for a log that cannot be blessed.
    pub fn first(&self, job: &Job) -> Result<Option<PathBuf>, CheckError> {
        let config = as_recorded(&Config::default())?;
        let replayed = replay(&job.log, &config)?;
        if unfit(&replayed).is_some() || replayed.results.is_empty() {
            return Ok(None);
        }
        let [new, _] = self.paths(job);
        write_new(&new, &replayed, &config, Tolerance::default())?;
        Ok(Some(new))
    }

    /// Takes away what an earlier run left of a log.
    pub fn clear(&self, job: &Job) {
        for path in self.paths(job) {
            // What is not there need not go.
            let _ = std::fs::remove_file(path);
        }
    }

    fn paths(&self, job: &Job) -> [PathBuf; 2] {
        artifacts_of(&job.log, &self.directory)
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

fn write_new(
    path: &Path,
    replayed: &Replayed,
    config: &Config,
    tolerances: Tolerance,
) -> Result<(), CheckError> {
    let bytes = Golden::new(
        Some(replayed.info.clone()),
        Some(config.clone()),
        tolerances,
        replayed.results.clone(),
    )
    .render()?;
    let mut out = Output::create(path)?;
    out.write_all(&bytes).map_err(|source| out.failed(source))?;
    out.commit()?;
    Ok(())
}
