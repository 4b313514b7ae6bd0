//! JUnit XML: a suite per log, a test case per section of the report.
//!
//! Written so that it is valid both by the schema of Ant's reports, which wants every attribute and
//! element there is, and by the one of Jenkins, which allows few more.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::report::{CheckResult, Report};
use crate::tools::golden::{SECTIONS, headlines, sections};

/// A test suite's name, its cases, and what is to be said beside them.
struct TestSuite {
    name: String,
    /// How long it took, seconds; of that, all is the first case's.
    seconds: f64,
    cases: Vec<TestCase>,
    notes: Vec<String>,
}

struct TestCase {
    name: &'static str,
    result: TestResult,
}

enum TestResult {
    Passed,
    /// What differs, a line each.
    Failed(Vec<String>),
    /// What kept it from being tested, in a word and in full.
    Error(&'static str, String),
    /// What was not looked at.
    Skipped(String),
}

/// The report as JUnit XML; `notes` are on the run as a whole.
///
/// # Errors
/// When it cannot be XML.
pub fn junit(reports: &[Report], notes: &[String], strict: bool) -> io::Result<String> {
    let suite = |report: &Report| TestSuite {
        name: report.log.display().to_string(),
        seconds: report.seconds,
        cases: cases(report, strict),
        notes: said(report),
    };
    let mut suites: Vec<TestSuite> = reports.iter().map(suite).collect();
    if suites.is_empty() {
        let result = TestResult::Error("nothing to judge", "no log was checked".to_owned());
        suites.push(whole_run("logs", result, &[]));
    }
    if !notes.is_empty() {
        let result = TestResult::Skipped(notes.join("\n"));
        let notes = notes.iter().map(|note| format!("note: {note}"));
        let notes: Vec<String> = notes.collect();
        suites.push(whole_run("golden files without a log", result, &notes));
    }
    render(&suites)
}

/// The report of a run that did not begin.
///
/// # Errors
/// When it cannot be XML.
pub fn refused(why: &str) -> io::Result<String> {
    let result = TestResult::Error("unusable", why.to_owned());
    render(&[whole_run("start", result, &[])])
}

/// A test suite on the run, not on a log.
fn whole_run(name: &'static str, result: TestResult, notes: &[String]) -> TestSuite {
    TestSuite {
        name: "tmam check".to_owned(),
        seconds: 0.0,
        cases: vec![TestCase { name, result }],
        notes: notes.to_vec(),
    }
}

/// The headlines, the notes, and where to look, as Jenkins and GitLab find attachments.
fn said(report: &Report) -> Vec<String> {
    let found = report.compared.as_ref().map(|compared| &compared.found);
    let head = found.filter(|found| !found.matches(true));
    let head = head.map_or_else(Vec::new, |found| {
        headlines(found, report.recording.as_deref())
    });
    let notes = report.notes.iter().map(|note| format!("note: {note}"));
    let files = report.artifacts.iter();
    let files = files.map(|path| format!("[[ATTACHMENT|{}]]", path.display()));
    head.into_iter().chain(notes).chain(files).collect()
}

fn cases(report: &Report, strict: bool) -> Vec<TestCase> {
    let case = |name, result| TestCase { name, result };
    let compared = report.compared.as_ref();
    let error = report.result.reason().map(|reason| {
        // Where the comparison is there, what failed came after it.
        let name = compared.map_or("replay", |_| "artefacts");
        let error = TestResult::Error(report.result.name(), reason.to_owned());
        case(name, error)
    });
    let Some(compared) = compared.filter(|_| report.result != CheckResult::Blessed) else {
        return vec![error.unwrap_or_else(|| case("golden file", TestResult::Passed))];
    };
    let differing = sections(&compared.found, strict);
    let names = SECTIONS
        .into_iter()
        .filter(|name| strict || *name != "borderline labels");
    let tested = names.map(|name| {
        let section = differing.iter().find(|section| section.name == name);
        let failed = section.map(|section| TestResult::Failed(section.lines.clone()));
        case(name, failed.unwrap_or(TestResult::Passed))
    });
    tested.chain(error).collect()
}

type Xml = Writer<Vec<u8>>;

fn render(suites: &[TestSuite]) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    xml.create_element("testsuites")
        .write_inner_content(|xml| {
            let mut numbered = suites.iter().zip(0_u32..);
            numbered.try_for_each(|(suite, id)| write_suite(xml, suite, id))
        })?;
    let mut text = String::from_utf8_lossy(&xml.into_inner()).into_owned();
    text.push('\n');
    Ok(text)
}

