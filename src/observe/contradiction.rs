//! A label and what contradicts it, in words.

use crate::core::tmam::hypothesis::HypothesisTest;
use crate::core::tmam::label::Kind;
use crate::core::tmam::report::ArcReport;

/// What a label takes an arc for.
pub fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Line => "wall",
        Kind::Point => "corner",
        Kind::Circle => "pillar",
    }
}

/// The label and what contradicts it.
pub fn in_words(report: &ArcReport) -> String {
    let label = report.label.kind().map_or("nothing", word);
    format!("taken for a {label}, but {}", against(report))
}

/// What contradicts the label.
pub fn against(report: &ArcReport) -> String {
    if let Some(kind) = report.map.and_then(|map| map.support.kind()) {
        return format!("the map has a {} there", word(kind));
    }
    let mut tests = report.tests().map(|(_, test)| test);
    let against = tests.find(|test| test.contradicts(report.label));
    against.map_or_else(String::new, says)
}

fn says(test: &HypothesisTest) -> String {
    let says = match test.support.kind() {
        Some(kind) => format!("only a {} explains", word(kind)),
        None => "neither wall nor corner explains".to_owned(),
    };
    format!("{says} {} readings there", test.readings)
}
