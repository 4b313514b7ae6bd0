//! Which channels are used, for what, and how each is decoded.

use std::collections::{BTreeMap, BTreeSet};

use super::budget::Budget;
use super::container::{Channel, RawMessage};
use super::custom;
use super::decoder::{self, DecodeError, Decoder};
use super::decoders::Decoders;
use super::messages::{self, Content, MOST_SONARS, Read, Role};
use crate::core::config::Config;
use crate::core::config::channel::ChannelFields;
use crate::core::pattern::{PatternError, glob_set};

/// A scan with more beams than this is a lidar's, unless its topic is asked for.
const LARGEST_RING: usize = 64;

/// Decoded, a message can take fifty times its bytes; no reading or pose is as long as this.
const LONGEST_MESSAGE: usize = 4 << 20;

/// For more channels than this no decoder is made.
const MOST_READERS: usize = 2 * MOST_SONARS;

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
    /// Whether it is a sonar's by its type, or asked for: what it says is missing where it is not used.
    pub wanted: bool,
}

/// The channels of a log, with a reader for each that is used.
#[derive(Debug)]
pub struct Channels {
    range_topics: globset::GlobSet,
    odometry_topics: globset::GlobSet,
    described: BTreeMap<String, ChannelFields>,
    known: BTreeMap<u16, (ChannelReport, Option<Reader>)>,
    readers: usize,
    decoders: Decoders,
    /// Channels whose first message is of no form that is read.
    foreign: BTreeSet<u16>,
}

/// From the bytes of a channel's messages to what they say.
#[derive(Debug)]
struct Reader {
    role: Role,
    decoder: Decoder,
    way: Way,
    /// The configuration names its topic.
    asked_for: bool,
}

/// How a decoded message is read.
#[derive(Debug, Clone)]
enum Way {
    /// By its type.
    Type(Read),
    /// By the field paths in the configuration.
    Paths(Box<ChannelFields>),
}

impl Channels {
    /// Channels chosen by the topics that the configuration names, or else by what it describes
    /// and by schema.
    ///
    /// # Errors
    /// A pattern that is not a glob.
    pub fn new(config: &Config) -> Result<Self, PatternError> {
        let input = &config.input;
        Ok(Self {
            range_topics: glob_set(&input.range_topics)?,
            odometry_topics: glob_set(&input.odometry_topics)?,
            described: config.channel.clone(),
            known: BTreeMap::new(),
            readers: 0,
            decoders: Decoders::default(),
            foreign: BTreeSet::new(),
        })
    }

    /// What a message says and is good for; `None` for one that is not used, or for which there is
    /// no room.
    pub fn read(
        &mut self,
        channel: &Channel,
        message: RawMessage<'_>,
        budget: &mut Budget,
    ) -> Option<(Role, Content)> {
        if !self.known.contains_key(&channel.id) {
            let found = self.find(channel);
            self.known.insert(channel.id, found);
        }
        let (report, reader) = self.known.get_mut(&channel.id)?;
        report.messages += 1;
        let reader = reader.as_ref().filter(|_| report.used)?;
        if !budget.admits_message() {
            return None;
        }
        match reader.read(message.data) {
            Ok(content) if content.sonars() > LARGEST_RING && !reader.asked_for => {
                report.used = false;
                report.problem = Some(format!(
                    "its messages hold {} ranges, a lidar's or a camera's rather than a sonar ring's; if \
                     they are sonars, choose it with --range-topic",
                    content.sonars()
                ));
                None
            }
            Ok(Content::Crowd(count)) => {
                report.used = false;
                report.problem = Some(format!(
                    "its messages hold {count} ranges; no more than {MOST_SONARS} sonars are told apart"
                ));
                None
            }
            Ok(content) => budget.admits(&content).then_some((reader.role, content)),
            Err(error) => {
                // One such message may be damaged; when all are so, it is the channel.
                if let (DecodeError::Channel(_), 1) = (&error, report.messages) {
                    self.foreign.insert(channel.id);
                }
                let (DecodeError::Channel(problem) | DecodeError::Message(problem)) = error;
                report.undecoded += 1;
                report.problem.get_or_insert(problem);
                None
            }
        }
    }

