//! From the bytes of an MCAP log to readings and odometry in stamp order.
//!
//! This room knows MCAP and message encodings and nothing of TMAM: everything downstream sees
//! [`Events`]. A new encoding is a decoder in [`decoder`], a new message type a function in
//! [`messages`].

mod budget;
pub mod channels;
pub mod clock;
pub mod container;
mod custom;
mod decoder;
mod decoders;
mod description;
mod error;
pub mod fuzzing;
mod gather;
mod gathered;
mod json;
pub mod leaps;
mod messages;
mod msg_schema;
mod notes;
mod outliers;
mod protobuf;
mod read;
mod repeats;
mod rings;
mod ros1;
mod ros2;
mod sonars;
mod stamps;
mod standard;
mod strays;
pub mod survey;
mod transforms;
pub mod truth;
mod value;
pub mod writer;

use crate::core::event::Events;
use channels::ChannelReport;
pub use error::{LogError, MissingMount, UnplacedRing, itemised};
pub use gathered::Gathered;
pub use messages::Role;
pub use notes::{NO_POSE, NO_RANGE};
pub use read::{read, read_with_truth, read_with_truth_in};
pub use sonars::{TOO_WIDE, WIDEST_BEAM};
pub use stamps::ClockSet;

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
    /// How the clock of its stamps was set while it was recorded.
    pub clock_set: Option<ClockSet>,
    /// What else is odd about its stamps.
    pub time_notes: Vec<String>,
}

impl Log {
    /// What a person should know of it, the weightiest first.
    pub fn told(&self) -> Vec<String> {
        let of_clock = self.clock_set.iter().map(ClockSet::text);
        let others = self.time_notes.iter().chain(&self.notes);
        of_clock.chain(others.cloned()).collect()
    }
}
