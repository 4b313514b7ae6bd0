//! Replays MCAP logs of sonar range and odometry channels, steps TMAM - the three measurements
//! association model of Wang, Hou, Ma, Zhang, Zhang and Tan - over them frame by frame, and shows
//! what it saw and decided.
//!
//! One way through the house, and nothing imports upward:
//!
//! ```text
//! log   ->  frames  ->  tmam  ->  observers
//! MCAP      one step    labels,   recording, trace, progress
//! events    at a time   features
//! ```

pub mod cli;
pub mod core;
pub mod io;
pub mod observe;
pub mod tools;
