//! JUnit XML: a suite per log, a case per kind of check.

use quick_junit::{NonSuccessKind, Report as XmlReport, TestCase, TestCaseStatus, TestSuite};

use super::text::sections;
use super::{Report, Verdict};

/// The kinds of check, and how the differences of each begin.
const CASES: [(&str, &str); 4] = [
    ("log", "log"),
    ("map", "map"),
    ("extracted features", "extracted features"),
    ("labels", "labels"),
];

/// The report as JUnit XML.
///
/// # Errors
/// When it cannot be XML.
pub fn junit(reports: &[Report], strict: bool) -> Result<String, quick_junit::SerializeError> {
    let mut xml = XmlReport::new("tmam check");
    for report in reports {
        let mut suite = TestSuite::new(report.log.display().to_string());
        for case in cases(report, strict) {
            suite.add_test_case(case);
        }
        xml.add_test_suite(suite);
    }
    if reports.is_empty() {
        let mut suite = TestSuite::new("tmam check");
        suite.add_test_case(failed(
            "suite",
            NonSuccessKind::Error,
            "nothing to judge",
            "no log was checked",
            "",
        ));
        xml.add_test_suite(suite);
    }
    xml.to_string()
}

fn cases(report: &Report, strict: bool) -> Vec<TestCase> {
    let class = report.log.display().to_string();
    if let Some(reason) = report.verdict.reason() {
        let name = report.verdict.name();
        return vec![failed(
            "replay",
            NonSuccessKind::Error,
            name,
            reason,
            &class,
        )];
    }
    let Some(found) = &report.found else {
        return vec![passed("golden file", &class)];
    };
    if report.verdict == Verdict::Blessed {
        return vec![passed("golden file", &class)];
    }
    let sections = sections(found, report.recording.as_deref(), strict);
    let lines = |head: &str| -> Vec<String> {
        let of = sections.iter().filter(|(name, _)| name.starts_with(head));
        of.flat_map(|(_, lines)| lines.clone()).collect()
    };
    let mut cases: Vec<TestCase> = CASES
        .iter()
        .map(|(name, head)| case(name, &lines(head), &class))
        .collect();
    if strict {
        cases.push(case("borderline labels", &lines("borderline"), &class));
    }
    cases
}

fn case(name: &str, differences: &[String], class: &str) -> TestCase {
    match differences {
        [] => passed(name, class),
        [first, rest @ ..] => {
            let message = match rest.len() {
                0 => first.clone(),
                n => format!("{first}; and {n} more"),
            };
            let mut case = failed(name, NonSuccessKind::Failure, "differs", &message, class);
            if let TestCaseStatus::NonSuccess { description, .. } = &mut case.status {
                *description = Some(differences.join("\n").as_str().into());
            }
            case
        }
    }
}

fn passed(name: &str, class: &str) -> TestCase {
    let mut case = TestCase::new(name, TestCaseStatus::success());
    case.set_classname(class);
    case
}

fn failed(name: &str, kind: NonSuccessKind, what: &str, message: &str, class: &str) -> TestCase {
    let mut status = TestCaseStatus::non_success(kind);
    status
        .set_type(what)
        .set_message(message)
        .set_description(message);
    let mut case = TestCase::new(name, status);
    if !class.is_empty() {
        case.set_classname(class);
    }
    case
}
