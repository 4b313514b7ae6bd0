//! Damaged logs: what can be read of them is used, what cannot is said, and nothing is made up.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that meets something unexpected should fail on the spot"
)]

#[path = "../support/mod.rs"]
mod support;

mod bounded;
mod corpus;
mod crafted;
mod damage;
mod exit_codes;
mod index;
mod injection;
mod pristine;
mod raw;
