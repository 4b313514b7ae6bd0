//! `tmam diff`: two results against each other, whatever they come from.
//!
//! A log is replayed: beside results that record a configuration with that one, else with the
//! defaults, and what is given on the command line stands over either.

pub mod drawing;
pub mod folders;

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde::Deserialize as _;
use serde_json::{Value as Json, json};

use crate::core::config::Config;
use crate::core::exit::Exit;
use crate::core::legible::inert_line;
use crate::core::log::Log;
use crate::core::observer::Kept;
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::tool::Tool;
use crate::io::config::file::{ConfigError, changes, check, layered};
use crate::io::config::idle::{Bearing, bearing};
use crate::io::log::LogError;
use crate::io::log::container::is_one_recording;
use crate::io::log::survey::as_it_is;
use crate::io::schema::{Relation, in_words, of_file, relation};
use crate::observe::features;
use crate::observe::recording::read_carried;
use crate::observe::viewer::{self, CarriedError};
use crate::tools::golden::{
    Comparison, Difference, FeaturesFile, Golden, GoldenError, LabelsFile, Quality, RangeSigma,
    Results, SCHEMA as GOLDEN, Tolerance, ToleranceError, all_results, compare,
    differences_in_json, headline, headlines, sections, unrecorded,
};

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
    /// Whether only the confirmed features of the map are compared.
    pub only_map: bool,
    /// Whether a run is kept, to be drawn: that of B where B is a log, else that of A.
    pub drawn: bool,
}

/// How good all A and all B are together, in a line; nothing where that is not known.
pub fn together(all: &[Diff]) -> String {
    let known = all.iter().filter_map(|diff| diff.found.quality);
    let (a, b): (Vec<Quality>, Vec<Quality>) = known.map(|[a, b]| (a, b)).unzip();
    match a.len() {
        0 | 1 => String::new(),
        n => {
            let [a, b] = [a, b].map(|all| Quality::of_all(&all));
            format!("all {n} together, {}\n", headline(&a, &b))
        }
    }
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
        match [&a, &b].map(|side| side.results.labels.is_none()) {
            [false, false] => {}
            [true, true] => {
                notes.push("labels are not compared: neither side holds any".to_owned())
            }
            [in_a, _] => {
                let one = if in_a { &a } else { &b }.path.display();
                notes.push(format!("labels are not compared: {one} holds none"));
            }
        }
        let [in_a, in_b] = [&a, &b].map(|side| side.results.noise.is_unknown());
        if in_a != in_b {
            let unknown = if in_a { &a } else { &b }.path.display();
            notes.push(format!(
                "the noise of the ranges is not compared: {unknown} does not record whether they tell it"
            ));
        }
        let tolerance = a.tolerances.or(b.tolerances).unwrap_or_default();
        let tolerance = (terms.tolerances.iter()).try_fold(tolerance, Tolerance::with)?;
        let (one, other) = match terms.only_map {
            true => (a.results.map_alone(), b.results.map_alone()),
            false => (a.results.clone(), b.results.clone()),
        };
        let mut found = compare(&one, &other, &tolerance);
        // Two sides may well come from other logs: what counts is what they give.
        for one in &mut found.differences {
            if let Difference::Cause(cause) = one {
                cause.fails = false;
            }
        }
        let differs = found.differs();
        let suspects = found.quality.is_some_and(|[then, now]| {
            (then.suspects, then.explained) != (now.suspects, now.explained)
        });
        let bears = |change: &Changed| match change.bears {
            Bearing::Results => true,
            Bearing::Suspects => suspects,
            Bearing::Nothing => false,
        };
        let (can, cannot): (Vec<Changed>, Vec<Changed>) =
            changed(&a, &b).into_iter().partition(bears);
        found.blame(&texts(&can), false, None);
        if !differs {
            let causes: Vec<String> = found.causes().map(|cause| cause.text.clone()).collect();
            notes.extend(
                causes
                    .iter()
                    .map(|text| format!("otherwise, but no result differs for it: {text}")),
            );
            found
                .differences
                .retain(|one| !matches!(one, Difference::Cause(_)));
        }
        if !cannot.is_empty() {
            let keys = texts(&cannot).join("; ");
            notes.push(format!("without effect under the rule that ran: {keys}"));
        }
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
            let is_whole = side.losses.is_empty();
            let incomplete = if is_whole { "" } else { ", INCOMPLETE" };
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
        for line in headlines(&self.found, None) {
            let _ = writeln!(text, "{line}");
        }
        let sections = sections(&self.found, strict);
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
            "quality": self.found.quality.map(|[a, b]| json!({"trend": b.trend(&a), "a": a, "b": b})),
            "causes": self.found.causes().collect::<Vec<_>>(),
            "tolerances": self.found.tolerance,
            "labels_compared": self.found.label_counts.is_some(),
            "first_frame": self.found.first_frame(),
            "differences": differences,
            "borderline": borderline,
        })
    }
}

