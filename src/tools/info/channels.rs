//! What each channel of a log is.

use serde::Serialize;

use crate::core::rounding::optional;
use crate::io::log::Role;
use crate::io::log::channels::ChannelReport;
use crate::io::log::survey::ChannelClock;

/// One channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelFacts {
    /// Its topic.
    pub topic: String,
    /// Its message type; empty for a channel without one.
    #[serde(rename = "type")]
    pub type_name: String,
    /// `cdr`, `json`, ...
    pub encoding: String,
    /// What its type is good for: `range`, `odometry`, `transform`; `None` for other types.
    pub role: Option<&'static str>,
    /// Whether its messages are used.
    pub used: bool,
    /// Its messages.
    pub messages: u64,
    /// Messages that could not be decoded.
    pub undecoded: u64,
    /// Why it, or the first message that could not be decoded, is not used.
    pub problem: Option<String>,
    /// Whether what it says is missing where it is not used.
    #[serde(skip)]
    pub wanted: bool,
    /// When its first message was recorded, nanoseconds.
    pub first_ns: i64,
    /// When its last message was recorded, nanoseconds.
    pub last_ns: i64,
    /// Messages per second of recording.
    #[serde(serialize_with = "optional")]
    pub rate: Option<f64>,
    /// Messages with a stamp other than 0.
    pub stamped: u64,
    /// Messages with the stamp 0.
    pub unstamped: u64,
    /// Messages stamped earlier than the one before them.
    pub backward_stamps: u64,
    /// Messages with the stamp of the one before them.
    pub repeated_stamps: u64,
    /// Messages that lie in the file behind a later one of their channel.
    pub out_of_order: u64,
    /// Time from stamp to recording in the middle of all, seconds.
    #[serde(serialize_with = "optional")]
    pub median_delay: Option<f64>,
    /// The time from stamp to recording that is farthest from 0, seconds.
    #[serde(serialize_with = "optional")]
    pub extreme_delay: Option<f64>,
}

/// The facts of every channel and its clock.
pub fn channels(reports: &[ChannelReport], clocks: &[ChannelClock]) -> Vec<ChannelFacts> {
    let seconds = |ns: i64| ns as f64 * 1e-9;
    reports
        .iter()
        .zip(clocks)
        .map(|(report, clock)| ChannelFacts {
            topic: report.topic.clone(),
            type_name: report.type_name.clone(),
            encoding: report.encoding.clone(),
            role: report.role.map(role_name),
            used: report.used,
            messages: report.messages,
            undecoded: report.undecoded,
            problem: report.problem.clone(),
            wanted: report.wanted,
            first_ns: clock.first_logged_ns,
            last_ns: clock.last_logged_ns,
            rate: clock.rate(),
            stamped: clock.stamped,
            unstamped: clock.unstamped,
            backward_stamps: clock.backward,
            repeated_stamps: clock.repeated,
            out_of_order: clock.out_of_order,
            median_delay: clock.median_delay_ns.map(seconds),
            extreme_delay: clock.extreme_delay_ns.map(seconds),
        })
        .collect()
}

fn role_name(role: Role) -> &'static str {
    match role {
        Role::Range => "range",
        Role::Odometry => "odometry",
        Role::Pose => "pose",
        Role::Description => "description",
        Role::Transform => "transform",
    }
}

impl ChannelFacts {
    /// Whether the file does not say of what type its messages are, and has to.
    pub fn is_untyped(&self) -> bool {
        self.type_name.is_empty() && self.problem.is_some()
    }

    /// A channel of a type that is read, but not in this form.
    pub fn is_unreadable(&self) -> bool {
        self.role.is_some() && !self.used && self.problem.is_some()
    }
}
