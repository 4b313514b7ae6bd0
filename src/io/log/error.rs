//! Why a log cannot be replayed, and what to do then.

use std::path::{Path, PathBuf};

use super::container::{Loss, OpenError};
use super::message::MOST_SONARS;
use crate::core::legible::one_line;
use crate::core::pattern::PatternError;

/// Why a log cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file cannot be read, or is none that is read.
    #[error("{}", unopened(path, source))]
    Open { path: PathBuf, source: OpenError },
    /// A folder of several drives where one is asked for.
    #[error(
        "{} holds {logs} logs that are no parts of one recording: name one of them, {} say. replay, info, \
         evaluate and check take all of them",
        .folder.display(),
        .first.display()
    )]
    Several {
        folder: PathBuf,
        logs: usize,
        first: PathBuf,
    },
    /// More than fits into the memory that is allowed.
    #[error(
        "{file} has more than {most} readings and odometry samples, as many as are held in memory. Leave \
         some topics out with --range-topic and --odom-topic, or raise input.max_readings (60 bytes of \
         memory for each)"
    )]
    TooManyReadings {
        /// The log.
        file: String,
        /// The limit.
        most: u64,
    },
    /// Nothing that measures ranges.
    #[error(
        "{file} has no range readings{}. {}\nRanges are read from sensor_msgs/Range, LaserScan, PointCloud and \
         PointCloud2 and from foxglove.LaserScan. Messages of other types are described by field paths in \
         the configuration:\n\n    [channel.\"/topic\"]\n    range = \"distance\"  # of its fields the one that \
         holds the range",
        because(.asked),
        lines("The log holds", .found)
    )]
    NoRanges {
        /// The log.
        file: String,
        /// Topic patterns that were asked for.
        asked: Vec<String>,
        /// The log's channels.
        found: Vec<String>,
    },
    /// Nothing that says where the robot was.
    #[error(
        "{file} has no odometry{}. {}\nIt is read from nav_msgs/Odometry, foxglove.Odometry, messages that hold \
         one pose, and transforms on /tf that move the robot's frame. Messages of other types are described \
         by field paths in the configuration:\n\n    [channel.\"/topic\"]\n    x = \"x\"\n    y = \"y\"\n    \
         yaw = \"theta\"  # of its fields those that hold the pose{}",
        because(.asked),
        lines("The log holds", .found),
        carried(.passed_over)
    )]
    NoOdometry {
        /// The log.
        file: String,
        /// Topic patterns that were asked for.
        asked: Vec<String>,
        /// The log's channels.
        found: Vec<String>,
        /// Transforms that move and were passed over: parents and children.
        passed_over: Vec<(String, String)>,
    },
    /// Several odometry topics.
    #[error("{file} has more than one odometry topic: {}. Choose one with --odom-topic", one_line(&topics.join(", ")))]
    ManyOdometries {
        /// The log.
        file: String,
        /// The topics.
        topics: Vec<String>,
    },
    /// No odometry but transforms, and several of them move.
    #[error(
        "{file} has no odometry messages, and which of the transforms that move is the robot's cannot be \
         told:{}\nSay which frame is the robot's in the configuration:\n\n    [input]\n    robot_frame = \"{}\"",
        moves(.moving),
        one_line(moving.first().map_or("base_link", |(_, child)| child))
    )]
    UnclearTransforms {
        /// The log.
        file: String,
        /// Parents and children.
        moving: Vec<(String, String)>,
    },
    /// Nothing moves in or to the frame asked for.
    #[error(
        "{file} does not say how {}, which {key} names, but how these move:{}",
        if *key == "input.robot_frame" {
            format!("`{frame}` moves")
        } else {
            format!("the robot moves in `{frame}`")
        },
        moves(.moving)
    )]
    NoSuchFrame {
        /// The log.
        file: String,
        /// The frame asked for.
        frame: String,
        /// What asks for it.
        key: &'static str,
        /// Parents and children.
        moving: Vec<(String, String)>,
    },
    /// Points of a sonar ring, without the mounts of its sonars.
    #[error(transparent)]
    UnplacedRing(Box<UnplacedRing>),
    /// A sonar whose place on the robot is unknown.
    #[error(transparent)]
    NoMount(Box<MissingMount>),
    /// A sonar whose beam width is unknown.
    #[error(
        "sonar `{sonar}` (topic {topic}) gives no beam width: its field_of_view is no angle above 0. \
         Set sonars.beam_width, or beam_width under [sonar.\"{sonar}\"], in the configuration (deg, full angle)",
        sonar = one_line(sonar), topic = one_line(topic)
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
        if carriers.is_empty() { "none".to_owned() } else { one_line(&carriers.join(", ")).into_owned() },
        topic = one_line(topic)
    )]
    NoRobotFrame {
        /// The topic.
        topic: String,
        /// The frames that carry sonars.
        carriers: Vec<String>,
    },
    /// More sonars than can be told apart.
    #[error("{file} has more than {MOST_SONARS} sonars; choose topics with --range-topic")]
    TooManySonars {
        /// The log.
        file: String,
    },
    /// A pattern of topics that cannot be read.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// Something is missing, and there is more to know of the log.
    #[error("{source}\nAlso:{}", itemised(.notes))]
    Noted {
        /// What is missing.
        source: Box<LogError>,
        /// What a person should know.
        notes: Vec<String>,
    },
    /// A log of which nothing is left.
    #[error("nothing of {file} can be used: it is damaged. Lost:{}", itemised(.losses))]
    Unreadable {
        /// The log.
        file: String,
        /// What could not be read.
        losses: Vec<String>,
    },
    /// A damaged log, of which too little is left.
    #[error("{source}\nThe log is damaged. Lost:{}", itemised(.losses))]
    Damaged {
        /// What is missing.
        source: Box<LogError>,
        /// What could not be read.
        losses: Vec<String>,
    },
}