/// A key that is otherwise.
struct Changed {
    text: String,
    /// On either side.
    bears: Bearing,
}

fn texts(changes: &[Changed]) -> Vec<String> {
    changes.iter().map(|change| change.text.clone()).collect()
}

/// What is otherwise in the configurations of two sides; nothing where one records none.
fn changed(a: &Side, b: &Side) -> Vec<Changed> {
    let known = |side: &Side| side.configuration().ok().flatten();
    let Some((mut one, mut other)) = known(a).zip(known(b)) else {
        return Vec::new();
    };
    let noise = [a, b].map(|side| side.results.noise);
    // What is measured is in no configuration, whatever a file says.
    for (config, noise) in [&mut one, &mut other].into_iter().zip(noise) {
        if matches!(noise, RangeSigma::Measured(_)) {
            config.noise.sigma_abs = None;
        }
    }
    // Where one side does not say whether it measured, there is nothing to say.
    if noise.iter().any(RangeSigma::is_unknown) {
        other.noise.sigma_abs = one.noise.sigma_abs;
    }
    let changes = changes(&one, &other).into_iter();
    changes
        .map(|(key, change)| Changed {
            bears: bearing(&key, &one).max(bearing(&key, &other)),
            text: format!("{key} {change}"),
        })
        .collect()
}

fn sides(
    a: &Path,
    b: &Path,
    terms: &Terms,
    notes: &mut Vec<String>,
) -> Result<(Side, Side), DiffError> {
    let (b, a) = (Argument::open(b)?, Argument::open(a)?);
    if let (true, Argument::Results(b)) = (terms.b_differs, &b) {
        let b = b.path.clone();
        return Err(DiffError::NothingToReplayForB { b });
    }
    let replayed = |log: &Path, layers: &[String], kept: bool| -> Result<Side, DiffError> {
        Side::replayed(log, layered(Config::default(), layers)?, kept)
    };
    Ok(match (a, b) {
        (Argument::Results(a), Argument::Results(b)) if terms.both.is_empty() => (*a, *b),
        (Argument::Results(a), Argument::Results(b)) => {
            let (a, b) = (a.path, b.path);
            return Err(DiffError::NothingToReplay { a, b });
        }
        (Argument::Log(log), Argument::Results(b)) => (
            replayed_like(&b, &log, (&terms.both, terms.drawn), notes)?,
            *b,
        ),
        (Argument::Results(a), Argument::Log(log)) => {
            let b = replayed_like(&a, &log, (&terms.b, terms.drawn), notes)?;
            (*a, b)
        }
        (Argument::Log(a), Argument::Log(b)) => {
            let a = replayed(&a, &terms.both, false)?;
            (a, replayed(&b, &terms.b, terms.drawn)?)
        }
    })
}

/// A log, replayed with the configuration of the results that it is compared with, and its run `kept` or not.
fn replayed_like(
    results: &Side,
    log: &Path,
    (layers, kept): (&[String], bool),
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
    Side::replayed(log, layered(recorded.unwrap_or_default(), layers)?, kept)
}

/// One side of a comparison.
#[derive(Debug)]
struct Side {
    /// Its file.
    path: PathBuf,
    /// The kind of the file: `log`, `features`, `golden` or `recording`.
    kind: &'static str,
    results: Results,
    /// The tolerances in it, where it is a golden file.
    pub tolerances: Option<Tolerance>,
    /// The configuration that it came from. Only a log beside it needs one that makes sense.
    config: Option<Json>,
    /// Parameters that the file does not record.
    unrecorded: Vec<String>,
    /// What could not be read of its log; empty for a whole one.
    losses: Vec<String>,
    run: Option<Box<Run>>,
}

