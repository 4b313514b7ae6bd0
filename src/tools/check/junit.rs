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
    /// What was not looked at.
    Skipped(String),
}

/// More differences of a kind than this are counted, not listed.
const LISTED: usize = 200;

/// A suite's name, its cases, and what is to be said beside them.
struct Suite {
    name: String,
    cases: Vec<Case>,
    notes: Vec<String>,
}

/// The report as JUnit XML; `notes` are on the run as a whole.
///
/// # Errors
/// When it cannot be XML.
pub fn junit(reports: &[Report], notes: &[String], strict: bool) -> io::Result<String> {
    let mut suites: Vec<Suite> = reports
        .iter()
        .map(|report| Suite {
            name: report.log.display().to_string(),
            cases: cases(report, strict),
            notes: report.notes.clone(),
        })
        .collect();
    if suites.is_empty() {
        let outcome = Outcome::Error("nothing to judge", "no log was checked".to_owned());
        suites.push(whole_run("logs", outcome));
    }
    if !notes.is_empty() {
        let mut run = whole_run(
            "golden files without a log",
            Outcome::Skipped(notes.join("\n")),
        );
        run.notes = notes.to_vec();
        suites.push(run);
    }
    render(&suites)
}

/// The report of a run that did not begin.
///
/// # Errors
/// When it cannot be XML.
pub fn refused(why: &str) -> io::Result<String> {
    let outcome = Outcome::Error("unusable", why.to_owned());
    render(&[whole_run("start", outcome)])
}

/// A suite on the run, not on a log.
fn whole_run(name: &'static str, outcome: Outcome) -> Suite {
    Suite {
        name: "tmam check".to_owned(),
        cases: vec![Case { name, outcome }],
        notes: Vec::new(),
    }
}

fn render(suites: &[Suite]) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("testsuites")
        .write_inner_content(|xml| {
            let mut numbered = suites.iter().zip(0_u32..);
            numbered.try_for_each(|(one, id)| suite(xml, one, id))
        })?;
    let mut text = String::from_utf8_lossy(&xml.into_inner()).into_owned();
    text.push('\n');
    Ok(text)
}

fn suite(xml: &mut Writer<Vec<u8>>, suite: &Suite, id: u32) -> io::Result<()> {
    let (name, cases) = (clean(&suite.name), &suite.cases);
    let name = name.as_str();
    let count = |of: fn(&Outcome) -> bool| cases.iter().filter(|case| of(&case.outcome)).count();
    let failures = count(|outcome| matches!(outcome, Outcome::Failed(_)));
    let errors = count(|outcome| matches!(outcome, Outcome::Error(..)));
    let skipped = count(|outcome| matches!(outcome, Outcome::Skipped(_)));
    let element = xml.create_element("testsuite").with_attributes([
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
        ("skipped", skipped.to_string().as_str()),
    ]);
    element.write_inner_content(|xml| {
        xml.create_element("properties").write_empty()?;
        for case in cases {
            write_case(xml, case, name)?;
        }
        let notes: Vec<String> = suite
            .notes
            .iter()
            .map(|note| clean(&format!("note: {note}")))
            .collect();
        let out = xml.create_element("system-out");
        if notes.is_empty() {
            out.write_empty()?;
        } else {
            out.write_text_content(BytesText::new(&notes.join("\n")))?;
        }
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
            let mut text = lines
                .iter()
                .take(LISTED)
                .map(String::as_str)
                .collect::<Vec<_>>()
                .join("\n");
            if lines.len() > LISTED {
                text.push_str(&format!("\n... and {} more", lines.len() - LISTED));
            }
            ("failure", "differs", message, text)
        }
        Outcome::Error(kind, reason) => ("error", *kind, reason.clone(), reason.clone()),
        Outcome::Skipped(why) => {
            let why = clean(why);
            return element
                .write_inner_content(|xml| {
                    let skipped = xml.create_element("skipped");
                    skipped
                        .with_attribute(("message", why.as_str()))
                        .write_empty()?;
                    Ok(())
                })
                .map(|_| ());
        }
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
    let error = report.verdict.reason().map(|reason| {
        let outcome = Outcome::Error(report.verdict.name(), reason.to_owned());
        // Where the comparison is there, what failed came after it.
        let name = report.found.as_ref().map_or("replay", |_| "artefacts");
        case(name, outcome)
    });
    let Some(found) = report
        .found
        .as_ref()
        .filter(|_| report.verdict != Verdict::Blessed)
    else {
        return vec![error.unwrap_or_else(|| case("golden file", Outcome::Passed))];
    };
    let sections = sections(found, report.recording.as_deref(), strict);
    let mut kinds = vec![
        "log",
        "range noise",
        "sonars",
        "map",
        "extracted features",
        "labels",
    ];
    if strict {
        kinds.push("borderline labels");
    }
    let of = |kind: &str| -> Vec<String> {
        let heads = sections.iter().filter(|(head, _)| head.starts_with(kind));
        heads.flat_map(|(_, lines)| lines.clone()).collect()
    };
    let of_kinds = kinds.into_iter().map(|kind| match of(kind) {
        lines if lines.is_empty() => case(kind, Outcome::Passed),
        lines => case(kind, Outcome::Failed(lines)),
    });
    of_kinds.chain(error).collect()
}
