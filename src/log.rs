//! From the bytes of an MCAP log to readings and odometry in stamp order.
//!
//! This room knows MCAP and message encodings and nothing of TMAM: everything downstream sees
//! [`Events`]. A new encoding is a decoder in [`decoder`], a new message type a function in
//! [`messages`].

pub mod channels;
pub mod clock;
pub mod container;
mod custom;
mod decoder;
mod description;
pub mod fuzzing;
mod gather;
mod gathered;
mod json;
mod messages;
mod msg_schema;
mod notes;
mod protobuf;
mod repeats;
mod rings;
mod ros1;
mod ros2;
mod sonars;
mod standard;
pub mod survey;
mod transforms;
pub mod truth;
mod value;
pub mod writer;

use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use crate::config::Config;
use crate::config::file::ConfigError;
use crate::event::Events;
use channels::{ChannelReport, Channels};
use container::{Channel, Loss, OpenError, RawMessage};
use gather::Gatherer;
pub use gathered::Gathered;
pub use messages::Role;
use truth::RecordedTruth;

/// A log as far as it could be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Its file name, without directories.
    pub file: String,
    /// What it says.
    pub events: Events,
    /// Messages that were used.
    pub messages: u64,
    /// What its channels are.
    pub channels: Vec<ChannelReport>,
    /// What could not be read of it; empty for a whole log.
    pub losses: Vec<String>,
    /// What a person should know of it.
    pub notes: Vec<String>,
}

/// Why a log cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is something else.
    #[error(
        "{} is not an MCAP file: it does not begin with the MCAP magic bytes. Convert other logs \
         first (`ros2 bag convert` for a rosbag2 folder of .db3 files, `mcap convert` for a ROS 1 bag)",
        path.display()
    )]
    NotMcap {
        /// The file.
        path: PathBuf,
    },
    /// Nothing that measures ranges.
    #[error("{file} has no range readings{}. {} Messages of other types can be described by field paths, under \
         [channel.\"/topic\"] in the configuration", because(.asked), list("The log holds", .found))]
    NoRanges {
        /// The log.
        file: String,
        /// Topic patterns that were asked for.
        asked: Vec<String>,
        /// The log's channels.
        found: Vec<String>,
    },
    /// Nothing that says where the robot was.
    #[error("{file} has no odometry{}. {}", because(.asked), list("The log holds", .found))]
    NoOdometry {
        /// The log.
        file: String,
        /// Topic patterns that were asked for.
        asked: Vec<String>,
        /// The log's channels.
        found: Vec<String>,
    },
    /// Several odometry topics.
    #[error("{file} has more than one odometry topic: {}. Choose one with --odom-topic", topics.join(", "))]
    ManyOdometries {
        /// The log.
        file: String,
        /// The topics.
        topics: Vec<String>,
    },
    /// A sonar whose place on the robot is unknown.
    #[error(transparent)]
    NoMount(Box<MissingMount>),
    /// A sonar whose beam width is unknown.
    #[error(
        "sonar `{sonar}` (topic {topic}) gives no beam width: its field_of_view is 0 or NaN. Set \
         sonars.beam_width, or beam_width under [sonar.\"{sonar}\"], in the configuration (deg, full angle)"
    )]
    NoBeamWidth {
        /// The sonar's name.
        sonar: String,
        /// Its topic.
        topic: String,
    },
    /// Odometry that does not say what it moves.
    #[error(
        "the odometry on {topic} does not name the frame that it moves, and the sonars' transforms lead \
         to {}. Set input.robot_frame in the configuration",
        if carriers.is_empty() { "none".to_owned() } else { carriers.join(", ") }
    )]
    NoRobotFrame {
        /// The topic.
        topic: String,
        /// The frames that carry sonars.
        carriers: Vec<String>,
    },
    /// More sonars than can be told apart.
    #[error(
        "{file} has more than {} sonars; choose topics with --range-topic",
        u16::MAX
    )]
    TooManySonars {
        /// The log.
        file: String,
    },
    /// The configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A damaged log, of which too little is left.
    #[error("{source}\nThe log is damaged. Lost:{}", itemised(.losses))]
    Damaged {
        /// What is missing.
        source: Box<LogError>,
        /// What could not be read.
        losses: Vec<String>,
    },
}

/// A line for every item.
pub fn itemised(items: &[String]) -> String {
    items.iter().map(|item| format!("\n  - {item}")).collect()
}

