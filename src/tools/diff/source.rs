//! What is given to be compared: a log, or the results in a file.

use std::path::{Path, PathBuf};

use super::DiffError;
use super::side::{Kind, Recorded, Side};
use crate::core::config::Config;
use crate::io::schema::{Relation, in_words, of_file, relation};
use crate::observe::features;
use crate::observe::recording::read_carried;
use crate::tools::golden::{
    FeaturesFile, Golden, GoldenError, SCHEMA as GOLDEN, read_labels, unrecorded,
};

/// One of the two arguments, looked at but not replayed.
#[derive(Debug)]
pub enum Source {
    /// A log, to be replayed.
    Log(PathBuf),
    /// Results that lie there.
    Results(Box<Side>),
}

impl Source {
    /// Opens an argument.
    ///
    /// # Errors
    /// When no results are to be had from it.
    pub fn open(path: &Path) -> Result<Self, DiffError> {
        let head = head(path)?;
        if head.starts_with(b"RRF") {
            return recorded(path).map(|side| Self::Results(Box::new(side)));
        }
        let text = head.iter().find(|byte| !byte.is_ascii_whitespace());
        if text != Some(&b'{') {
            return Ok(Self::Log(path.to_owned()));
        }
        let bytes = std::fs::read(path).map_err(|source| unreadable(path, source))?;
        results(path, &bytes).map(|side| Self::Results(Box::new(side)))
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        match self {
            Self::Log(path) => path,
            Self::Results(side) => &side.path,
        }
    }

    /// Whether it must be replayed.
    pub fn is_log(&self) -> bool {
        matches!(self, Self::Log(_))
    }
}

/// The results that a recording carries.
fn recorded(path: &Path) -> Result<Side, DiffError> {
    let unfit = |source| DiffError::Recording {
        path: path.to_owned(),
        source,
    };
    let carried = read_carried(path).map_err(unfit)?;
    let mut side = results(path, carried.features.as_bytes())?;
    side.kind = Kind::Recording;
    if let Some(text) = carried.labels {
        let file = read_labels(&text).map_err(|reason| DiffError::Malformed {
            path: path.to_owned(),
            reason,
        })?;
        side.log = Some(file.log);
        side.results.noise = file.noise;
        side.results.labels = Some(file.labels);
    }
    Ok(side)
}

/// The results in a file, by its schema.
fn results(path: &Path, bytes: &[u8]) -> Result<Side, DiffError> {
    let no_results = |reason: String| DiffError::NoResults {
        path: path.to_owned(),
        reason,
    };
    let found = of_file(bytes)
        .map_err(no_results)?
        .ok_or_else(|| no_results("it does not say its schema".to_owned()))?;
    // A golden file of another version is refused by its own reader.
    if relation(&found, GOLDEN) != Relation::Other {
        let (golden, unrecorded) = Golden::read(path)?;
        return Ok(Side {
            path: path.to_owned(),
            kind: Kind::Golden,
            results: golden.results,
            tolerances: Some(golden.tolerances),
            log: golden.log,
            config: golden.config.map_or(Recorded::Nothing, |config| {
                Recorded::Config(Box::new(config))
            }),
            losses: Vec::new(),
            unrecorded,
        });
    }
    match relation(&found, features::SCHEMA) {
        Relation::Same => {}
        Relation::Other => {
            return Err(no_results(format!("its schema is `{found}`")));
        }
        relation => {
            return Err(DiffError::Version {
                path: path.to_owned(),
                found,
                relation,
            });
        }
    }
    let file: FeaturesFile =
        serde_json::from_slice(bytes).map_err(|error| DiffError::Malformed {
            path: path.to_owned(),
            reason: in_words(&error),
        })?;
    let (losses, config) = (file.losses(), file.config());
    // One that makes no sense is refused where a log needs it.
    let absent = config
        .clone()
        .and_then(|json| serde_json::from_value(json).ok())
        .map(|config: Config| unrecorded(bytes, &config));
    let results = file.into_results().map_err(|reason| DiffError::Malformed {
        path: path.to_owned(),
        reason,
    })?;
    Ok(Side {
        path: path.to_owned(),
        kind: Kind::Features,
        losses,
        unrecorded: absent.unwrap_or_default(),
        config: config.map_or(Recorded::Nothing, Recorded::Json),
        results,
        tolerances: None,
        log: None,
    })
}

/// The first bytes of a file.
fn head(path: &Path) -> Result<Vec<u8>, DiffError> {
    use std::io::Read as _;
    let mut head = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(64).read_to_end(&mut head))
        .map_err(|source| unreadable(path, source))?;
    Ok(head)
}

fn unreadable(path: &Path, source: std::io::Error) -> GoldenError {
    let path = path.to_owned();
    GoldenError::Read { path, source }
}
