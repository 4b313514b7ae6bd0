//! The truth that a simulated log carries: the world, what echoed and where the robot was, in JSON.

use serde::de::DeserializeOwned;

use super::container::{Channel, RawMessage};
use crate::core::truth::{PoseTruth, ReadingTruth};
use crate::core::wording::counted;
use crate::core::world::{World, WorldError};

/// Schema of the truth about one reading.
pub const READING_SCHEMA: &str = "tmam.ReadingTruth";
/// Schema of the truth about one odometry sample.
pub const POSE_SCHEMA: &str = "tmam.PoseTruth";
/// Schema of the world that the truth counts in.
pub const WORLD_SCHEMA: &str = "tmam.World";

/// No world and no reading's truth is as long as this, bytes.
const LONGEST_MESSAGE: usize = 4 << 20;

/// What a log says of the truth.
#[derive(Debug, Default)]
pub struct RecordedTruth {
    readings: Messages<ReadingTruth>,
    poses: Messages<PoseTruth>,
    world: Option<World>,
    problem: Option<WorldProblem>,
}

/// What the messages of one kind say, in file order.
#[derive(Debug)]
struct Messages<T> {
    read: Vec<T>,
    unreadable: u64,
    /// What is wrong with the first one that is not readable.
    first: Option<String>,
}

impl<T> Default for Messages<T> {
    fn default() -> Self {
        Self {
            read: Vec::new(),
            unreadable: 0,
            first: None,
        }
    }
}

impl<T: DeserializeOwned> Messages<T> {
    fn take(&mut self, json: &[u8]) {
        let parsed: Result<T, String> = if json.len() > LONGEST_MESSAGE {
            Err(format!("it is {} bytes long", json.len()))
        } else {
            serde_json::from_slice(json).map_err(|error| error.to_string())
        };
        match parsed {
            Ok(truth) => self.read.push(truth),
            Err(problem) => {
                self.unreadable += 1;
                self.first.get_or_insert(problem);
            }
        }
    }

    fn loss(&self, of: &str) -> Option<String> {
        (self.unreadable > 0).then(|| {
            format!(
                "{} of {} about the truth of {of}: {}",
                self.unreadable,
                counted(self.unreadable + self.read.len() as u64, "message"),
                self.first.as_deref().unwrap_or_default()
            )
        })
    }
}

/// Why the world in a log cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WorldProblem {
    /// It is no world.
    #[error(transparent)]
    World(#[from] WorldError),
    /// Longer than any world that is read.
    #[error("it is {bytes} bytes long, more than {LONGEST_MESSAGE}")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// Two worlds that differ.
    #[error("the log holds several worlds that differ")]
    Several,
}

impl RecordedTruth {
    /// Takes a message if it is about the truth.
    pub fn take(&mut self, channel: &Channel, message: RawMessage<'_>) {
        if channel.encoding != "json" {
            return;
        }
        match channel.schema.name.as_str() {
            READING_SCHEMA => self.readings.take(message.data),
            POSE_SCHEMA => self.poses.take(message.data),
            WORLD_SCHEMA => {
                if let Err(problem) = self.take_world(message.data) {
                    self.problem.get_or_insert(problem);
                }
            }
            _ => {}
        }
    }

    fn take_world(&mut self, json: &[u8]) -> Result<(), WorldProblem> {
        if json.len() > LONGEST_MESSAGE {
            return Err(WorldProblem::TooLong { bytes: json.len() });
        }
        let world = serde_json::from_slice(json).map_err(WorldError::Format)?;
        match *self.world.get_or_insert_with(|| World::clone(&world)) == world {
            true => Ok(()),
            false => Err(WorldProblem::Several),
        }
    }

    /// The world that the truth counts in, where the log holds one.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn world(&self) -> Result<Option<&World>, &WorldProblem> {
        match &self.problem {
            Some(problem) => Err(problem),
            None => Ok(self.world.as_ref()),
        }
    }

    /// What echoed at each reading, in file order.
    pub fn readings(&self) -> &[ReadingTruth] {
        &self.readings.read
    }

    /// Where the robot was at each odometry sample, in file order; empty where odometry is the truth, or
    /// nothing says so.
    pub fn poses(&self) -> &[PoseTruth] {
        &self.poses.read
    }

    /// What could not be read of the truth, for a person.
    pub fn losses(&self) -> impl Iterator<Item = String> {
        let of_readings = self.readings.loss("readings");
        of_readings.into_iter().chain(self.poses.loss("poses"))
    }
}