/// A sonar whose place on the robot is unknown.
#[derive(Debug, thiserror::Error)]
#[error(
    "no mounting pose for sonar frame `{frame}` (topic {topic}): {why}. {} Give the mount in the \
     configuration:\n\n    [sonar.\"{sonar}\"]\n    x = 0.0    # m, in `{robot_frame}`\n    y = 0.0    # m\n    \
     yaw = 0.0  # deg\n\nor leave its topic out with --range-topic",
    list("Frames with a transform:", .frames)
)]
pub struct MissingMount {
    /// The sonar's name.
    pub sonar: String,
    /// Its topic.
    pub topic: String,
    /// Its frame.
    pub frame: String,
    /// The robot's frame.
    pub robot_frame: String,
    /// What stands in the way.
    pub why: String,
    /// Every frame of the transform tree.
    pub frames: Vec<String>,
}

impl LogError {
    /// What is missing may be what was lost.
    fn after(self, losses: &[Loss]) -> Self {
        if losses.is_empty() {
            return self;
        }
        Self::Damaged {
            source: Box::new(self),
            losses: losses.iter().map(ToString::to_string).collect(),
        }
    }

    fn open(path: &Path, error: OpenError) -> Self {
        let path = path.to_owned();
        match error {
            OpenError::Io(source) => Self::Io { path, source },
            OpenError::NotMcap => Self::NotMcap { path },
        }
    }
}

fn because(asked: &[String]) -> String {
    if asked.is_empty() {
        String::new()
    } else {
        format!(" on the topics asked for ({})", asked.join(", "))
    }
}

fn list(head: &str, items: &[String]) -> String {
    const SHOWN: usize = 16;
    let more = items.len().saturating_sub(SHOWN);
    let tail = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    match items {
        [] => format!("{head} nothing."),
        _ => format!(
            "{head} {}{tail}.",
            items
                .iter()
                .take(SHOWN)
                .cloned()
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}

/// Reads a log.
///
/// # Errors
/// When nothing of it could be replayed; see [`LogError`]. Damage is no error: what could not be
/// read is in [`Log::losses`].
pub fn read(path: &Path, config: &Config) -> Result<Log, LogError> {
    let mut visits = Visits::new(config)?;
    let walked = container::walk(path, &mut |channel, message| visits.take(channel, message));
    let losses = walked.map_err(|error| LogError::open(path, error))?;
    visits.finish(file_name(path), config, losses)
}

/// Reads a log together with the truth that it carries.
///
/// # Errors
/// As [`read`].
pub fn read_with_truth(path: &Path, config: &Config) -> Result<(Log, RecordedTruth), LogError> {
    let mut visits = Visits::new(config)?;
    let mut truth = RecordedTruth::default();
    let walked = container::walk(path, &mut |channel, message| {
        truth.take(channel, message);
        visits.take(channel, message);
    });
    let losses = walked.map_err(|error| LogError::open(path, error))?;
    finish_with_truth(visits, truth, file_name(path), config, losses)
}

/// [`read_with_truth`] over anything that can be read from any place; `file` is what it is called.
///
/// # Errors
/// As [`read`].
pub fn read_with_truth_in<R: Read + Seek>(
    input: R,
    file: &str,
    config: &Config,
) -> Result<(Log, RecordedTruth), LogError> {
    let mut visits = Visits::new(config)?;
    let mut truth = RecordedTruth::default();
    let walked = container::walk_in(input, &mut |channel, message| {
        truth.take(channel, message);
        visits.take(channel, message);
    });
    let losses = walked.map_err(|error| LogError::open(Path::new(file), error))?;
    finish_with_truth(visits, truth, file.to_owned(), config, losses)
}

fn finish_with_truth(
    visits: Visits,
    truth: RecordedTruth,
    file: String,
    config: &Config,
    losses: Vec<Loss>,
) -> Result<(Log, RecordedTruth), LogError> {
    let mut log = visits.finish(file, config, losses)?;
    log.losses.extend(truth.loss());
    Ok((log, truth))
}

/// What the messages of a log give, one after the other.
struct Visits {
    channels: Channels,
    gatherer: Gatherer,
}

impl Visits {
    fn new(config: &Config) -> Result<Self, LogError> {
        Ok(Self {
            channels: Channels::new(config)?,
            gatherer: Gatherer::default(),
        })
    }

    fn take(&mut self, channel: &Channel, message: RawMessage<'_>) {
        if let Some((role, content)) = self.channels.read(channel, message) {
            let topic = &channel.topic;
            self.gatherer.take(role, topic, message.log_time, content);
        }
    }

    fn finish(self, file: String, config: &Config, losses: Vec<Loss>) -> Result<Log, LogError> {
        let lost = losses.clone();
        self.gatherer
            .finish(file, config, self.channels.into_reports(), losses)
            .map_err(|error| error.after(&lost))
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}
