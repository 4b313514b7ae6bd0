//! `tmam diff`: two results against each other, whatever they come from.
//!
//! A log is replayed: beside results that record a configuration with that one, else with the
//! defaults, and what is given on the command line stands over either.

mod error;
pub mod json;
mod side;
mod source;

use std::path::Path;

pub use error::DiffError;
pub use side::{Kind, Recorded, Side};

use crate::core::config::Config;
use crate::io::config::file::layered;
use source::Source;

/// What to replay logs with: texts as of a configuration file, each over the one before.
#[derive(Debug, Clone, Default)]
pub struct Terms {
    /// For both sides; none where nothing is given.
    pub both: Vec<String>,
    /// For B; the same texts where nothing is given for B alone.
    pub b: Vec<String>,
    /// Whether something is given for B alone.
    pub b_differs: bool,
}

/// Two sides to compare.
#[derive(Debug)]
pub struct Pair {
    /// One.
    pub a: Side,
    /// The other.
    pub b: Side,
    /// On what terms they can be compared.
    pub notes: Vec<String>,
}

/// Reads both sides, and replays those that are logs; without `b`, the one log is both.
///
/// # Errors
/// When there are no results to be had from one, or when what is given has no effect.
pub fn pair(a: &Path, b: Option<&Path>, terms: &Terms) -> Result<Pair, DiffError> {
    let b = Source::open(b.unwrap_or(a))?;
    let a = Source::open(a)?;
    if terms.b_differs && !b.is_log() {
        let b = b.path().to_owned();
        return Err(DiffError::NothingToReplayForB { b });
    }
    if !terms.both.is_empty() && !a.is_log() && !b.is_log() {
        let (a, b) = (a.path().to_owned(), b.path().to_owned());
        return Err(DiffError::NothingToReplay { a, b });
    }
    let mut notes = Vec::new();
    let (a, b) = match (a, b) {
        (Source::Results(a), Source::Results(b)) => (*a, *b),
        (Source::Log(log), Source::Results(b)) => {
            let a = replayed_like(&b, &log, &terms.both, &mut notes)?;
            (a, *b)
        }
        (Source::Results(a), Source::Log(log)) => {
            let b = replayed_like(&a, &log, &terms.b, &mut notes)?;
            (*a, b)
        }
        (Source::Log(a), Source::Log(b)) => (
            Side::replayed(&a, layered(Config::default(), &terms.both)?)?,
            Side::replayed(&b, layered(Config::default(), &terms.b)?)?,
        ),
    };
    if let (Some(a), Some(b)) = (&a.log, &b.log)
        && a.events_sha256 != b.events_sha256
    {
        notes.push("the two come from logs with different events".to_owned());
    }
    let without: Vec<String> = [&a, &b]
        .into_iter()
        .filter(|side| side.results.labels.is_none())
        .map(|side| side.path.display().to_string())
        .collect();
    match without.as_slice() {
        [] => {}
        [one] => notes.push(format!("labels are not compared: {one} holds none")),
        _ => notes.push("labels are not compared: neither side holds any".to_owned()),
    }
    match [&a, &b].map(|side| side.results.noise.is_unknown()) {
        [true, false] => notes.push(unrecorded_noise(&a)),
        [false, true] => notes.push(unrecorded_noise(&b)),
        _ => {}
    }
    Ok(Pair { a, b, notes })
}

fn unrecorded_noise(side: &Side) -> String {
    let file = side.path.display();
    format!("the noise of the ranges is not compared: {file} does not record whether they tell it")
}

/// A log, replayed with the configuration of the results that it is compared with.
fn replayed_like(
    results: &Side,
    log: &Path,
    layers: &[String],
    notes: &mut Vec<String>,
) -> Result<Side, DiffError> {
    let recorded = results.configuration()?;
    let (log_name, file) = (log.display(), results.path.display());
    let mut note = match &recorded {
        Some(_) => format!("{log_name} was replayed with the configuration in {file}"),
        None => {
            format!("{file} records no configuration; {log_name} was replayed with the defaults")
        }
    };
    if !layers.is_empty() {
        note.push_str(", and what was given over it");
    }
    notes.push(note);
    if !results.unrecorded.is_empty() {
        notes.push(format!(
            "{file} does not record {}; the present defaults hold",
            results.unrecorded.join(", ")
        ));
    }
    let config = layered(recorded.unwrap_or_default(), layers)?;
    Side::replayed(log, config)
}
