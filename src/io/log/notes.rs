//! What a person is told of a log's channels and of what was lost.

use std::collections::{BTreeMap, BTreeSet};

use super::channels::ChannelReport;
use super::container::Loss;
use super::message::Role;
use crate::core::legible::one_line;
use crate::core::wording::{counted, few};

/// Why a channel of odometry is of no use although its messages are read.
pub const NO_POSE: &str =
    "its messages hold no pose (NaN, farther off than 100,000 km, or a quaternion of zero)";
/// Why a channel of ranges is of no use although its messages are read.
pub const NO_RANGE: &str = "its messages hold no range";

/// A channel in a list of what the log holds.
fn describe(channel: &ChannelReport, problem: Option<&str>) -> String {
    let problem = problem.map_or_else(String::new, |problem| format!(": {problem}"));
    let type_name = if channel.type_name.is_empty() {
        "no type"
    } else {
        &channel.type_name
    };
    let text = format!(
        "{} ({type_name}, {}, {}{problem})",
        channel.topic,
        channel.encoding,
        counted(channel.messages, "message")
    );
    one_line(&text).into_owned()
}

/// Channels in a list of what the log holds: first those that may be meant where some in these roles are
/// missing. What is wrong with several of them is said once.
pub fn candidates(channels: &[ChannelReport], missing: &[Role]) -> Vec<String> {
    let mut channels: Vec<&ChannelReport> = channels.iter().collect();
    let is_missing = |channel: &ChannelReport| channel.role.is_some_and(|r| missing.contains(&r));
    channels.sort_by_key(|channel| {
        let is_refused = channel.wanted && channel.role.is_none();
        (
            !is_refused,
            !is_missing(channel),
            channel.role.is_none(),
            channel.problem.is_none(),
        )
    });
    let mut said = BTreeSet::new();
    let lines = channels.into_iter().map(|channel| {
        let problem = channel.problem.as_deref();
        let is_new = problem.is_none_or(|problem| said.insert(problem));
        describe(channel, if is_new { problem } else { Some("likewise") })
    });
    lines.collect()
}

/// Marks a topic as one that cannot be used after all.
pub fn refuse(channels: &mut [ChannelReport], topic: &str, problem: String) {
    for channel in channels.iter_mut().filter(|c| c.topic == topic) {
        channel.used = false;
        channel.problem.get_or_insert_with(|| problem.clone());
    }
}

/// Channels that would have been used and cannot be, as far as nothing is missing without them.
pub fn on_channels(channels: &[ChannelReport]) -> Vec<String> {
    let mut topics = BTreeMap::<&str, Vec<String>>::new();
    for channel in channels.iter().filter(|channel| !channel.wanted) {
        if let Some(problem) = unread(channel) {
            topics
                .entry(problem)
                .or_default()
                .push(channel.topic.clone());
        }
    }
    let note = |(problem, topics): (&str, Vec<String>)| {
        let verb = if topics.len() == 1 { "is" } else { "are" };
        format!("{} {verb} left out: {problem}", few(&topics))
    };
    topics.into_iter().map(note).collect()
}

/// Why not a message of a channel is read, where none is.
fn unread(channel: &ChannelReport) -> Option<&str> {
    let problem = channel.problem.as_deref()?;
    (!channel.used && channel.undecoded == 0).then_some(problem)
}

/// What could not be read of the file and of each channel.
pub fn on_losses(losses: &[Loss], channels: &[ChannelReport]) -> Vec<String> {
    let of_file = losses.iter().map(ToString::to_string);
    let of_channels = channels.iter().filter_map(|channel| {
        if channel.undecoded > 0 {
            return Some(format!(
                "{} of {} on {}: {}",
                channel.undecoded,
                counted(channel.messages, "message"),
                channel.topic,
                channel.problem.as_deref().unwrap_or_default()
            ));
        }
        let problem = unread(channel).filter(|_| channel.wanted)?;
        Some(format!(
            "{}, {}: left out, since {problem}",
            channel.topic,
            counted(channel.messages, "message")
        ))
    });
    of_file.chain(of_channels).collect()
}
