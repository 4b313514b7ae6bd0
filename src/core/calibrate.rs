//! What a log itself says of its mounts, clocks, ranges and odometry: which values fit its ranges best.
//!
//! The ranges see where a sonar is, by how much its ranges are off, when they were taken and how long
//! odometry's metre is: [`ranges`], by (6) and (7). Where it looks and how wide its beam is, only the
//! beam says: at which bearings it hears what is there, and at which it does not: [`bearings`]. What is likely is tried by [`search`].

mod bearings;
mod borne_out;
pub mod candidate;
pub mod change;
mod far_off;
mod mistaken;
pub mod parameter;
mod ranges;
pub mod search;
mod seen;
mod stretched;
