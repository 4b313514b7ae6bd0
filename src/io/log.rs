//! From the bytes of an MCAP log to readings and odometry in stamp order.
//!
//! This room knows MCAP and message encodings and nothing of TMAM: everything downstream sees
//! [`Log`](crate::core::log::Log). A new encoding is a decoder in [`decoder`], a new message type a function in
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

pub use error::{LogError, MissingMount, UnplacedRing, itemised};
pub use gathered::Gathered;
pub use messages::Role;
pub use notes::{NO_POSE, NO_RANGE};
pub use read::{read, read_with_truth, read_with_truth_in};
pub use sonars::{TOO_WIDE, WIDEST_BEAM};
pub use stamps::ClockSet;
