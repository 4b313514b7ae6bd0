//! What of the file could not be read.

use std::collections::BTreeSet;

use super::facts::Facts;
use super::finding::{Finding, Weight};
use super::unread::unread;

/// So many losses are named.
const NAMED_LOSSES: usize = 3;

/// What of the file could not be read; of channels that are not read, there is a finding of their own.
pub fn check(facts: &Facts) -> Option<Finding> {
    let unread: BTreeSet<&str> = unread(facts)
        .map(|channel| channel.topic.as_str())
        .collect();
    let of_channel = |loss: &str| {
        let mut ends = loss.match_indices(", ").map(|(end, _)| end);
        ends.any(|end| loss.get(..end).is_some_and(|topic| unread.contains(topic)))
    };
    let losses = facts.source.lost.iter().map(String::as_str);
    let losses: Vec<&str> = losses.filter(|loss| !of_channel(loss)).collect();
    let named = losses.get(..NAMED_LOSSES).unwrap_or(&losses).join("; ");
    let (parts, more) = match losses.len() {
        0 => return None,
        1 => ("one part".to_owned(), ""),
        n => (
            format!("{n} parts"),
            if n > NAMED_LOSSES { "; ..." } else { "" },
        ),
    };
    Some(Finding::new(
        Weight::Serious,
        "incomplete",
        format!("the log is not whole, {parts} could not be read: {named}{more}"),
        "what it held is missing from the map, and sequences break where it was",
        if facts.channels.is_empty() {
            ""
        } else {
            "everything else is used; a replay ends with exit code 3"
        },
    ))
}
