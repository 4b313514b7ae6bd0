//! What a person is told of a log's channels and of what was lost.

use super::channels::ChannelReport;
use super::container::Loss;
use crate::legible::one_line;

/// Why a channel of odometry is of no use although its messages are read.
pub const NO_POSE: &str =
    "its messages hold no pose (NaN, farther off than 100,000 km, or a quaternion of zero)";
/// Why a channel of ranges is of no use although its messages are read.
pub const NO_RANGE: &str = "its messages hold no range";

/// A channel in a list of what the log holds.
fn describe(channel: &ChannelReport) -> String {
    let problem = match &channel.problem {
        Some(problem) => format!(": {problem}"),
        None => String::new(),
    };
    let type_name = if channel.type_name.is_empty() {
        "no type"
    } else {
        &channel.type_name
    };
    let text = format!(
        "{} ({type_name}, {}, {} messages{problem})",
        channel.topic, channel.encoding, channel.messages
    );
    one_line(&text).into_owned()
}

/// Channels in a list of what the log holds: first those that may be meant.
pub fn candidates(channels: &[ChannelReport]) -> Vec<String> {
    let mut channels: Vec<&ChannelReport> = channels.iter().collect();
    channels.sort_by_key(|channel| (channel.role.is_none(), channel.problem.is_none()));
    channels.into_iter().map(describe).collect()
}

/// Marks a topic as one that cannot be used after all.
pub fn refuse(channels: &mut [ChannelReport], topic: &str, problem: String) {
    for channel in channels.iter_mut().filter(|c| c.topic == topic) {
        channel.used = false;
        channel.problem.get_or_insert_with(|| problem.clone());
    }
}

/// Channels that would have been used and cannot be.
pub fn on_channels(channels: &[ChannelReport]) -> Vec<String> {
    channels
        .iter()
        .filter(|channel| !channel.used && channel.undecoded == 0)
        .filter_map(|channel| {
            let problem = channel.problem.as_ref()?;
            Some(format!("{} is left out: {problem}", channel.topic))
        })
        .collect()
}

/// What could not be read of the file and of each channel.
pub fn on_losses(losses: &[Loss], channels: &[ChannelReport]) -> Vec<String> {
    let of_file = losses.iter().map(ToString::to_string);
    let of_channels = channels.iter().filter(|c| c.undecoded > 0).map(|channel| {
        format!(
            "{} of {} messages on {}: {}",
            channel.undecoded,
            channel.messages,
            channel.topic,
            channel.problem.as_deref().unwrap_or_default()
        )
    });
    of_file.chain(of_channels).collect()
}