/// The run of a log, to be drawn.
#[derive(Debug)]
struct Run {
    log: Log,
    config: Config,
    outcome: Outcome,
    kept: Kept,
}

/// One of the two arguments, looked at but not replayed.
#[derive(Debug)]
enum Argument {
    /// A log, to be replayed.
    Log(PathBuf),
    Results(Box<Side>),
}

/// Why there is nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    #[error("cannot read {}: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error(
        "{} holds no results: none of its files ends in .golden.json, .rrd, .features.json or .mcap. Give a folder \
         that does, such as the artefacts of a check", folder.display()
    )]
    NoneInFolder { folder: PathBuf },
    #[error(
        "{} is a folder of several files. Give two folders, which are compared by the names of their files, or name \
         one of its files", folder.display()
    )]
    OneFolder { folder: PathBuf },
    #[error(
        "{} is neither an MCAP log nor a recording, a features.json or a golden file: {reason}", path.display()
    )]
    NoResults { path: PathBuf, reason: String },
    #[error(
        "{} has the schema `{found}`, and this is tmam {}, which reads `{}`. {}", path.display(),
        env!("CARGO_PKG_VERSION"), features::SCHEMA,
        if *.relation == Relation::Newer { "Install the tmam that wrote it, or replay its log with this one" }
        else { "Replay its log with this tmam" }
    )]
    Version {
        path: PathBuf,
        found: String,
        relation: Relation,
    },
    #[error(
        "{} is no features.json as tmam writes it: {reason}. Write it again with `tmam replay LOG --features FILE`",
        path.display()
    )]
    Malformed { path: PathBuf, reason: String },
    #[error(
        "the results of {} cannot be compared: {source}. Record its log again with `tmam replay LOG -o FILE.rrd`, or \
         compare the log itself or its features.json", path.display()
    )]
    Recording { path: PathBuf, source: CarriedError },
    #[error(
        "neither {} nor {} is a log, so there is nothing to replay with the parameters that are given. Leave them \
         out, or give a log in place of one of the two", a.display(), b.display()
    )]
    NothingToReplay { a: PathBuf, b: PathBuf },
    #[error(
        "--config-b and --set-b are for replaying B, and {} is no log. Leave them out, or give the log as B: \
         tmam diff A LOG", b.display()
    )]
    NothingToReplayForB { b: PathBuf },
    #[error(
        "{} records no configuration that this tmam could replay the log with: {reason}. Compare with a \
         features.json of the log, written by `tmam replay`", path.display()
    )]
    RecordedConfig { path: PathBuf, reason: String },
    #[error(transparent)]
    Drawing(#[from] viewer::Error),
    #[error("cannot form the results that the recording carries: {0}")]
    Carried(#[from] std::io::Error),
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Golden(#[from] GoldenError),
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
}

impl DiffError {
    fn malformed(path: &Path) -> impl Fn(String) -> Self {
        let path = path.to_owned();
        move |reason| Self::Malformed {
            path: path.clone(),
            reason,
        }
    }
}

impl Argument {
    /// Opens an argument.
    ///
    /// # Errors
    /// When no results are to be had from it.
    fn open(path: &Path) -> Result<Self, DiffError> {
        if path.is_dir() {
            let folder = path.to_owned();
            return match is_one_recording(path) {
                true => Ok(Self::Log(folder)),
                false => Err(DiffError::OneFolder { folder }),
            };
        }
        let unreadable = |source| {
            let path = path.to_owned();
            DiffError::Read { path, source }
        };
        let mut head = Vec::new();
        let mut file = std::fs::File::open(path).map_err(unreadable)?.take(64);
        file.read_to_end(&mut head).map_err(unreadable)?;
        let side = if head.starts_with(b"RRF") {
            Side::recorded(path)?
        } else if head.trim_ascii_start().starts_with(b"{") {
            Side::of_file(path, &std::fs::read(path).map_err(unreadable)?)?
        } else {
            return Ok(Self::Log(path.to_owned()));
        };
        Ok(Self::Results(Box::new(side)))
    }
}

impl Side {
    fn new(path: &Path, kind: &'static str, results: Results) -> Self {
        Self {
            path: path.to_owned(),
            kind,
            results,
            tolerances: None,
            config: None,
            unrecorded: Vec::new(),
            losses: Vec::new(),
            run: None,
        }
    }

    /// Replays a log; the run is `kept` or not.
    ///
    /// # Errors
    /// As a replay fails.
    fn replayed(path: &Path, config: Config, kept: bool) -> Result<Self, DiffError> {
        let survey = as_it_is(path, &config)?;
        let replay = Replay::new(&survey.log, &config)?;
        let mut run = Kept::default();
        let outcome = match kept {
            true => replay.run(&mut [&mut run])?,
            false => replay.run(&mut [])?,
        };
        let (results, outcome) = all_results(path, &survey, &replay, outcome)?;
        let log = survey.log;
        let losses = log.losses.clone();
        Ok(Self {
            losses,
            config: serde_json::to_value(&config).ok(),
            run: kept.then(|| {
                Box::new(Run {
                    log,
                    config,
                    outcome,
                    kept: run,
                })
            }),
            ..Self::new(path, "log", results)
        })
    }

    /// The results that a recording carries.
    fn recorded(path: &Path) -> Result<Self, DiffError> {
        let carried = read_carried(path).map_err(|source| DiffError::Recording {
            path: path.to_owned(),
            source,
        })?;
        let mut side = Self::of_file(path, carried.features.as_bytes())?;
        side.kind = "recording";
        if let Some(text) = carried.labels {
            let file = LabelsFile::parse(&text).map_err(DiffError::malformed(path))?;
            side.results.log = Some(file.log);
            side.results.noise = file.noise;
            side.results.labels = Some(file.labels);
        }
        Ok(side)
    }

    /// The results in a file, by its schema.
    fn of_file(path: &Path, bytes: &[u8]) -> Result<Self, DiffError> {
        let no_results = |reason: String| {
            let path = path.to_owned();
            DiffError::NoResults { path, reason }
        };
        let found = of_file(bytes).map_err(no_results)?;
        let found = found.ok_or_else(|| no_results("it does not say its schema".to_owned()))?;
        // A golden file of another version is refused by its own reader.
        if relation(&found, GOLDEN) != Relation::Other {
            let (golden, unrecorded) = Golden::read(path)?;
            let config = golden.config.map(serde_json::to_value).transpose();
            return Ok(Self {
                tolerances: Some(golden.tolerances),
                config: config.unwrap_or_default(),
                unrecorded,
                ..Self::new(path, "golden", golden.results)
            });
        }
        match relation(&found, features::SCHEMA) {
            Relation::Same => {}
            Relation::Other => return Err(no_results(format!("its schema is `{found}`"))),
            relation => {
                return Err(DiffError::Version {
                    path: path.to_owned(),
                    found,
                    relation,
                });
            }
        }
        let malformed = DiffError::malformed(path);
        let file: FeaturesFile =
            serde_json::from_slice(bytes).map_err(|error| malformed(in_words(&error)))?;
        let (losses, config) = (file.losses(), file.config.clone());
        let absent = config.as_ref().and_then(|json| {
            let config = Config::deserialize(json).ok()?;
            Some(unrecorded(json, &config))
        });
        Ok(Self {
            losses,
            unrecorded: absent.unwrap_or_default(),
            config,
            ..Self::new(path, "features", file.into_results().map_err(malformed)?)
        })
    }

    /// The configuration that it came from; `None` where it records none.
    ///
    /// # Errors
    /// One that cannot be replayed with.
    fn configuration(&self) -> Result<Option<Config>, DiffError> {
        let unfit = |reason: String| DiffError::RecordedConfig {
            path: self.path.clone(),
            reason,
        };
        let Some(json) = &self.config else {
            return Ok(None);
        };
        let config = Config::deserialize(json).map_err(|error| unfit(error.to_string()))?;
        check(&config).map_err(|error| unfit(error.to_string()))?;
        Ok(Some(config))
    }

    fn json(&self) -> Json {
        json!({
            "file": self.path.display().to_string(),
            "kind": self.kind,
            "log": self.results.log.as_ref().map(|log| &log.file),
            "events_sha256": self.results.log.as_ref().map(|log| &log.events_sha256),
            "map": self.results.map.len(),
            "extracted": self.results.extracted.len(),
            "labels": self.results.labels.as_ref().map(|labels| labels.len()),
            "lost": self.losses,
        })
    }
}
