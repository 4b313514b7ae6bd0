//! JUnit XML: a suite per log, a case per kind of check.
//!
//! Written so that it is valid both by the schema of Ant's reports, which wants every attribute and
//! element there is, and by the one of Jenkins, which allows few more.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::text::sections;
use super::{Report, Verdict};

/// A case: what was checked, and what came of it.
struct Case {
    name: &'static str,
    outcome: Outcome,
}

enum Outcome {
    Passed,
    /// What differs, a line each.
    Failed(Vec<String>),
    /// What kept it from being judged, in a word and in full.
    Error(&'static str, String),
}

/// The report as JUnit XML.
///
/// # Errors
/// When it cannot be XML.
pub fn junit(reports: &[Report], strict: bool) -> io::Result<String> {
    let mut suites: Vec<(String, Vec<Case>)> = reports
        .iter()
        .map(|report| (report.log.display().to_string(), cases(report, strict)))
        .collect();
    if suites.is_empty() {
        let outcome = Outcome::Error("nothing to judge", "no log was checked".to_owned());
        let case = Case {
            name: "suite",
            outcome,
        };
        suites.push(("tmam check".to_owned(), vec![case]));
    }
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("testsuites")
        .write_inner_content(|xml| {
            let mut numbered = suites.iter().zip(0_u32..);
            numbered.try_for_each(|((name, cases), id)| suite(xml, &clean(name), id, cases))
        })?;
    let mut text = String::from_utf8_lossy(&xml.into_inner()).into_owned();
    text.push('\n');
    Ok(text)
}

fn suite(xml: &mut Writer<Vec<u8>>, name: &str, id: u32, cases: &[Case]) -> io::Result<()> {
    let count = |of: fn(&Outcome) -> bool| cases.iter().filter(|case| of(&case.outcome)).count();
    let failures = count(|outcome| matches!(outcome, Outcome::Failed(_)));
    let errors = count(|outcome| matches!(outcome, Outcome::Error(..)));
    let suite = xml.create_element("testsuite").with_attributes([
        ("name", name),
        ("package", "tmam"),
        ("id", id.to_string().as_str()),
        // The same logs give the same report, so it names neither time nor machine.
        ("timestamp", "1970-01-01T00:00:00"),
        ("hostname", "localhost"),
        ("time", "0"),
        ("tests", cases.len().to_string().as_str()),
        ("failures", failures.to_string().as_str()),
        ("errors", errors.to_string().as_str()),
        ("skipped", "0"),
    ]);
    suite.write_inner_content(|xml| {
        xml.create_element("properties").write_empty()?;
        for case in cases {
            write_case(xml, case, name)?;
        }
        xml.create_element("system-out").write_empty()?;
        xml.create_element("system-err").write_empty()?;
        Ok(())
    })?;
    Ok(())
}

fn write_case(xml: &mut Writer<Vec<u8>>, case: &Case, log: &str) -> io::Result<()> {
    let element = xml.create_element("testcase").with_attributes([
        ("name", case.name),
        ("classname", log),
        ("time", "0"),
    ]);
    let (tag, kind, message, text) = match &case.outcome {
        Outcome::Passed => return element.write_empty().map(|_| ()),
        Outcome::Failed(lines) => {
            let first = lines.first().cloned().unwrap_or_default();
            let message = match lines.len() {
                0 | 1 => first,
                n => format!("{first}; and {} more", n - 1),
            };
            ("failure", "differs", message, lines.join("\n"))
        }
        Outcome::Error(kind, reason) => ("error", *kind, reason.clone(), reason.clone()),
    };
    element.write_inner_content(|xml| {
        let (message, text) = (clean(&message), clean(&text));
        let inner = xml
            .create_element(tag)
            .with_attributes([("type", kind), ("message", message.as_str())]);
        inner.write_text_content(BytesText::new(&text))?;
        Ok(())
    })?;
    Ok(())
}

/// Without the characters that XML has no way to write.
fn clean(text: &str) -> String {
    let fine =
        |c: char| matches!(c, '\t' | '\n') || (c >= ' ' && !matches!(c, '\u{fffe}' | '\u{ffff}'));
    text.chars()
        .map(|c| if fine(c) { c } else { '?' })
        .collect()
}

fn cases(report: &Report, strict: bool) -> Vec<Case> {
    let case = |name, outcome| Case { name, outcome };
    if let Some(reason) = report.verdict.reason() {
        let outcome = Outcome::Error(report.verdict.name(), reason.to_owned());
        return vec![case("replay", outcome)];
    }
    let Some(found) = report
        .found
        .as_ref()
        .filter(|_| report.verdict != Verdict::Blessed)
    else {
        return vec![case("golden file", Outcome::Passed)];
    };
    let sections = sections(found, report.recording.as_deref(), strict);
    let mut kinds = vec!["log", "map", "extracted features", "labels"];
    if strict {
        kinds.push("borderline labels");
    }
    let of = |kind: &str| -> Vec<String> {
        let heads = sections.iter().filter(|(head, _)| head.starts_with(kind));
        heads.flat_map(|(_, lines)| lines.clone()).collect()
    };
    kinds
        .into_iter()
        .map(|kind| match of(kind) {
            lines if lines.is_empty() => case(kind, Outcome::Passed),
            lines => case(kind, Outcome::Failed(lines)),
        })
        .collect()
}
