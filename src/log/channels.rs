//! Which channels are used, for what, and how each is decoded.

use std::collections::BTreeMap;

use super::container::{Channel, RawMessage};
use super::messages::Role;
use super::ros2;
use super::value::Value;
use crate::config::Input;
use crate::config::file::{ConfigError, glob_set};

/// What one channel turned out to be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelReport {
    /// Its topic.
    pub topic: String,
    /// Its message type, as its schema names it.
    pub type_name: String,
    /// `cdr`, `json`, ...
    pub encoding: String,
    /// What it is good for, if anything.
    pub role: Option<Role>,
    /// Whether its messages are used.
    pub used: bool,
    /// Its messages.
    pub messages: u64,
    /// Messages that could not be decoded.
    pub undecoded: u64,
    /// Why it, or the first message that could not be decoded, is not used.
    pub problem: Option<String>,
}

/// The channels of a log, with a decoder for each that is used.
#[derive(Debug)]
pub struct Channels {
    range_topics: globset::GlobSet,
    odometry_topics: globset::GlobSet,
    known: BTreeMap<u16, (ChannelReport, Option<ros2::Decoder>)>,
}

impl Channels {
    /// Channels chosen by the topics that the configuration names, or else by schema.
    ///
    /// # Errors
    /// A pattern that is not a glob.
    pub fn new(input: &Input) -> Result<Self, ConfigError> {
        Ok(Self {
            range_topics: glob_set(&input.range_topics)?,
            odometry_topics: glob_set(&input.odometry_topics)?,
            known: BTreeMap::new(),
        })
    }

    /// The decoded message and what it is good for; `None` for one that is not used.
    pub fn decode(&mut self, channel: &Channel, message: RawMessage<'_>) -> Option<(Role, Value)> {
        if !self.known.contains_key(&channel.id) {
            let found = self.find(channel);
            self.known.insert(channel.id, found);
        }
        let (report, decoder) = self.known.get_mut(&channel.id)?;
        report.messages += 1;
        let (role, decoder) = (report.role.filter(|_| report.used)?, decoder.as_ref()?);
        match decoder.decode(message.data) {
            Ok(value) => Some((role, value)),
            Err(error) => {
                report.fail(error.to_string());
                None
            }
        }
    }

    /// Counts a decoded message that lacks what its type should have.
    pub fn failed(&mut self, channel: &Channel, problem: String) {
        if let Some((report, _)) = self.known.get_mut(&channel.id) {
            report.fail(problem);
        }
    }

    /// What each channel with messages turned out to be, by topic.
    pub fn into_reports(self) -> Vec<ChannelReport> {
        let mut reports: Vec<ChannelReport> = self.known.into_values().map(|(r, _)| r).collect();
        reports.sort_by(|a, b| a.topic.cmp(&b.topic));
        reports
    }

    fn find(&self, channel: &Channel) -> (ChannelReport, Option<ros2::Decoder>) {
        let role = Role::of(&channel.schema.name);
        let chosen = match role {
            Some(Role::Range) => chosen(&self.range_topics, &channel.topic),
            Some(Role::Odometry) => chosen(&self.odometry_topics, &channel.topic),
            Some(Role::Transform) => true,
            None => false,
        };
        let mut report = ChannelReport {
            topic: channel.topic.clone(),
            type_name: channel.schema.name.clone(),
            encoding: channel.encoding.clone(),
            role,
            used: chosen,
            messages: 0,
            undecoded: 0,
            problem: None,
        };
        let decoder = chosen.then(|| decoder(channel)).and_then(|decoder| {
            decoder
                .map_err(|problem| {
                    report.used = false;
                    report.problem = Some(problem);
                })
                .ok()
        });
        (report, decoder)
    }
}

fn chosen(topics: &globset::GlobSet, topic: &str) -> bool {
    topics.is_empty() || topics.is_match(topic)
}

impl ChannelReport {
    fn fail(&mut self, problem: String) {
        self.undecoded += 1;
        self.problem.get_or_insert(problem);
    }
}

/// The decoder that fits a channel's encoding and schema.
fn decoder(channel: &Channel) -> Result<ros2::Decoder, String> {
    let schema = &channel.schema;
    match (channel.encoding.as_str(), schema.encoding.as_str()) {
        ("cdr", "ros2msg") => {
            ros2::Decoder::new(&schema.name, &schema.data).map_err(|error| error.to_string())
        }
        (encoding, schema) => Err(format!(
            "encoding `{encoding}` with schema `{schema}` is not read; record as `cdr` with `ros2msg`"
        )),
    }
}
