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

pub mod assignment;
pub mod carried;
pub mod check;
pub mod cli;
pub mod config;
pub mod diff;
pub mod error;
pub mod evaluate;
pub mod event;
pub mod explain;
pub mod features;
pub mod frames;
pub mod geometry;
pub mod golden;
pub mod info;
pub mod legible;
pub mod log;
pub mod observer;
pub mod odometry;
pub mod output;
pub mod outputs;
pub mod progress;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rounding;
pub mod scatter;
pub mod schema;
pub mod simulate;
pub mod sweep;
pub mod tmam;
pub mod tool;
pub mod trace;
pub mod truth;
pub mod wording;
pub mod world;
