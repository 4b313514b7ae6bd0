//! Why a log cannot be replayed, and what to do then.

mod context;
mod lists;
mod missing;

use std::path::PathBuf;

pub use lists::itemised;
pub use missing::{MissingMount, UnplacedRing};

use super::message::MOST_SONARS;
use crate::core::legible::one_line;
use crate::core::pattern::PatternError;
use lists::{because, carried, lines, moves};

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
    /// Nothing is in it.
    #[error("{} is empty: it has 0 bytes. Copy or record it again", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
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
    /// Something that has no end to begin with.
    #[error(
        "{} is a pipe or a device. A log is read from its end first: write it into a file",
        path.display()
    )]
    NoFile {
        /// The file.
        path: PathBuf,
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
    /// More messages than a file of its length has room for, by any honest packing.
    #[error(
        "{file} has {bytes} bytes and more than {most} messages of sonars, odometry and transforms: no \
         recording packs so tightly. If it is right all the same, raise input.max_readings to the number of \
         its readings"
    )]
    TooDense {
        /// The log.
        file: String,
        /// Bytes of the file.
        bytes: u64,
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
