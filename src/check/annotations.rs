//! Annotations for GitHub Actions: lines that a job prints and the service shows at the files.

use std::fmt::Write as _;

use super::text::sections;
use super::{Report, Verdict};

/// The service shows so many per step.
const MOST: usize = 10;
/// So many for each log, so that one bad log does not hide the others.
const MOST_OF_A_LOG: usize = 3;

/// A line per difference, as far as they are shown.
pub fn annotations(reports: &[Report], strict: bool) -> String {
    let mut text = String::new();
    let lines = reports.iter().flat_map(|report| {
        let file = property(&report.golden.display().to_string());
        let title = property(&format!(
            "{}: {}",
            report.log.display(),
            report.verdict.name()
        ));
        messages(report, strict)
            .into_iter()
            .map(move |message| format!("::error file={file},title={title}::{}", data(&message)))
    });
    for line in lines.take(MOST) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    }
    text
}

fn messages(report: &Report, strict: bool) -> Vec<String> {
    match (&report.verdict, &report.found) {
        (Verdict::Differs, Some(found)) => {
            let sections = sections(found, report.recording.as_deref(), strict);
            let all: Vec<&String> = sections.iter().flat_map(|(_, lines)| lines).collect();
            let mut shown: Vec<String> = all
                .iter()
                .take(MOST_OF_A_LOG)
                .map(|line| (*line).clone())
                .collect();
            if let (Some(last), true) = (shown.last_mut(), all.len() > MOST_OF_A_LOG) {
                let _ = write!(last, " (and {} more)", all.len() - MOST_OF_A_LOG);
            }
            shown
        }
        (verdict, _) => verdict.reason().map(str::to_owned).into_iter().collect(),
    }
}

fn data(text: &str) -> String {
    text.replace('%', "%25")
        .replace('\r', "%0D")
        .replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_end_an_annotation_is_written_otherwise() {
        assert_eq!(data("50 %\nof it"), "50 %25%0Aof it");
        assert_eq!(property("a:b,c"), "a%3Ab%2Cc");
    }
}
