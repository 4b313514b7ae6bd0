//! The report as Markdown, for the page of a CI job.

use std::fmt::Write as _;

use super::sketch::sketch;
use super::text::{SHOWN, closing, sections};
use super::{Report, Verdict};

/// The report as Markdown.
pub fn summary(reports: &[Report], strict: bool) -> String {
    let mut text = String::from("## Sonar maps against golden files\n\n");
    let _ = writeln!(
        text,
        "{}\n",
        closing(reports, true).lines().next().unwrap_or_default()
    );
    if !reports.is_empty() {
        text.push_str(
            "| log | verdict | map | features | labels | borderline |\n|---|---|--:|--:|--:|--:|\n",
        );
    }
    for report in reports {
        let _ = writeln!(
            text,
            "| {} | {} | {} |",
            code(&report.log.display().to_string()),
            verdict(report),
            numbers(report).map_or_else(
                || "- | - | - | -".to_owned(),
                |n| n.map(|n| n.to_string()).join(" | ")
            ),
        );
    }
    for report in reports {
        details(&mut text, report, strict);
    }
    text
}

fn verdict(report: &Report) -> String {
    let bad = !matches!(
        report.verdict,
        Verdict::Matches | Verdict::Unchanged | Verdict::Blessed
    );
    let name = report.verdict.name();
    if bad {
        format!("**{name}**")
    } else {
        name.to_owned()
    }
}

/// Differences in the map, the extracted features and the labels, and borderline labels.
fn numbers(report: &Report) -> Option<[usize; 4]> {
    use crate::golden::Set;
    let found = &report.found.as_ref()?.comparison;
    let arcs = |runs: &mut dyn Iterator<Item = usize>| runs.sum();
    Some([
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
    if report.verdict == Verdict::Differs
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
        content.trim_end_matches('\n')
    );
}

/// A name in a table or a heading.
fn code(name: &str) -> String {
    let name = name.replace(['`', '\n', '\r'], "'").replace('|', "\\|");
    format!("`{name}`")
}
