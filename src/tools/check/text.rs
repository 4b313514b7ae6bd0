//! What a check says to a person.

use std::fmt::Write as _;
use std::path::Path;

use super::{Found, Report, Verdict};
use crate::core::legible::inert_line;
use crate::tools::diff::Pair;
use crate::tools::golden::{Comparison, Difference, Results, Set, Tolerance, counts, describe};

/// More differences of a kind than this are counted, not listed.
pub const SHOWN: usize = 20;

/// One log: its verdict, and what differs.
pub fn report(report: &Report, shown: usize, strict: bool) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{:<18}{}",
        word(&report.verdict),
        inert_line(&report.log.display().to_string())
    );
    let mut say = |indent: usize, line: &str| {
        for line in line.lines() {
            let _ = writeln!(text, "{:indent$}{}", "", inert_line(line));
        }
    };
    if let Some(reason) = report.verdict.reason() {
        say(4, reason);
    }
    if let Some(found) = &report.found {
        let blessed = report.verdict == Verdict::Blessed;
        for (head, lines) in sections(found, report.recording.as_deref(), strict) {
            say(4, &listed(&head, &lines, shown));
        }
        if blessed && found.comparison.matches(true) {
            say(4, "nothing changed beyond the tolerances");
        }
    }
    for note in &report.notes {
        say(4, &format!("note: {note}"));
    }
    match report.verdict {
        Verdict::Blessed => say(4, &format!("wrote {}", report.golden.display())),
        _ => {
            for path in &report.artifacts {
                say(4, &format!("wrote {}", path.display()));
            }
        }
    }
    text
}

/// A heading and what is under it, as far as it is shown.
fn listed(head: &str, lines: &[String], shown: usize) -> String {
    let mut text = format!("{head}\n");
    for line in lines.iter().take(shown) {
        let _ = writeln!(text, "  {line}");
    }
    if lines.len() > shown {
        let _ = writeln!(
            text,
            "  ... and {} more (--show N, --json)",
            lines.len() - shown
        );
    }
    text
}

/// What differs between two sides, and on what terms they were compared.
pub fn differences(
    pair: &Pair,
    found: &Comparison,
    tolerance: &Tolerance,
    shown: usize,
    strict: bool,
) -> String {
    let mut text = String::new();
    for (name, side) in [("a", &pair.a), ("b", &pair.b)] {
        let labels = match &side.results.labels {
            Some(labels) => format!("{} arcs", labels.len()),
            None => "no labels".to_owned(),
        };
        let _ = writeln!(
            text,
            "{name}  {}: {} map features, {} extracted, {labels}{}",
            inert_line(&side.path.display().to_string()),
            side.results.map.len(),
            side.results.extracted.len(),
            if side.losses.is_empty() {
                ""
            } else {
                ", INCOMPLETE"
            }
        );
    }
    for note in &pair.notes {
        let _ = writeln!(text, "note: {}", inert_line(note));
    }
    let sides = [&pair.a.results, &pair.b.results];
    let sections = kinds(sides, found, tolerance, None, strict);
    for (head, lines) in &sections {
        text.push_str(&listed(head, lines, shown));
    }
    if sections.is_empty() {
        text.push_str("nothing differs beyond the tolerances\n");
    }
    text
}

/// What differs, kind by kind, each difference in a line.
pub fn sections(
    found: &Found,
    recording: Option<&Path>,
    strict: bool,
) -> Vec<(String, Vec<String>)> {
    let sides = [&found.golden.results, &found.actual];
    let tolerance = &found.golden.tolerances;
    kinds(sides, &found.comparison, tolerance, recording, strict)
}

fn kinds(
    [golden, actual]: [&Results; 2],
    comparison: &Comparison,
    tolerance: &Tolerance,
    recording: Option<&Path>,
    strict: bool,
) -> Vec<(String, Vec<String>)> {
    let lines = |of: &dyn Fn(&Difference) -> bool| -> Vec<String> {
        let chosen = comparison.differences.iter().filter(|one| of(one));
        chosen.map(|one| describe(one, recording)).collect()
    };
    let in_set =
        |set: Set| move |one: &Difference| matches!(one, Difference::Feature(f) if f.set == set);
    let labels = match (&golden.labels, &actual.labels) {
        (Some(golden), Some(actual)) => format!("labels: {}", counts(golden, actual)),
        _ => "labels".to_owned(),
    };
    let borderline = comparison
        .borderline
        .iter()
        .map(|run| describe(&Difference::Labels(run.clone()), recording))
        .collect();
    let near = format!(
        "borderline labels (less than {} deg or chi2 {} to spare){}",
        (tolerance.borderline.to_degrees() * 1e4).round() / 1e4,
        tolerance.borderline_chi2,
        if strict {
            ""
        } else {
            ", which fail only with --strict"
        }
    );
    let all = [
        (
            "log".to_owned(),
            lines(&|one| matches!(one, Difference::Log { .. })),
        ),
        (
            "range noise".to_owned(),
            lines(&|one| matches!(one, Difference::Noise(_))),
        ),
        (
            "sonars".to_owned(),
            lines(&|one| matches!(one, Difference::Sonar(_))),
        ),
        ("map".to_owned(), lines(&in_set(Set::Map))),
        (
            "extracted features".to_owned(),
            lines(&in_set(Set::Extracted)),
        ),
        (labels, lines(&|one| matches!(one, Difference::Labels(_)))),
        (near, borderline),
    ];
    all.into_iter()
        .filter(|(_, lines)| !lines.is_empty())
        .collect()
}

/// What a person reads first.
fn word(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Matches => "ok",
        Verdict::Differs => "DIFFERS",
        Verdict::Blessed => "blessed",
        Verdict::Unchanged => "unchanged",
        Verdict::Nothing(_) => "NOTHING TO JUDGE",
        Verdict::Unusable(_) => "UNUSABLE",
    }
}

/// All logs in a line, and what to do about those that differ.
pub fn closing(reports: &[Report], with_artifacts: bool) -> String {
    let kinds = [
        ("ok", Verdict::Matches.name()),
        ("blessed", Verdict::Blessed.name()),
        ("unchanged", Verdict::Unchanged.name()),
        ("differ", Verdict::Differs.name()),
        ("nothing to judge", "nothing to judge"),
        ("unusable", "unusable"),
    ];
    let counted: Vec<String> = kinds
        .iter()
        .filter_map(|(word, name)| {
            let n = reports
                .iter()
                .filter(|one| one.verdict.name() == *name)
                .count();
            let word = if n == 1 && *word == "differ" {
                "differs"
            } else {
                *word
            };
            (n > 0).then(|| format!("{n} {word}"))
        })
        .collect();
    let mut text = match reports.len() {
        0 => "no log falls into this part of the suite: nothing to judge\n".to_owned(),
        1 => format!("1 log: {}\n", counted.join(", ")),
        n => format!("{n} logs: {}\n", counted.join(", ")),
    };
    if reports.iter().any(|one| one.verdict == Verdict::Differs) {
        if !with_artifacts {
            text.push_str("--artifacts DIR keeps a recording of every log that differs\n");
        }
        text.push_str(
            "if this is as it should be, run again with --bless and review the golden files\n",
        );
    }
    text
}
