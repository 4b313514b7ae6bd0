//! `tmam diff`: two results against each other, whatever they come from.

use std::path::{Path, PathBuf};

use crate::check::{Replayed, replay};
use crate::config::Config;
use crate::error::Error;
use crate::golden::{Golden, GoldenError, LogInfo, Results, Tolerance, from_features_file};

/// One side of a comparison.
#[derive(Debug)]
pub struct Side {
    /// What it came from.
    pub path: PathBuf,
    /// What it holds.
    pub results: Results,
    /// The tolerances in it, where it is a golden file.
    pub tolerances: Option<Tolerance>,
    /// Its log, where that is known.
    pub log: Option<LogInfo>,
    /// What could not be read of it; empty for a whole one.
    pub losses: Vec<String>,
}

/// Why there is nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    /// Something else.
    #[error(
        "{} is neither an MCAP log nor a features.json nor a golden file: {reason}", path.display()
    )]
    NoResults {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// Recordings cannot be read back into features.
    #[error(
        "{} is a recording, which is for looking at; compare the logs, or the features.json files that were \
         written beside the recordings", path.display()
    )]
    Recording {
        /// The file.
        path: PathBuf,
    },
}

/// Reads one side: replays a log with `config`, or reads the results in a file.
///
/// # Errors
/// When there are no results to be had from it.
pub fn side(path: &Path, config: &Config) -> Result<Side, Error> {
    let head = head(path)?;
    let path = path.to_owned();
    if head.starts_with(b"RRF") {
        return Err(DiffError::Recording { path }.into());
    }
    let text = head.iter().find(|byte| !byte.is_ascii_whitespace());
    if text != Some(&b'{') {
        let Replayed {
            log, info, results, ..
        } = replay(&path, config)?;
        return Ok(Side {
            path,
            results,
            tolerances: None,
            log: Some(info),
            losses: log.losses,
        });
    }
    match Golden::read(&path) {
        Ok((golden, _)) => Ok(Side {
            path,
            results: golden.results,
            tolerances: Some(golden.tolerances),
            log: golden.log,
            losses: Vec::new(),
        }),
        Err(GoldenError::Schema { newer: false, .. }) => {
            let text = std::fs::read_to_string(&path).map_err(|source| Error::Read {
                path: path.clone(),
                source,
            })?;
            let results = from_features_file(&text).map_err(|error| DiffError::NoResults {
                path: path.clone(),
                reason: error.to_string(),
            })?;
            Ok(Side {
                path,
                results,
                tolerances: None,
                log: None,
                losses: Vec::new(),
            })
        }
        Err(error) => Err(error.into()),
    }
}

/// The first bytes of a file.
fn head(path: &Path) -> Result<Vec<u8>, Error> {
    use std::io::Read as _;
    let mut head = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(64).read_to_end(&mut head))
        .map_err(|source| Error::Read {
            path: path.to_owned(),
            source,
        })?;
    Ok(head)
}