impl LogError {
    /// The same, in one line.
    pub fn in_short(&self) -> String {
        match self {
            Self::NoMount(missing) => {
                let name = &missing.sonar;
                let why = &missing.why;
                let carried = missing.carrier.as_ref();
                let carried = carried.map(|carrier| carried_by(carrier, &missing.robot_frame));
                format!(
                    "it has no mounting pose, {why}.{} Record /tf_static, or give x, y and yaw under [sonar.\"{name}\"]",
                    carried.unwrap_or_default()
                )
            }
            Self::NoBeamWidth { sonar, .. } => format!(
                "it has no beam width, its field_of_view is no angle above 0. Set beam_width under [sonar.\"{sonar}\"]"
            ),
            Self::NoRobotFrame { .. } => {
                "its mount is not in the configuration, and the odometry does not name the frame that it moves. \
                 Set input.robot_frame".to_owned()
            }
            other => other.to_string(),
        }
    }

    /// Whether the log may be well, and only the configuration does not say enough of it.
    pub fn wants_configuration(&self) -> bool {
        match self {
            Self::Open { .. } | Self::Unreadable { .. } | Self::Damaged { .. } => false,
            // Of a log without channels nothing can be configured.
            Self::NoRanges { found, .. } | Self::NoOdometry { found, .. } => !found.is_empty(),
            Self::Noted { source, .. } => source.wants_configuration(),
            _ => true,
        }
    }

    /// The same, and what else a person should know.
    pub fn noting(self, notes: Vec<String>) -> Self {
        match notes.is_empty() {
            true => self,
            false => Self::Noted {
                source: Box::new(self),
                notes,
            },
        }
    }

    /// What is missing may be what was lost.
    pub fn after(self, losses: &[Loss]) -> Self {
        if losses.is_empty() {
            return self;
        }
        let losses = losses.iter().map(ToString::to_string).collect();
        match self {
            Self::NoRanges { file, found, .. } if found.is_empty() => {
                Self::Unreadable { file, losses }
            }
            error => Self::Damaged {
                source: Box::new(error),
                losses,
            },
        }
    }

    pub fn open(path: &Path, error: OpenError) -> Self {
        Self::Open {
            path: path.to_owned(),
            source: error,
        }
    }
}

/// A sonar whose place on the robot is unknown.
#[derive(Debug, thiserror::Error)]
#[error(
    "no mounting pose for sonar frame `{frame}` (topic {topic}): {why}. {}{} Give the mount in the \
     configuration:\n\n    [sonar.\"{sonar}\"]\n    x = 0.0    # m, in `{robot_frame}`\n    y = 0.0    # m\n    \
     yaw = 0.0  # deg\n\nor leave its topic out with --range-topic",
    list("Frames with a transform:", .frames),
    elsewhere(.carrier.as_deref(), .robot_frame, *.is_part)
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
    /// The frame on which it is mounted, where that is another one than the robot's.
    pub carrier: Option<String>,
    /// Whether a part of the recording that is not here may have it.
    pub is_part: bool,
    /// Every frame of the transform tree.
    pub frames: std::sync::Arc<[String]>,
}

/// Where the mount may be.
fn elsewhere(carrier: Option<&str>, robot_frame: &str, is_part: bool) -> String {
    match carrier {
        Some(carrier) => carried_by(carrier, robot_frame),
        None if is_part => LATER_PART.to_owned(),
        None => String::new(),
    }
}

