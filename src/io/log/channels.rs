//! Which channels are used, for what, and how each is decoded; and what a person is told of them.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::axes::Axes;
use super::cone::Cone;
use super::container::{Channel, Loss, RawMessage};
use super::custom;
use super::decoder::{self, DecodeError, Decoder, Decoders};
use super::error::LogError;
use super::message::{Content, MOST_SONARS, Role};
use super::types::{self, Read};
use super::unzipper::Unzipper;
use crate::core::config::Config;
use crate::core::config::channel::{self, ChannelFields};
use crate::core::legible::{name, one_line};
use crate::core::pattern::{PatternError, glob_set};
use crate::core::wording::{counted, few};

/// A scan with more beams than this is a lidar's, unless its topic is asked for.
const LARGEST_RING: usize = 64;

/// Decoded, a message can take fifty times its bytes; no reading or pose is as long as this.
const LONGEST_MESSAGE: usize = 4 << 20;

/// For more channels than this no decoder is made.
const MOST_READERS: usize = 2 * MOST_SONARS;

/// What one channel turned out to be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelReport {
    /// Its number in the file.
    pub id: u16,
    pub topic: String,
    /// As its schema names it.
    pub type_name: String,
    /// `cdr`, `json`, ...
    pub encoding: String,
    /// What it is good for, if anything.
    pub role: Option<Role>,
    /// Whether its messages are used.
    pub used: bool,
    pub messages: u64,
    /// Messages that were left out, as they cannot be decoded or hold too many ranges.
    pub undecoded: u64,
    /// Why it, or the first message that was left out, is not used.
    pub problem: Option<String>,
    /// Whether it is a sonar's by its type, or asked for: what it says is missing where it is not used.
    pub wanted: bool,
}

/// The channels of a log, with a reader for each that is used.
#[derive(Debug)]
pub struct Channels {
    range_topics: globset::GlobSet,
    odometry_topics: globset::GlobSet,
    transform_topics: globset::GlobSet,
    described: BTreeMap<String, ChannelFields>,
    known: BTreeMap<u16, Known>,
    readers: usize,
    decoders: Decoders,
    unzipper: Unzipper,
    /// Readings and odometry samples so far, and the most that are held.
    held: u64,
    most: u64,
}

#[derive(Debug)]
struct Known {
    report: ChannelReport,
    reader: Option<Reader>,
    /// Messages that are of no form that is read, and those that hold a lidar's number of ranges: one of them
    /// may be damaged; when all are so, it is the channel.
    foreign: u64,
    /// The beam of a single sonar that its scans spread.
    cone: Cone,
}

/// From the bytes of a channel's messages to what they say.
#[derive(Debug)]
struct Reader {
    role: Role,
    decoder: Rc<Decoder>,
    way: Way,
    /// The configuration names its topic.
    asked_for: bool,
    /// Of all lengths in its messages.
    metres_per_unit: f64,
    axes: Axes,
    is_cdr: bool,
}

/// What makes a message of the wanted fields.
#[derive(Debug, Clone)]
enum Way {
    Type(Read),
    Described(Box<ChannelFields>),
}

