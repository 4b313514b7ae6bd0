//! Two folders of results: which of one is to be held against which of the other.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{Argument, DiffError};
use crate::core::config::Config;
use crate::core::digest::sha256;
use crate::io::log::read;

/// The files of two folders that hold results of one drive, by their name or else by the digest of its events, and
/// those that have nothing beside them.
#[derive(Debug, Default)]
pub struct Folders {
    pub pairs: Vec<[PathBuf; 2]>,
    pub alone: Vec<PathBuf>,
}

impl Folders {
    /// Looks into both.
    ///
    /// # Errors
    /// One that cannot be read, or that holds no results.
    pub fn of(a: &Path, b: &Path) -> Result<Self, DiffError> {
        let (in_a, mut in_b) = (named(a)?, named(b)?);
        for (folder, files) in [(a, &in_a), (b, &in_b)] {
            if files.is_empty() {
                let folder = folder.to_owned();
                return Err(DiffError::NoneInFolder { folder });
            }
        }
        let (mut pairs, mut without) = (Vec::new(), Vec::new());
        for (name, file) in in_a {
            match in_b.remove(&name) {
                Some(other) => pairs.push([file, other]),
                None => without.push(file),
            }
        }
        let mut left: Vec<(Option<String>, PathBuf)> = match without.is_empty() {
            true => in_b.into_values().map(|file| (None, file)).collect(),
            false => in_b
                .into_values()
                .map(|file| (drive_of(&file), file))
                .collect(),
        };
        let mut alone = Vec::new();
        for file in without {
            let drive = drive_of(&file).filter(|_| !left.is_empty());
            let is_it = |(other, _): &(Option<String>, PathBuf)| drive.is_some() && *other == drive;
            match left.iter().position(is_it) {
                Some(place) => pairs.push([file, left.remove(place).1]),
                None => alone.push(file),
            }
        }
        alone.extend(left.into_iter().map(|(_, file)| file));
        Ok(Self { pairs, alone })
    }
}

/// The digest of the events that results come from, where they or their log can be read.
fn drive_of(file: &Path) -> Option<String> {
    match Argument::open(file).ok()? {
        Argument::Log(log) => {
            let log = read(&log, &Config::default()).ok()?;
            Some(sha256(&log.events))
        }
        Argument::Results(side) => Some(side.results.log?.events_sha256),
    }
}

/// The results in a folder by their name; of several of one name, what says most.
fn named(folder: &Path) -> Result<BTreeMap<String, PathBuf>, DiffError> {
    const KINDS: [&str; 7] = [
        ".golden.json",
        ".golden.json.new",
        ".check.rrd",
        ".rrd",
        ".features.json",
        ".json",
        ".mcap",
    ];
    let unreadable = |source| DiffError::Read {
        path: folder.to_owned(),
        source,
    };
    let mut named = BTreeMap::<String, (usize, PathBuf)>::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let file = entry.file_name().to_string_lossy().into_owned();
        let kinds = KINDS.iter().enumerate();
        let mut kinds = kinds.filter_map(|(rank, kind)| Some((rank, file.strip_suffix(kind)?)));
        if let Some((rank, name)) = kinds.next() {
            let found = (rank, entry.path());
            let best = named
                .entry(name.to_owned())
                .or_insert_with(|| found.clone());
            if found < *best {
                *best = found;
            }
        }
    }
    let paths = named.into_iter().map(|(name, (_, path))| (name, path));
    Ok(paths.collect())
}
