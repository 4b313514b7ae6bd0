//! The report as Markdown, for the page of a CI job.

use std::fmt::Write as _;

use super::sketch::sketch;
use super::text::{SHOWN, closing, sections};
use super::{Report, Verdict};
use crate::core::legible::{inert_line, legible};
use crate::tools::golden::{Difference, Set};

/// GitHub shows no summary of a step that is longer than 1 MiB; other steps may add to this one.
const MOST_BYTES: usize = 1_000_000;
/// What is kept free for saying what was left out.
const RESERVED: usize = 1_000;

/// The report as Markdown; `notes` are on the run as a whole.
///
/// It is kept below what GitHub shows: what does not fit is counted, not cut in the middle.
pub fn summary(reports: &[Report], notes: &[String], strict: bool) -> String {
    within(MOST_BYTES, reports, notes, strict)
}

/// The summary of a run that did not begin.
pub fn refused(why: &str) -> String {
    let mut text = format!("{TITLE}**nothing was checked**\n\n");
    block(&mut text, why);
    text
}

const TITLE: &str = "## Sonar maps against golden files\n\n";

fn within(most: usize, reports: &[Report], notes: &[String], strict: bool) -> String {
    let mut text = String::from(TITLE);
    let room = most.saturating_sub(RESERVED);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}\n",
        closing(reports, true).lines().next().unwrap_or_default()
    );
    for note in notes {
        block(&mut text, &format!("note: {note}"));
    }
    if !reports.is_empty() {
        text.push_str(
            "| log | verdict | sonars | map | features | labels | borderline |\n|---|---|--:|--:|--:|--:|--:|\n",
        );
    }
    let mut rows_left_out = 0_usize;
    // Those that need somebody's eye come first where not all have room.
    let (bad, good): (Vec<&Report>, Vec<&Report>) =
        reports.iter().partition(|report| needs_a_look(report));
    let fits = reports.len().saturating_mul(300) < room;
    let in_order: Vec<&Report> = if fits {
        reports.iter().collect()
    } else {
        bad.into_iter().chain(good).collect()
    };
    for report in &in_order {
        let row = row(report);
        if text.len() + row.len() > room {
            rows_left_out += 1;
        } else {
            text.push_str(&row);
        }
    }
    let mut details_left_out = 0_usize;
    for report in &in_order {
        let mut one = String::new();
        details(&mut one, report, strict);
        if text.len() + one.len() > room {
            details_left_out += 1;
        } else {
            text.push_str(&one);
        }
    }
    for (count, what) in [
        (rows_left_out, "rows of the table"),
        (details_left_out, "logs' differences"),
    ] {
        if count > 0 {
            let _ = writeln!(
                text,
                "\n**Left out for length: {count} {what}.** The JUnit report and `--json` have them all."
            );
        }
    }
    text
}

fn row(report: &Report) -> String {
    format!(
        "| {} | {} | {} |\n",
        code(&report.log.display().to_string()),
        verdict(report),
        numbers(report).map_or_else(
            || "- | - | - | - | -".to_owned(),
            |n| n.map(|n| n.to_string()).join(" | ")
        ),
    )
}

fn needs_a_look(report: &Report) -> bool {
    !matches!(
        report.verdict,
        Verdict::Matches | Verdict::Unchanged | Verdict::Blessed
    )
}

fn verdict(report: &Report) -> String {
    let name = report.verdict.name();
    if needs_a_look(report) {
        format!("**{name}**")
    } else {
        name.to_owned()
    }
}

/// Differences in the sonars and their noise, the map, the extracted features and the labels, and borderline labels.
fn numbers(report: &Report) -> Option<[usize; 5]> {
    let found = &report.found.as_ref()?.comparison;
    let arcs = |runs: &mut dyn Iterator<Item = usize>| runs.sum();
    let is_sonar = |one: &&Difference| matches!(one, Difference::Sonar(_) | Difference::Noise(_));
    Some([
        found.differences.iter().filter(is_sonar).count(),
        found.features(Set::Map).count(),
        found.features(Set::Extracted).count(),
        arcs(&mut found.labels().map(|run| run.arcs.len())),
        arcs(&mut found.borderline.iter().map(|run| run.arcs.len())),
    ])
}

// Writing to a string cannot fail.
fn details(text: &mut String, report: &Report, strict: bool) {
    let sections = report
        .found
        .as_ref()
        .map(|found| sections(found, report.recording.as_deref(), strict))
        .unwrap_or_default();
    let nothing =
        sections.is_empty() && report.verdict.reason().is_none() && report.notes.is_empty();
    if nothing {
        return;
    }
    let _ = writeln!(text, "\n### {}\n", code(&report.log.display().to_string()));
    if let Some(reason) = report.verdict.reason() {
        block(text, reason);
    }
    for note in &report.notes {
        block(text, &format!("note: {note}"));
    }
    for (head, lines) in &sections {
        let _ = writeln!(text, "**{}**\n", head.replace("->", "→"));
        let shown: Vec<&str> = lines.iter().take(SHOWN).map(String::as_str).collect();
        block(text, &shown.join("\n"));
        if lines.len() > SHOWN {
            let _ = writeln!(text, "... and {} more\n", lines.len() - SHOWN);
        }
    }
    if needs_a_look(report)
        && let Some(found) = &report.found
    {
        let map = sketch(&found.golden.results.map, &found.comparison);
        if !map.is_empty() {
            let _ = writeln!(
                text,
                "<details><summary>The map: <code>.</code> as it was, <code>-</code> moved or missing, \
                 <code>#</code> moved or new</summary>\n"
            );
            block(text, &map);
            text.push_str("</details>\n\n");
        }
    }
    for path in &report.artifacts {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let _ = writeln!(text, "- artefact {}", code(&name.to_string_lossy()));
    }
}

/// Text as it is, whatever it holds.
fn block(text: &mut String, content: &str) {
    let longest = content.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest.max(2) + 1);
    let _ = writeln!(
        text,
        "{fence}text\n{}\n{fence}\n",
        legible(content.trim_end_matches('\n'))
    );
}

/// A name in a table or a heading.
fn code(name: &str) -> String {
    let name = inert_line(name).replace('`', "'").replace('|', "\\|");
    format!("`{name}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unusable(log: &str, reason: &str) -> Report {
        Report {
            log: log.into(),
            golden: "golden".into(),
            verdict: Verdict::Unusable(reason.to_owned()),
            notes: Vec::new(),
            found: None,
            artifacts: Vec::new(),
            recording: None,
        }
    }

    #[test]
    fn a_long_summary_says_what_it_leaves_out() {
        let reports: Vec<Report> = (0..40)
            .map(|i| unusable(&format!("drive_{i:02}.mcap"), &"torn ".repeat(40)))
            .collect();
        let whole = within(MOST_BYTES, &reports, &[], false);
        assert!(!whole.contains("Left out"), "{whole}");
        let part = within(whole.len() / 2, &reports, &[], false);
        assert!(
            part.len() <= whole.len() / 2,
            "{} of {}",
            part.len(),
            whole.len()
        );
        let shown = part.matches("### ").count();
        assert!(shown > 0 && shown < 40);
        assert!(
            part.contains(&format!(
                "Left out for length: {} logs' differences",
                40 - shown
            )),
            "{part}"
        );
        assert_eq!(part.matches("```").count() % 2, 0, "every block is closed");
    }
}
