//! A suite of twelve logs under seeded regressions, each of which must be caught and should be named for what it
//! is, and under harmless changes, none of which may be called a difference. The quick test changes one log for
//! each; all logs, and the table of docs/ci.md:
//! `cargo test --release --test it golden::suite -- --ignored --nocapture`.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;

use super::tmam;
use crate::support::{Bench, Message, rewrite};

/// How many logs there are.
const LOGS: usize = 12;

/// What becomes of a log's messages.
type Rewriting = Box<dyn Fn(Message) -> Vec<Message>>;

/// What is changed.
enum Change {
    /// The log, written with these options.
    Log(fn() -> mcap::WriteOptions, fn() -> Rewriting),
    /// What is given to the check, beside these files.
    Given(&'static [&'static str]),
    /// The golden file.
    Golden(fn(&mut Value)),
}

use Change::{Given, Golden, Log};

fn plain() -> mcap::WriteOptions {
    mcap::WriteOptions::new()
}

/// Of a `sensor_msgs/Range` in CDR, from the end of the message.
