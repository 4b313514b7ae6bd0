//! Golden files of drives whose log is called otherwise now, found by the digest of its events.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::core::config::Config;
use crate::core::digest::sha256;
use crate::io::log::read;
use crate::tools::golden::Golden;

/// A golden file that no log of the run is called after.
struct Left {
    path: PathBuf,
    config: Config,
    events_sha256: String,
}

/// For each log without a golden file, by what that would be called, one of the `left` ones that was made from the
/// same drive. What cannot be read is left to whoever checks it.
pub fn renamed(logs: &BTreeMap<PathBuf, PathBuf>, left: &[PathBuf]) -> BTreeMap<PathBuf, PathBuf> {
    let mut missing = logs
        .iter()
        .filter(|(golden, _)| !golden.exists())
        .peekable();
    let mut found = BTreeMap::new();
    if missing.peek().is_none() {
        return found;
    }
    let mut left: Vec<Left> = left.iter().filter_map(|path| Left::read(path)).collect();
    for (golden, log) in missing {
        // What is read of a log depends on the configuration; mostly all files have the same.
        let mut digests: Vec<(Config, Option<String>)> = Vec::new();
        let is_of_it = |one: &Left| {
            let known = digests.iter().find(|(config, _)| *config == one.config);
            let digest = known.map(|(_, digest)| digest.clone()).unwrap_or_else(|| {
                let log = read(log, &one.config).ok();
                let digest = log.map(|log| sha256(&log.events));
                digests.push((one.config.clone(), digest.clone()));
                digest
            });
            digest.as_ref() == Some(&one.events_sha256)
        };
        if let Some(place) = left.iter().position(is_of_it) {
            found.insert(golden.clone(), left.remove(place).path);
        }
    }
    found
}

impl Left {
    fn read(path: &Path) -> Option<Self> {
        let (golden, _) = Golden::read(path).ok()?;
        let events_sha256 = golden.log()?.events_sha256.clone();
        Some(Self {
            path: path.to_owned(),
            config: golden.config?,
            events_sha256,
        })
    }
}
