//! `tmam diff`: two results against each other, whatever they come from.
//!
//! A log is replayed: beside results that record a configuration with that one, else with the
//! defaults, and what is given on the command line stands over either.

mod side;

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value as Json, json};

pub use side::{DiffError, Side};

use crate::core::config::Config;
use crate::core::exit::Exit;
use crate::core::legible::inert_line;
use crate::core::tool::Tool;
use crate::io::config::file::layered;
use crate::tools::golden::{Comparison, Tolerance, compare, differences_in_json, sections};
use side::Source;

/// The name and version of the JSON format.
const SCHEMA: &str = "tmam.diff/1";

/// What to replay logs with: texts as of a configuration file, each over the one before.
#[derive(Debug, Clone, Default)]
pub struct Terms {
    /// For both sides; none where nothing is given.
    pub both: Vec<String>,
    /// For B; the same texts where nothing is given for B alone.
    pub b: Vec<String>,
    /// Whether something is given for B alone.
    pub b_differs: bool,
    /// As `KEY=VALUE`, over those of a golden file.
    pub tolerances: Vec<String>,
}

/// Two sides and how they differ.
#[derive(Debug)]
pub struct Diff {
    a: Side,
    b: Side,
    /// On what terms they can be compared.
    notes: Vec<String>,
    found: Comparison,
}

impl Diff {
    /// Reads both sides, replays those that are logs, and compares; without `b`, the one log is both.
    ///
    /// # Errors
    /// When there are no results to be had from one, or when what is given has no effect.
    pub fn new(a: &Path, b: Option<&Path>, terms: &Terms) -> Result<Self, DiffError> {
        let mut notes = Vec::new();
        let (a, b) = sides(a, b.unwrap_or(a), terms, &mut notes)?;
        if let (Some(a), Some(b)) = (&a.log, &b.log)
            && a.events_sha256 != b.events_sha256
        {
            notes.push("the two come from logs with different events".to_owned());
        }
        let unlabelled = [&a, &b]
            .into_iter()
            .filter(|side| side.results.labels.is_none());
        match unlabelled.collect::<Vec<_>>().as_slice() {
            [] => {}
            [one] => {
                let one = one.path.display();
                notes.push(format!("labels are not compared: {one} holds none"));
            }
            _ => notes.push("labels are not compared: neither side holds any".to_owned()),
        }
        if a.results.noise.is_unknown() != b.results.noise.is_unknown() {
            let unknown = if a.results.noise.is_unknown() { &a } else { &b };
            notes.push(format!(
                "the noise of the ranges is not compared: {} does not record whether they tell it",
                unknown.path.display()
            ));
        }
        let tolerance = a.tolerances.or(b.tolerances).unwrap_or_default();
        let tolerance = terms
            .tolerances
            .iter()
            .try_fold(tolerance, Tolerance::with)?;
        let found = compare(&a.results, &b.results, &tolerance);
        Ok(Self { a, b, notes, found })
    }

    /// Whether it matches, and on whole logs; `strict`: borderline labels are differences, too.
    pub fn exit(&self, strict: bool) -> Exit {
        if !self.found.matches(strict) {
            return Exit::Differs;
        }
        let whole = self.a.losses.is_empty() && self.b.losses.is_empty();
        Exit::of_whole(whole && !(self.a.results.is_empty() && self.b.results.is_empty()))
    }

    /// What differs, and on what terms the two were compared; of each section `shown` lines.
    pub fn text(&self, shown: usize, strict: bool) -> String {
        let mut text = String::new();
        for (name, side) in [("a", &self.a), ("b", &self.b)] {
            let labels = match &side.results.labels {
                Some(labels) => format!("{} arcs", labels.len()),
                None => "no labels".to_owned(),
            };
            let incomplete = if side.losses.is_empty() {
                ""
            } else {
                ", INCOMPLETE"
            };
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{name}  {}: {} map features, {} extracted, {labels}{incomplete}",
                inert_line(&side.path.display().to_string()),
                side.results.map.len(),
                side.results.extracted.len(),
            );
        }
        for note in &self.notes {
            let _ = writeln!(text, "note: {}", inert_line(note));
        }
        let sections = sections(&self.found, None, strict);
        for section in &sections {
            text.push_str(&section.listed(shown));
        }
        if sections.is_empty() {
            text.push_str("nothing differs beyond the tolerances\n");
        }
        text
    }

    /// The same as JSON.
    pub fn json(&self, strict: bool) -> Json {
        let [differences, borderline] = differences_in_json(&self.found);
        json!({
            "schema": SCHEMA,
            "tool": Tool::THIS,
            "exit_code": self.exit(strict).code(),
            "a": self.a.json(),
            "b": self.b.json(),
            "notes": self.notes,
            "tolerances": self.found.tolerance,
            "labels_compared": self.found.label_counts.is_some(),
            "first_frame": self.found.first_frame(),
            "differences": differences,
            "borderline": borderline,
        })
    }
}

fn sides(
    a: &Path,
    b: &Path,
    terms: &Terms,
    notes: &mut Vec<String>,
) -> Result<(Side, Side), DiffError> {
    let (b, a) = (Source::open(b)?, Source::open(a)?);
    if let (true, Source::Results(b)) = (terms.b_differs, &b) {
        let b = b.path.clone();
        return Err(DiffError::NothingToReplayForB { b });
    }
    let replayed = |log: &Path, layers: &[String]| -> Result<Side, DiffError> {
        Side::replayed(log, layered(Config::default(), layers)?)
    };
    Ok(match (a, b) {
        (Source::Results(a), Source::Results(b)) if terms.both.is_empty() => (*a, *b),
        (Source::Results(a), Source::Results(b)) => {
            let (a, b) = (a.path, b.path);
            return Err(DiffError::NothingToReplay { a, b });
        }
        (Source::Log(log), Source::Results(b)) => {
            (replayed_like(&b, &log, &terms.both, notes)?, *b)
        }
        (Source::Results(a), Source::Log(log)) => {
            let b = replayed_like(&a, &log, &terms.b, notes)?;
            (*a, b)
        }
        (Source::Log(a), Source::Log(b)) => (replayed(&a, &terms.both)?, replayed(&b, &terms.b)?),
    })
}

/// A log, replayed with the configuration of the results that it is compared with.
fn replayed_like(
    results: &Side,
    log: &Path,
    layers: &[String],
    notes: &mut Vec<String>,
) -> Result<Side, DiffError> {
    let recorded = results.configuration()?;
    let (name, file) = (log.display(), results.path.display());
    let mut note = match &recorded {
        Some(_) => format!("{name} was replayed with the configuration in {file}"),
        None => format!("{file} records no configuration; {name} was replayed with the defaults"),
    };
    if !layers.is_empty() {
        note.push_str(", and what was given over it");
    }
    notes.push(note);
    if !results.unrecorded.is_empty() {
        let unrecorded = results.unrecorded.join(", ");
        notes.push(format!(
            "{file} does not record {unrecorded}; the present defaults hold"
        ));
    }
    Side::replayed(log, layered(recorded.unwrap_or_default(), layers)?)
}
