//! Bytes to time-ordered typed events, and back.

pub mod writer;