/// What else may be the robot's frame (ros-navigation/navigation2#2957).
fn carried_by(carrier: &str, robot_frame: &str) -> String {
    format!(
        " It is mounted on `{carrier}`: if that is where `{robot_frame}` is, set input.robot_frame = {}.",
        one_line(&toml::Value::from(carrier).to_string())
    )
}

/// Only the first part of a split recording has what is said once (ros2/rosbag2#1159).
const LATER_PART: &str = " A later part of a split recording lacks /tf_static, which is in its first part: replay the folder, \
    or set input.mounts_from = \"FIRST_PART.mcap\".";

/// Points of a sonar ring, without the mounts of its sonars.
#[derive(Debug, thiserror::Error)]
#[error(
    "the points on {topic} do not say where the sonars are that they come from. Give the mount of each of the \
     {} in the configuration, under any name (`tmam info --skeleton` prints all of it):\n\n    \
     [sonar.\"{}\"]\n    x = 0.0          # m, in the robot's frame\n    y = 0.0          # m\n    \
     yaw = {:.1}  # deg: where the beam looks\n    beam_width = 22.5\n    max_range = 5.0  # m: a point at it is no echo",
    directions.len(),
    self.name(0),
    directions.first().copied().unwrap_or_default().to_degrees()
)]
pub struct UnplacedRing {
    /// The topic.
    pub topic: String,
    /// Where the points of each sonar lie, seen from the robot: radians.
    pub directions: Vec<f64>,
}

impl UnplacedRing {
    /// What the sonar of the `index`-th point may be called.
    pub fn name(&self, index: usize) -> String {
        format!("sonar_{index:02}")
    }
}

fn unopened(path: &Path, error: &OpenError) -> String {
    let path = path.display();
    match error {
        OpenError::Io(error) => format!("cannot read {path}: {error}"),
        OpenError::Empty => format!("{path} is empty: it has 0 bytes. Copy or record it again"),
        OpenError::NoParts => format!(
            "{path} is a folder without a .mcap file: a log is one, or a folder of its parts"
        ),
        OpenError::NotMcap(what) if !what.is_empty() => {
            format!("{path} is not an MCAP file: {what}")
        }
        OpenError::NotMcap(_) => format!(
            "{path} is not an MCAP file: it does not begin with the MCAP magic bytes. Convert other logs first \
             (`ros2 bag convert` for a rosbag2 folder of .db3 files, `mcap convert` for a ROS 1 bag)"
        ),
        OpenError::NoFile => format!(
            "{path} is a pipe or a device. A log is read from its end first: write it into a file"
        ),
    }
}

/// A line for every item, as far as anyone reads them.
pub fn itemised(items: &[String]) -> String {
    const SHOWN: usize = 10;
    let mut text: String = items
        .iter()
        .take(SHOWN)
        .map(|item| format!("\n  - {}", one_line(item)))
        .collect();
    if let more @ 1.. = items.len().saturating_sub(SHOWN) {
        text.push_str(&format!(
            "\n  - and {more} more; `tmam info --json` lists all of them"
        ));
    }
    text
}

fn because(asked: &[String]) -> String {
    match asked {
        [] => String::new(),
        _ => format!(" on the topics asked for ({})", asked.join(", ")),
    }
}

/// `base_link` in `odom`, a line for each.
fn moves(edges: &[(String, String)]) -> String {
    let named = edges
        .iter()
        .map(|(parent, child)| format!("`{child}` in `{parent}`"));
    itemised(&named.collect::<Vec<_>>())
}

/// What was not taken for odometry.
fn carried(edges: &[(String, String)]) -> String {
    let Some((_, world)) = edges.first() else {
        return String::new();
    };
    format!(
        "\nTransforms that move, and were not taken for odometry because the sonars' frame carries them:{}\nIf one \
         of them is what the robot moves in, name it, and it is taken the other way round: input.world_frame = {}",
        moves(edges),
        one_line(&toml::Value::from(world.as_str()).to_string())
    )
}

/// A line for each of some items, as far as anyone reads them.
fn lines(head: &str, items: &[String]) -> String {
    match items {
        [] => format!("{head} nothing."),
        _ => format!("{head}:{}", itemised(items)),
    }
}

fn list(head: &str, items: &[String]) -> String {
    const SHOWN: usize = 16;
    let shown = items.get(..SHOWN).unwrap_or(items).join(", ");
    match items.len() {
        0 => format!("{head} nothing."),
        count if count > SHOWN => format!("{head} {shown} and {} more.", count - SHOWN),
        _ => format!("{head} {shown}."),
    }
}
