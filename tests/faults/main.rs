//! Damaged logs: what can be read of them is used, what cannot is said, and nothing is made up.

#[path = "../support/mod.rs"]
mod support;

mod corpus;
mod crafted;
mod damage;
mod exit_codes;
mod injection;
mod pristine;
mod raw;
