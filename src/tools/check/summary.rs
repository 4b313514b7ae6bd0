//! The report as Markdown, for the page of a CI job.

use std::ffi::OsStr;
use std::fmt::Write as _;

use super::report::Report;
use super::text::closing;
use crate::core::exit::Exit;
use crate::core::geometry::Vec2;
use crate::core::legible::{inert_line, legible};
use crate::tools::golden::{
    Comparison, Feature, FeatureDifference, Geometry, Quality, SHOWN, from_to, headlines, sections,
};

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

/// What the table says of how good a log's results are: as [`Quality::columns`], after whether they got better.
const HEADS: [&str; 8] = [
    "it got",
    "walls",
    "points",
    "circles",
    "labelled arcs",
    "suspects",
    "explained",
    "wrong labels",
];

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
    let has_circles = |both: &(Option<Quality>, Quality)| {
        both.1.circles.is_some() || both.0.is_some_and(|then| then.circles.is_some())
    };
    let circles = reports
        .iter()
        .filter_map(quality)
        .any(|both| has_circles(&both));
    if !reports.is_empty() {
        text.push_str(&head(circles));
    }
    let known: Vec<(Option<Quality>, Quality)> = reports.iter().filter_map(quality).collect();
    if known.len() > 1 {
        let now: Vec<Quality> = known.iter().map(|(_, now)| *now).collect();
        let then = known.iter().map(|(then, now)| then.unwrap_or(*now));
        let then: Vec<Quality> = then.collect();
        let is_old = known.iter().any(|(then, _)| then.is_some());
        let then_all = is_old.then(|| Quality::of_all(&then));
        let all = (then_all, Quality::of_all(&now));
        let _ = writeln!(
            text,
            "| **all {}** | | {} | |",
            then.len(),
            columns(&all, circles)
        );
    }
    // Those that need somebody's eye come first where not all have room.
    let mut in_order: Vec<&Report> = reports.iter().collect();
    if reports.len().saturating_mul(300) >= room {
        in_order.sort_by_key(|report| !needs_a_look(report));
    }
    // Adds what has room; how many have none.
    let mut add = |part: &dyn Fn(&Report) -> String| {
        let parts = in_order.iter().map(|report| part(report));
        let left_out = parts.filter(|part| {
            let fits = text.len() + part.len() <= room;
            text.push_str(if fits { part } else { "" });
            !fits
        });
        left_out.count()
    };
    let rows = (add(&|report| row(report, circles)), "rows of the table");
    let details = (add(&|report| details(report, strict)), "logs' differences");
    for (count, what) in [rows, details].into_iter().filter(|(count, _)| *count > 0) {
        let _ = writeln!(
            text,
            "\n**Left out for length: {count} {what}.** The JUnit report and `--json` have them all."
        );
    }
    text
}

/// The head of the table, with circles or without.
fn head(circles: bool) -> String {
    let heads = HEADS
        .into_iter()
        .filter(|head| circles || *head != "circles");
    let heads: Vec<&str> = heads.collect();
    let lines = "|--:".repeat(heads.len());
    format!(
        "| log | verdict | {} | differences |\n|---|---{}|--:|\n",
        heads.join(" | "),
        lines.replacen("|--:", "|---", 1)
    )
}

fn row(report: &Report, circles: bool) -> String {
    let found = report.compared.as_ref().map(|compared| &compared.found);
    let differ = found.map(|found| found.differences.iter().filter(|one| one.fails(false)));
    format!(
        "| {} | {} | {} | {} |\n",
        code(&report.log.display().to_string()),
        result(report),
        quality(report).map_or_else(
            || vec!["-"; HEADS.len() - usize::from(!circles)].join(" | "),
            |both| columns(&both, circles)
        ),
        differ.map_or_else(|| "-".to_owned(), |differ| differ.count().to_string()),
    )
}

/// How good a log's results were, where that is known, and are.
fn quality(report: &Report) -> Option<(Option<Quality>, Quality)> {
    let now = report.quality?;
    let found = report.compared.as_ref().map(|compared| &compared.found);
    let then = found.and_then(|found| found.quality).map(|[then, _]| then);
    Some((then, now))
}

/// Whether it got better, and its numbers, then and now.
fn columns((then, now): &(Option<Quality>, Quality), circles: bool) -> String {
    let trend = then.map_or("new", |then| now.trend(&then).name());
    let numbers = then.unwrap_or(*now).columns().into_iter();
    let numbers = numbers.zip(now.columns());
    let numbers = numbers.map(|(then, now)| from_to(&then, &now).replace("->", "→"));
    let cells = std::iter::once(trend.to_owned()).chain(numbers).zip(HEADS);
    let cells = cells.filter(|(_, head)| circles || *head != "circles");
    cells.map(|(cell, _)| cell).collect::<Vec<_>>().join(" | ")
}

fn needs_a_look(report: &Report) -> bool {
    report.result.exit() != Exit::Done
}

fn result(report: &Report) -> String {
    let name = report.result.name();
    if needs_a_look(report) {
        format!("**{name}**")
    } else {
        name.to_owned()
    }
}