fn write_suite(xml: &mut Xml, suite: &TestSuite, id: u32) -> io::Result<()> {
    let name = clean(&suite.name);
    let count = |of: fn(&TestResult) -> bool| {
        let counted = suite.cases.iter().filter(|case| of(&case.result));
        counted.count().to_string()
    };
    let failures = count(|result| matches!(result, TestResult::Failed(_)));
    let errors = count(|result| matches!(result, TestResult::Error(..)));
    let skipped = count(|result| matches!(result, TestResult::Skipped(_)));
    let time = format!("{:.3}", suite.seconds);
    let element = xml.create_element("testsuite").with_attributes([
        ("name", name.as_str()),
        ("package", "tmam"),
        ("id", id.to_string().as_str()),
        // It names neither day nor machine.
        ("timestamp", "1970-01-01T00:00:00"),
        ("hostname", "localhost"),
        ("time", time.as_str()),
        ("tests", count(|_| true).as_str()),
        ("failures", failures.as_str()),
        ("errors", errors.as_str()),
        ("skipped", skipped.as_str()),
    ]);
    element.write_inner_content(|xml| {
        xml.create_element("properties").write_empty()?;
        for (place, case) in suite.cases.iter().enumerate() {
            let time = if place == 0 { time.as_str() } else { "0" };
            write_case(xml, case, &name, time)?;
        }
        let notes = suite.notes.iter().map(|note| clean(note));
        let notes = notes.collect::<Vec<_>>().join("\n");
        let out = xml.create_element("system-out");
        match notes.is_empty() {
            true => out.write_empty()?,
            false => out.write_text_content(BytesText::new(&notes))?,
        };
        xml.create_element("system-err").write_empty()?;
        Ok(())
    })?;
    Ok(())
}

fn write_case(xml: &mut Xml, case: &TestCase, log: &str, time: &str) -> io::Result<()> {
    /// More differences of a section than this are counted, not listed.
    const LISTED: usize = 200;
    let attributes = [("name", case.name), ("classname", log), ("time", time)];
    let element = xml.create_element("testcase").with_attributes(attributes);
    let (tag, kind, message, text) = match &case.result {
        TestResult::Passed => {
            element.write_empty()?;
            return Ok(());
        }
        TestResult::Failed(lines) => {
            let mut message = lines.first().cloned().unwrap_or_default();
            if lines.len() > 1 {
                message += &format!("; and {} more", lines.len() - 1);
            }
            let mut listed: Vec<String> = lines.iter().take(LISTED).cloned().collect();
            if lines.len() > LISTED {
                listed.push(format!("... and {} more", lines.len() - LISTED));
            }
            ("failure", Some("differs"), message, Some(listed.join("\n")))
        }
        TestResult::Error(kind, why) => ("error", Some(*kind), why.clone(), Some(why.clone())),
        TestResult::Skipped(why) => ("skipped", None, why.clone(), None),
    };
    element.write_inner_content(|xml| {
        let message = clean(&message);
        let kind = kind.map(|kind| ("type", kind));
        let attributes = kind.into_iter().chain([("message", message.as_str())]);
        let inner = xml.create_element(tag).with_attributes(attributes);
        match text {
            Some(text) => inner.write_text_content(BytesText::new(&clean(&text)))?,
            None => inner.write_empty()?,
        };
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