    /// What each channel with messages turned out to be, by topic.
    pub fn into_reports(self) -> Vec<ChannelReport> {
        let foreign = self.foreign;
        let settle = |(id, (mut report, _)): (u16, (ChannelReport, Option<Reader>))| {
            if foreign.contains(&id) && report.undecoded == report.messages {
                report.used = false;
                report.undecoded = 0;
            }
            report
        };
        let mut reports: Vec<ChannelReport> = self.known.into_iter().map(settle).collect();
        reports.sort_by(|a, b| a.topic.cmp(&b.topic));
        reports
    }

    fn find(&mut self, channel: &Channel) -> (ChannelReport, Option<Reader>) {
        let described = self.described.get(&channel.topic);
        let type_name = described.and_then(|fields| fields.type_name.as_deref());
        let type_name = type_name.unwrap_or(&channel.schema.name);
        let known = match described.filter(|fields| !fields.is_type_alone()) {
            Some(fields) => Some((custom::role(fields), Way::Paths(Box::new(fields.clone())))),
            None => messages::known(type_name, &channel.topic)
                .map(|(role, read)| (role, Way::Type(read))),
        };
        let role = known.as_ref().map(|(role, _)| *role);
        let topics = match role {
            Some(Role::Range) => Some(&self.range_topics),
            Some(Role::Odometry | Role::Pose) => Some(&self.odometry_topics),
            Some(Role::Transform | Role::Description) | None => None,
        };
        let asked_for = topics.is_some_and(|topics| topics.is_match(&channel.topic));
        let passed_over = topics.is_some_and(|topics| !topics.is_empty()) && !asked_for;
        let mut report = ChannelReport {
            topic: channel.topic.clone(),
            type_name: type_name.to_owned(),
            encoding: channel.encoding.clone(),
            role,
            used: role.is_some() && !passed_over,
            messages: 0,
            undecoded: 0,
            problem: None,
            wanted: !passed_over
                && (asked_for || described.is_some() || messages::is_one_sonar(type_name)),
        };
        let Some((role, way)) = known.filter(|_| report.used) else {
            if role.is_none() && type_name.is_empty() && channel.encoding == "cdr" {
                report.problem = Some(decoder::undefined(type_name));
            } else if role.is_none() && described.is_some() {
                report.problem = Some(format!(
                    "`{type_name}`, which the configuration says it is, is no type that is read: give the \
                     fields of its messages instead"
                ));
            }
            return (report, None);
        };
        if self.readers == MOST_READERS {
            report.used = false;
            report.problem = Some(format!(
                "the log has more than {MOST_READERS} channels of types that are read"
            ));
            return (report, None);
        }
        self.readers += 1;
        match self.decoders.of(channel, type_name) {
            Ok(decoder) => {
                let reader = Reader {
                    role,
                    decoder,
                    asked_for: asked_for || described.is_some(),
                    way,
                };
                (report, Some(reader))
            }
            Err(problem) => {
                report.used = false;
                report.problem = Some(problem);
                (report, None)
            }
        }
    }
}

impl Reader {
    fn read(&self, message: &[u8]) -> Result<Content, DecodeError> {
        if message.len() > LONGEST_MESSAGE {
            return Err(DecodeError::Channel(format!(
                "a message of {} bytes is too long to be a reading or a pose",
                message.len()
            )));
        }
        let value = self.decoder.decode(message)?;
        let content = match &self.way {
            Way::Type(read) => read(&value),
            Way::Paths(fields) => custom::read(fields, &value),
        };
        content.map_err(|error| DecodeError::Message(error.to_string()))
    }
}
