//! From the bytes of an MCAP log to readings and odometry in stamp order.
//!
//! This room knows MCAP and message encodings and nothing of TMAM: everything downstream sees
//! [`Log`](crate::core::log::Log). A new encoding is a decoder in [`decoder`], a new message type a row in
//! [`types`] and a function in [`ranges`] or [`poses`].

mod assemble;
mod axes;
pub mod channels;
mod cone;
pub mod container;
mod custom;
mod decoder;
mod description;
mod error;
pub mod fuzzing;
mod gather;
mod hits;
mod json;
pub mod leaps;
mod message;
mod namespaces;
mod odometry;
mod poses;
mod protobuf;
mod ranges;
mod read;
mod repeats;
mod ros;
mod sonars;
mod stamps;
pub mod survey;
pub mod tracks;
pub mod traits;
mod transforms;
pub mod truth;
mod types;
mod unzipper;
mod value;
pub mod writer;

pub use channels::{NO_POSE, NO_RANGE};
pub use error::{LogError, MissingMount, UnplacedRing, itemised};
pub use message::Role;
pub use read::{Gathered, read, read_with_truth, read_with_truth_in};
pub use sonars::{TOO_WIDE, WIDEST_BEAM};
pub use stamps::ClockSet;