// Writing to a string cannot fail.
fn details(report: &Report, strict: bool) -> String {
    let mut text = String::new();
    let compared = report.compared.as_ref();
    let sections = compared.map_or_else(Vec::new, |compared| sections(&compared.found, strict));
    let nothing =
        sections.is_empty() && report.result.reason().is_none() && report.notes.is_empty();
    if nothing {
        return text;
    }
    let _ = writeln!(text, "\n### {}\n", code(&report.log.display().to_string()));
    if let Some(reason) = report.result.reason() {
        block(&mut text, reason);
    }
    for note in &report.notes {
        block(&mut text, &format!("note: {note}"));
    }
    if let Some(compared) = compared.filter(|_| !sections.is_empty()) {
        let head = headlines(&compared.found, report.recording.as_deref());
        if !head.is_empty() {
            block(&mut text, &head.join("\n"));
        }
    }
    for section in sections.iter().filter(|section| section.name != "cause") {
        let _ = writeln!(text, "**{}**\n", section.heading.replace("->", "→"));
        let lines = &section.lines;
        let shown = lines.iter().take(SHOWN).map(String::as_str);
        block(&mut text, &shown.collect::<Vec<_>>().join("\n"));
        if lines.len() > SHOWN {
            let _ = writeln!(text, "and {} more\n", lines.len() - SHOWN);
        }
    }
    if needs_a_look(report)
        && let Some(compared) = compared
    {
        let map = sketch(&compared.map, &compared.found);
        if !map.is_empty() {
            let _ = writeln!(
                text,
                "<details><summary>The map: <code>.</code> as it was, <code>-</code> moved or missing, \
                 <code>#</code> moved or new</summary>\n"
            );
            block(&mut text, &map);
            text.push_str("</details>\n\n");
        }
    }
    for path in &report.artifacts {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let what = match path.extension().and_then(OsStr::to_str) {
            Some("svg") => "the map before and after",
            Some("rrd") => "the recording, which opens at the first difference",
            _ => "the golden file that would match",
        };
        let _ = writeln!(text, "- {what}: {}", code(&name.to_string_lossy()));
    }
    text
}

/// The golden map in letters, and over it what moved: `.` as it was, `-` what moved or is missing, `#` what
/// moved or is new. Points are `o` where they are as they were.
fn sketch(golden: &[Feature], found: &Comparison) -> String {
    const COLUMNS: usize = 76;
    const MOST_ROWS: usize = 40;
    /// Letters are about twice as high as they are wide.
    const ASPECT: f64 = 2.0;
    let is_point = |feature: &Feature| matches!(feature.geometry, Geometry::Point { .. });
    let moved = |of: &dyn Fn(&FeatureDifference) -> Option<&Feature>, letter| {
        let drawn = found.elsewhere().filter_map(|one| of(one).map(places));
        drawn
            .map(move |places| (places, letter))
            .collect::<Vec<_>>()
    };
    let layers: Vec<(Vec<Vec2>, char)> = golden
        .iter()
        .map(|feature| (places(feature), if is_point(feature) { 'o' } else { '.' }))
        .chain(moved(&|one| one.golden.as_ref(), '-'))
        .chain(moved(&|one| one.actual.as_ref(), '#'))
        .collect();
    let all = || layers.iter().flat_map(|(places, _)| places);
    let Some(first) = all().next() else {
        return String::new();
    };
    let low = all().fold(*first, |low, at| low.inf(at));
    let high = all().fold(*first, |high, at| high.sup(at));
    let span = high - low;
    let cell = (span.x / (COLUMNS - 1) as f64)
        .max(span.y / ASPECT / (MOST_ROWS - 1) as f64)
        .max(1e-3);
    let rows = ((span.y / cell / ASPECT).round() as usize).min(MOST_ROWS - 1) + 1;
    let columns = ((span.x / cell).round() as usize).min(COLUMNS - 1) + 1;
    let mut grid = vec![vec![' '; columns]; rows];
    for (places, letter) in &layers {
        for at in places {
            let column = ((at.x - low.x) / cell).round() as usize;
            let row = ((high.y - at.y) / cell / ASPECT).round() as usize;
            if let Some(spot) = grid.get_mut(row).and_then(|row| row.get_mut(column)) {
                *spot = *letter;
            }
        }
    }
    let lines: Vec<String> = grid
        .into_iter()
        .map(|row| row.into_iter().collect::<String>().trim_end().to_owned())
        .collect();
    format!("{}\n(a letter is {cell:.2} m wide)\n", lines.join("\n"))
}

/// Places along a feature, near enough to each other to draw it.
fn places(feature: &Feature) -> Vec<Vec2> {
    const STEPS: u32 = 160;
    let Some([from, to]) = feature.geometry.ends() else {
        return Vec::new();
    };
    (0..=STEPS)
        .map(|i| from + (to - from) * (f64::from(i) / f64::from(STEPS)))
        .collect()
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
    use super::super::report::CheckResult;
    use super::*;

    fn unusable(log: &str, reason: &str) -> Report {
        Report {
            log: log.into(),
            golden: "golden".into(),
            result: CheckResult::Unusable(reason.to_owned()),
            notes: Vec::new(),
            compared: None,
            quality: None,
            artifacts: Vec::new(),
            recording: None,
            seconds: 0.0,
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
