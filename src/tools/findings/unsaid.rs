//! What the reader noted and no other finding says.

use std::collections::BTreeSet;

use super::facts::Facts;
use super::finding::{Finding, Weight};
use super::unread::unread;
use crate::io::log::TOO_WIDE;

/// What the reader noted and no other finding says.
pub fn check(facts: &Facts, notes: &[String], found: &[Finding]) -> Vec<Finding> {
    const LEFT_OUT: &str = " left out: ";
    let problems: BTreeSet<&str> = unread(facts).filter_map(|c| c.problem.as_deref()).collect();
    let is_found = |code| found.iter().any(|finding| finding.code == code);
    let said = |note: &str| {
        let mut reasons = note
            .match_indices(LEFT_OUT)
            .filter_map(|(at, _)| note.get(at + LEFT_OUT.len()..));
        let repeats = note.contains("sonar's last value although the robot moved");
        note.contains("no stamp in the header")
            || (repeats && is_found("repeats"))
            || reasons.any(|reason| problems.contains(reason))
            || (note.contains(TOO_WIDE) && is_found("beam-width"))
    };
    let unsaid = notes.iter().filter(|note| !said(note));
    unsaid
        .map(|note| Finding::new(Weight::Notable, "note", note.as_str(), "", ""))
        .collect()
}
