//! The closing summary of a replay, for a person.

mod hints;

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::path::PathBuf;

use crate::core::config::Rule;
use crate::core::legible::legible;
use crate::core::log::Log;
use crate::core::noise_estimate::VarianceFrom;
use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::core::tmam::feature::{Action, Kind, MapFeature, Status};
use crate::core::tmam::map::duplicates;
use crate::core::wording::counted as plural;
use crate::io::log::itemised;
use crate::observe::viewer::VERSION;

/// What a replay came to, the files it wrote and how to open them.
///
/// `named` is the log with the flags of the configuration, as one types them.
pub fn closing(
    setting: &Setting<'_>,
    outcome: &Outcome,
    named: &str,
    written: &[PathBuf],
) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    let _ = write(&mut text, setting, outcome);
    text.push_str(&self::written(written));
    text.extend(hints::fitting_neither(setting, outcome, named));
    text
}

/// The files that were written, and how to open them.
pub fn written(files: &[PathBuf]) -> String {
    let mut text = String::new();
    for path in files {
        let _ = writeln!(text, "wrote      {}", path.display());
        if path.extension().is_some_and(|extension| extension == "rrd") {
            let _ = writeln!(
                text,
                "open with  rerun {}    (viewer {VERSION}: pip install rerun-sdk=={VERSION})",
                path.display()
            );
        }
    }
    text
}

/// What a person must know of the log: notes, losses, and that there was nothing to judge.
pub fn problems(log: &Log, setting: &Setting<'_>, outcome: &Outcome) -> String {
    let mut text = String::new();
    for note in log.told() {
        let _ = writeln!(text, "note: {note}");
    }
    if !log.losses.is_empty() {
        let losses = itemised(&log.losses);
        let _ = writeln!(
            text,
            "warning: {} could not be read whole. Lost:{losses}",
            log.file
        );
    }
    if let Some(note) = hints::without_effect(setting, outcome) {
        let _ = writeln!(text, "note: {note}");
    }
    let scatter = outcome.scattering.overall();
    if let Some(scatter) = scatter.filter(|s| s.ratio > 1.0 && !s.is_as_expected()) {
        let _ = writeln!(
            text,
            "note: {}, so that readings which belong together seem not to; {}",
            scatter.complaint(),
            scatter.mend(outcome.variance_from)
        );
    }
    if outcome.tally.echoes == 0 {
        text.push_str(
            "warning: not one reading is an echo; look at range, min_range and max_range\n",
        );
    }
    legible(&text).into_owned()
}

fn write(text: &mut String, setting: &Setting<'_>, outcome: &Outcome) -> fmt::Result {
    let source = setting.source;
    let seconds = source.end_ns.saturating_sub(source.start_ns) as f64 * 1e-9;
    writeln!(
        text,
        "{}: {seconds:.1} s, {:.1} m, {}{}",
        source.file,
        outcome.distance,
        plural(setting.sonars.len() as u64, "sonar"),
        if source.complete { "" } else { ", INCOMPLETE" },
    )?;

    let tally = &outcome.tally;
    let mut row = |name: &str, count: u64, what: &str| row(text, name, count, what);
    row("frames", outcome.frames.into(), "")?;
    let surplus = match tally.surplus {
        0 => String::new(),
        n => format!(", {n} more than their frames had room for"),
    };
    row(
        "readings",
        tally.readings,
        &format!(
            "{}, {} without{surplus}",
            plural(tally.echoes, "echo"),
            tally.no_echoes
        ),
    )?;
    let dropped: u64 = tally.dropped.values().sum();
    if dropped > 0 {
        row("dropped", dropped, &counted(&tally.dropped))?;
    }
    let [contact, intersection, unidentified] =
        ["contact", "intersection", "unidentified"].map(|label| outcome.labelled(label));
    row(
        "arcs",
        contact + intersection + unidentified,
        &format!("{contact} contact, {intersection} intersection, {unidentified} unidentified"),
    )?;
    if unidentified > 0 {
        row(
            "",
            unidentified,
            &format!("unidentified: {}", counted(&outcome.reasons)),
        )?;
    }
    if outcome.suspects > 0 {
        row(
            "suspects",
            outcome.suspects,
            "labels that are contradicted: tmam explain --suspects says by what",
        )?;
    }
    let from = match outcome.variance_from {
        VarianceFrom::Ranges => Some("measured from the ranges"),
        VarianceFrom::Nothing => Some("assumed: too little to measure it"),
        VarianceFrom::Messages | VarianceFrom::Configuration => None,
    };
    if let (Some(from), Some(sigma)) = (from, setting.config.noise.sigma_abs) {
        let what = format!("{from}; noise.sigma_abs overrules it");
        writeln!(text, "{:<10} {:>4.1} mm  {what}", "noise", sigma * 1e3)?;
    }
    write_features(text, setting, outcome)
}

fn write_features(text: &mut String, setting: &Setting<'_>, outcome: &Outcome) -> fmt::Result {
    let extractions = &outcome.extractions;
    let of_kind = |kind| extractions.iter().filter(|e| e.kind == kind).count() as u64;
    let mut actions = BTreeMap::<&str, u64>::new();
    for extraction in extractions {
        let action = match extraction.action {
            Action::Registered(_) => "registered",
            Action::Merged(_) => "merged",
            Action::Rejected(reason) => reason.name(),
        };
        *actions.entry(action).or_default() += 1;
    }
    let mut row = |name: &str, count: usize, what: &str| row(text, name, count as u64, what);
    row(
        "features",
        extractions.len(),
        &format!(
            "{}, {} from {}{}",
            plural(of_kind(Kind::Line), "line"),
            plural(of_kind(Kind::Point), "point"),
            plural(outcome.associated_readings, "reading"),
            if actions.is_empty() {
                String::new()
            } else {
                format!(": {}", counted(&actions))
            },
        ),
    )?;
    let (confirmed, tentative): (Vec<&MapFeature>, Vec<&MapFeature>) = outcome
        .map
        .iter()
        .partition(|f| f.status == Status::Confirmed);
    let lines = confirmed.iter().filter(|f| f.shape.kind() == Kind::Line);
    let lines = lines.count();
    let more = match tentative.len() {
        0 => String::new(),
        1 => "; 1 more is tentative: too little speaks for it".to_owned(),
        n => format!("; {n} more are tentative: too little speaks for them"),
    };
    let twice = match setting.config.rule {
        Rule::Paper => duplicates(&outcome.map, setting.config.map.match_distance),
        Rule::NoiseAware => 0,
    };
    let duplicates = match twice {
        0 => String::new(),
        1 => "; 1 of them looks like another one (the paper's gates leave duplicates)".to_owned(),
        n => format!("; {n} of them look like another one (the paper's gates leave duplicates)"),
    };
    row(
        "map",
        confirmed.len(),
        &format!(
            "{}, {}{more}{duplicates}",
            plural(lines as u64, "line"),
            plural((confirmed.len() - lines) as u64, "point"),
        ),
    )
}

fn row(text: &mut String, name: &str, count: u64, what: &str) -> fmt::Result {
    let line = format!("{name:<10} {count:>7}  {what}");
    writeln!(text, "{}", line.trim_end())
}

/// `3 gap, 2 missing`, the largest first.
fn counted(counts: &BTreeMap<&'static str, u64>) -> String {
    let mut counts: Vec<_> = counts.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    let counts: Vec<String> = counts
        .iter()
        .map(|(what, n)| format!("{n} {what}"))
        .collect();
    counts.join(", ")
}