/// A message that was read.
#[derive(Debug)]
pub struct Message<'c> {
    pub role: Role,
    pub topic: &'c str,
    pub content: Content<'c>,
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
            transform_topics: glob_set(&input.transform_topics)?,
            described: config.channel.clone(),
            known: BTreeMap::new(),
            readers: 0,
            decoders: Decoders::default(),
            unzipper: Unzipper::default(),
            held: 0,
            most: input.max_readings,
        })
    }

    /// What a message says and is good for; `None` for one that is not used, or for which there is
    /// no room.
    pub fn read<'m>(
        &'m mut self,
        channel: &Channel,
        message: RawMessage<'m>,
    ) -> Option<Message<'m>> {
        if !self.known.contains_key(&channel.id) {
            let found = self.find(channel);
            self.known.insert(channel.id, found);
        }
        let known = self.known.get_mut(&channel.id)?;
        let report = &mut known.report;
        report.messages += 1;
        let reader = known.reader.as_ref()?;
        if self.held > self.most {
            return None;
        }
        let data = match reader.is_cdr {
            true => self.unzipper.unzipped(message.data),
            false => message.data,
        };
        match reader
            .read(data)
            .map(|content| known.cone.narrowed(content))
        {
            Ok(content) if content.sonars() > LARGEST_RING && !reader.asked_for => {
                known.foreign += 1;
                report.undecoded += 1;
                report.problem.get_or_insert_with(|| {
                    format!(
                        "a message of it holds {} ranges, a lidar's or a camera's rather than a sonar ring's; if \
                         they are sonars, choose it with --range-topic",
                        content.sonars()
                    )
                });
                None
            }
            Ok(content) => {
                self.held = self.held.saturating_add(content.held());
                (self.held <= self.most).then_some(Message {
                    role: reader.role,
                    topic: &report.topic,
                    content,
                })
            }
            Err(error) => {
                known.foreign += u64::from(matches!(error, DecodeError::Channel(_)));
                let (DecodeError::Channel(problem) | DecodeError::Message(problem)) = error;
                report.undecoded += 1;
                report.problem.get_or_insert(problem);
                None
            }
        }
    }

    /// What each channel with messages turned out to be, by topic.
    ///
    /// # Errors
    /// A log with more than is held.
    pub fn into_reports(self, file: &str) -> Result<Vec<ChannelReport>, LogError> {
        if self.held > self.most {
            return Err(LogError::TooManyReadings {
                file: file.to_owned(),
                most: self.most,
            });
        }
        let settle = |known: Known| {
            let mut report = known.report;
            if known.foreign > 0 && known.foreign == report.messages {
                report.used = false;
                report.undecoded = 0;
            }
            report
        };
        let mut reports: Vec<ChannelReport> = self.known.into_values().map(settle).collect();
        reports.sort_by(|a, b| a.topic.cmp(&b.topic));
        Ok(reports)
    }

    fn find(&mut self, channel: &Channel) -> Known {
        let topic = name(&channel.topic).into_owned();
        let described = channel::of_topic(&self.described, &topic);
        let type_name = described.and_then(|fields| fields.type_name.as_deref());
        let type_name = name(type_name.unwrap_or(&channel.schema.name)).into_owned();
        let known = match described.filter(|fields| !fields.is_of_known_type()) {
            Some(fields) => Some((
                custom::role(fields),
                custom::paths(fields),
                Way::Described(Box::new(fields.clone())),
            )),
            None => types::known(&type_name, &topic)
                .map(|known| (known.role, known.paths(), Way::Type(known.read))),
        };
        let role = known.as_ref().map(|(role, ..)| *role);
        let topics = match role {
            Some(Role::Range) => Some(&self.range_topics),
            Some(Role::Odometry | Role::Pose) => Some(&self.odometry_topics),
            Some(Role::Transform | Role::Description) => Some(&self.transform_topics),
            None => None,
        };
        let asked_for = topics.is_some_and(|topics| topics.is_match(&topic));
        let passed_over = topics.is_some_and(|topics| !topics.is_empty()) && !asked_for;
        let is_described = described.is_some();
        // Of messages that are described field by field, the description is scaled by its own.
        let metres_per_unit = described.filter(|fields| fields.is_of_known_type());
        let metres_per_unit = metres_per_unit.and_then(|fields| fields.metres_per_unit);
        let is_wanted = asked_for || is_described || types::is_one_sonar(&type_name);
        let mut report = ChannelReport {
            id: channel.id,
            topic,
            type_name,
            encoding: name(&channel.encoding).into_owned(),
            role,
            used: role.is_some() && !passed_over,
            messages: 0,
            undecoded: 0,
            problem: None,
            wanted: !passed_over && is_wanted,
        };
        let type_name = &report.type_name;
        let reader = match known.filter(|_| report.used) {
            None if role.is_some() => Ok(None),
            None if type_name.is_empty() && channel.encoding == "cdr" => {
                Err(decoder::undefined(type_name))
            }
            None if described.is_some_and(|fields| fields.type_name.is_some()) => Err(format!(
                "`{type_name}`, which the configuration says it is, is no type that is read: give the \
                 fields of its messages instead"
            )),
            None => Ok(None),
            Some(_) if self.readers == MOST_READERS => Err(format!(
                "the log has more than {MOST_READERS} channels of types that are read"
            )),
            Some((role, paths, way)) => {
                self.readers += 1;
                let by_paths = matches!(way, Way::Described(_));
                let decoder = self.decoders.of(channel, type_name, by_paths, paths);
                decoder.map(|decoder| {
                    Some(Reader {
                        role,
                        decoder,
                        way,
                        asked_for: asked_for || is_described,
                        metres_per_unit: metres_per_unit.unwrap_or(1.0),
                        axes: described.map_or_else(Axes::default, Axes::of),
                        is_cdr: channel.encoding == "cdr",
                    })
                })
            }
        };
        let reader = reader.unwrap_or_else(|problem| {
            report.problem = Some(problem);
            report.used = false;
            None
        });
        Known {
            report,
            reader,
            foreign: 0,
            cone: Cone::default(),
        }
    }
}

impl Reader {
    fn read<'m>(&self, message: &'m [u8]) -> Result<Content<'m>, DecodeError> {
        if message.len() > LONGEST_MESSAGE {
            return Err(DecodeError::Channel(format!(
                "a message of {} bytes is too long to be a reading or a pose",
                message.len()
            )));
        }
        let fields = self.decoder.decode(message)?;
        let content = match &self.way {
            Way::Type(read) => read(&fields),
            Way::Described(described) => custom::read(described, &fields),
        };
        match content.map_err(|error| DecodeError::Message(error.to_string()))? {
            Content::Crowd(count) => Err(DecodeError::Channel(format!(
                "a message of it holds {count} ranges; no more than {MOST_SONARS} sonars are told apart"
            ))),
            content => Ok(self.laid(content.scaled(self.metres_per_unit))),
        }
    }
}

impl Reader {
    fn laid<'m>(&self, mut content: Content<'m>) -> Content<'m> {
        if let Content::Odometry(odometry) = &mut content
            && let Some(pose) = &mut odometry.parent_from_child
        {
            self.axes.lay(pose);
        }
        content
    }
}

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
