//! Annotations for GitHub Actions: lines that a job prints and the service shows at the files.

use std::fmt::Write as _;

use super::report::Report;
use crate::core::exit::Exit;
use crate::core::legible::legible;
use crate::tools::document::row as row_as_written;
use crate::tools::golden::{Difference, describe, headlines};

/// The service shows so many per step.
const MOST: usize = 10;

/// A line per difference, as far as they are shown: one of each log first, then more of each. The
/// last line counts what is not shown. The notes on the run as a whole are warnings.
pub fn annotations(reports: &[Report], notes: &[String], strict: bool) -> String {
    let of_logs: Vec<Vec<String>> = reports
        .iter()
        .map(|report| {
            let file = property(&report.golden.display().to_string());
            let title = property(&format!(
                "{}: {}",
                report.log.display(),
                report.result.name()
            ));
            let messages = messages(report, strict).into_iter();
            messages
                .map(|(line, message)| {
                    let message = data(&legible(&message));
                    format!("::error file={file},line={line},title={title}::{message}")
                })
                .collect()
        })
        .collect();
    let mut text = String::new();
    if reports.is_empty() {
        text += &refused(&"no log falls into this part of the suite: nothing to judge");
    }
    for line in chosen(&of_logs) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    }
    for note in notes.iter().take(MOST) {
        let note = data(&legible(note));
        let _ = writeln!(text, "::warning title=tmam check::{note}");
    }
    text
}

/// The line for a run that did not begin, or broke off.
pub fn refused(why: &impl std::fmt::Display) -> String {
    let why = data(&legible(&why.to_string()));
    format!("::error title=tmam check::{why}\n")
}

/// The lines that are shown: every log's first, every log's second, and so on; those of one log
/// beside each other.
fn chosen(of_logs: &[Vec<String>]) -> Vec<String> {
    let total: usize = of_logs.iter().map(Vec::len).sum();
    let most = if total > MOST { MOST - 1 } else { MOST };
    let rounds = of_logs.iter().map(Vec::len).max().unwrap_or(0);
    let places = (0..rounds)
        .flat_map(|round| (0..of_logs.len()).map(move |log| (log, round)))
        .filter(|(log, round)| of_logs.get(*log).is_some_and(|lines| lines.len() > *round));
    let mut shown: Vec<(usize, usize)> = places.take(most).collect();
    shown.sort_unstable();
    let line = |(log, round): &(usize, usize)| of_logs.get(*log)?.get(*round).cloned();
    let mut lines: Vec<String> = shown.iter().filter_map(line).collect();
    if total > most {
        let silent = (0..of_logs.len())
            .filter(|log| of_logs.get(*log).is_some_and(|lines| !lines.is_empty()))
            .filter(|log| shown.iter().all(|(other, _)| other != log))
            .count();
        let of_them = match silent {
            0 => String::new(),
            1 => ", and one log of which none is".to_owned(),
            n => format!(", and {n} logs of which none is"),
        };
        lines.push(format!(
            "::error title=tmam check::{} more differences are not shown here{of_them}: see the job's summary or log",
            total - lines.len()
        ));
    }
    lines
}

/// What to say of a log, and at which line of its golden file.
fn messages(report: &Report, strict: bool) -> Vec<(usize, String)> {
    if report.result.exit() == Exit::Done {
        return Vec::new();
    }
    let reason = report.result.reason().map(|reason| (1, reason.to_owned()));
    let mut messages: Vec<(usize, String)> = reason.into_iter().collect();
    // What differs is told where it could not be kept for people, too.
    if let Some(compared) = &report.compared {
        let found = &compared.found;
        let head = headlines(found, report.recording.as_deref());
        if !found.matches(strict) && !head.is_empty() {
            messages.push((1, head.join("\n")));
        }
        let file = std::fs::read_to_string(&report.golden).unwrap_or_default();
        let differences = found.differences.iter().filter(|one| one.fails(strict));
        messages.extend(differences.map(|one| (line_of(&file, one), describe(one))));
    }
    messages
}

/// The line of a golden file that a difference is about, counted from 1; the first where there is none.
fn line_of(file: &str, difference: &Difference) -> usize {
    let section = match difference {
        Difference::Map(_) => "  \"map\"",
        Difference::Extracted(_) => "  \"features\"",
        Difference::Cause(_) => "  \"log\"",
        Difference::Labels(_) | Difference::Borderline(_) => "  \"labels\"",
        Difference::Noise { .. } => "  \"measured_sigma\"",
        Difference::Finding(_) => "  \"findings\"",
        Difference::Requirement { .. } => "  \"quality\"",
    };
    let row = match difference {
        Difference::Map(one) | Difference::Extracted(one) => {
            one.golden.as_ref().and_then(|row| row_as_written(row).ok())
        }
        Difference::Labels(run) | Difference::Borderline(run) => Some(format!(
            "{}: {{",
            serde_json::Value::from(run.sensor.as_str())
        )),
        _ => None,
    };
    let mut lines = (1..).zip(file.lines());
    let of_section = lines.find(|(_, line)| line.starts_with(section));
    let of_row = row.and_then(|row| lines.find(|(_, line)| line.contains(&row)));
    of_row.or(of_section).map_or(1, |(number, _)| number)
}

fn data(text: &str) -> String {
    text.replace('%', "%25")
        .replace('\r', "%0D")
        .replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(&legible(text)).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn logs(counts: &[usize]) -> Vec<Vec<String>> {
        let lines = |(log, n): (usize, &usize)| (0..*n).map(|i| format!("{log}.{i}")).collect();
        counts.iter().enumerate().map(lines).collect()
    }

    #[test]
    fn every_log_is_heard_before_any_is_heard_twice() {
        assert_eq!(chosen(&logs(&[2, 0, 1])), ["0.0", "0.1", "2.0"]);
        let shown = chosen(&logs(&[50, 1, 3]));
        assert_eq!(shown.len(), MOST);
        assert_eq!(shown[..5], ["0.0", "0.1", "0.2", "0.3", "0.4"]);
        assert_eq!(shown[5..9], ["1.0", "2.0", "2.1", "2.2"]);
        assert!(shown[9].contains("::45 more differences"), "{}", shown[9]);
    }

    #[test]
    fn logs_beyond_the_limit_are_counted() {
        assert_eq!(chosen(&logs(&[1; 10])).len(), MOST);
        let shown = chosen(&logs(&[2; 12]));
        assert_eq!(shown.len(), MOST);
        assert!(
            shown[9].contains("::15 more") && shown[9].contains("3 logs of which none"),
            "{}",
            shown[9]
        );
        assert!(chosen(&[]).is_empty());
    }

    #[test]
    fn what_would_end_an_annotation_is_written_otherwise() {
        assert_eq!(data("50 %\nof it"), "50 %25%0Aof it");
        assert_eq!(property("a:b,c"), "a%3Ab%2Cc");
    }
}
