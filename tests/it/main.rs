//! What a user meets, from outside: the binary, its files, and the library's public face.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that meets something unexpected should fail on the spot"
)]

mod support;

#[cfg(feature = "parquet")]
mod arcs;
mod bad_input;
mod calibrate;
mod circles;
mod drift;
mod encodings;
mod evaluate;
mod explain;
mod faults;
mod fleet;
mod floors;
mod golden;
mod info;
#[cfg(feature = "viewer")]
mod live;
mod map_file;
mod methods;
mod noise;
mod odd_logs;
mod outputs;
mod pages;
mod poses;
mod reference;
mod replay;
mod report;
mod reproduce;
mod room;
mod rough;
mod sample_logs;
mod snapshots;
mod study;
mod sweep;
mod ties;
