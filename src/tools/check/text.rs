//! A check in words.

use std::fmt::Write as _;

use super::report::{CheckResult, Report};
use crate::core::legible::inert_line;
use crate::tools::golden::{headlines, sections};

/// One log: what came of it, and what differs.
pub fn report(report: &Report, shown: usize, strict: bool) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{:<18}{}",
        word(&report.result),
        inert_line(&report.log.display().to_string())
    );
    let mut say = |indent: usize, line: &str| {
        for line in line.lines() {
            let _ = writeln!(text, "{:indent$}{}", "", inert_line(line));
        }
    };
    if let Some(reason) = report.result.reason() {
        say(4, reason);
    }
    if let Some(compared) = &report.compared {
        let is_told = !compared.found.matches(true);
        for line in headlines(&compared.found, report.recording.as_deref()) {
            say(4, if is_told { &line } else { "" });
        }
        let told = sections(&compared.found, strict).into_iter();
        for section in told.filter(|section| section.name != "cause") {
            say(4, &section.listed(shown));
        }
        if report.result == CheckResult::Blessed && compared.found.matches(true) {
            say(4, "nothing changed beyond the tolerances");
        }
    }
    for note in &report.notes {
        say(4, &format!("note: {note}"));
    }
    let blessed = (report.result == CheckResult::Blessed).then_some(&report.golden);
    for path in blessed.into_iter().chain(&report.artifacts) {
        say(4, &format!("wrote {}", path.display()));
    }
    text
}

/// What a person reads first.
fn word(result: &CheckResult) -> &'static str {
    match result {
        CheckResult::Matches => "ok",
        CheckResult::Differs => "DIFFERS",
        CheckResult::Blessed => "blessed",
        CheckResult::Unchanged => "unchanged",
        CheckResult::Nothing(_) => "NOTHING TO JUDGE",
        CheckResult::Unusable(_) => "UNUSABLE",
    }
}

/// All logs in a line, and what to do about those that differ.
pub fn closing(reports: &[Report], with_artifacts: bool) -> String {
    let kinds = [
        ("matches", "ok"),
        ("blessed", "blessed"),
        ("unchanged", "unchanged"),
        ("differs", "differ"),
        ("nothing to judge", "nothing to judge"),
        ("unusable", "unusable"),
    ];
    let counted = kinds.iter().filter_map(|(name, word)| {
        let n = reports
            .iter()
            .filter(|one| one.result.name() == *name)
            .count();
        let word = if n == 1 && *word == "differ" {
            name
        } else {
            word
        };
        (n > 0).then(|| format!("{n} {word}"))
    });
    let counted: Vec<String> = counted.collect();
    let mut text = match reports.len() {
        0 => "no log falls into this part of the suite: nothing to judge\n".to_owned(),
        1 => format!("1 log: {}\n", counted.join(", ")),
        n => format!("{n} logs: {}\n", counted.join(", ")),
    };
    if reports.iter().any(|one| one.result == CheckResult::Differs) {
        if !with_artifacts {
            text.push_str("--artifacts DIR keeps a recording of every log that differs\n");
        }
        text.push_str(
            "if this is as it should be, run again with --bless and review the golden files\n",
        );
    }
    text
}
