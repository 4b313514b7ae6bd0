//! Channels of a known type in a form that is not read.

use std::collections::BTreeMap;

use super::facts::{ChannelFacts, Facts};
use super::finding::{Finding, Weight, names};
use Weight::{Blocking, Serious};

/// Channels of a known type in a form that is not read.
pub fn unread(facts: &Facts) -> impl Iterator<Item = &ChannelFacts> {
    facts
        .channels
        .iter()
        .filter(|channel| channel.is_unreadable())
}

pub fn check(facts: &Facts) -> Vec<Finding> {
    let mut by_problem: BTreeMap<&str, Vec<&ChannelFacts>> = BTreeMap::new();
    for channel in unread(facts) {
        let problem = channel.problem.as_deref().unwrap_or_default();
        by_problem.entry(problem).or_default().push(channel);
    }
    let role_is_met = |channel: &&ChannelFacts| match channel.role {
        Some("range") => !facts.sonars.is_empty(),
        Some("odometry") => facts.odometry.is_some(),
        _ => true,
    };
    let finding = |(problem, channels): (&str, Vec<&ChannelFacts>)| {
        let topics = names(channels.iter().map(|c| c.topic.as_str()));
        let verb = if channels.len() == 1 { "is" } else { "are" };
        let is_met = channels.iter().all(role_is_met);
        Finding::new(
            if is_met { Serious } else { Blocking },
            "unread-channel",
            format!("{topics} {verb} not read: {problem}"),
            "what they say is missing from the replay",
            if channels.iter().any(|channel| channel.wanted) {
                "a replay ends with exit code 3; record them as is said, or leave them out: --range-topic"
            } else {
                ""
            },
        )
    };
    by_problem.into_iter().map(finding).collect()
}
