//! What is used of a file: its definitions, and its messages as they are found.

use super::record::{self, Inner, Records, op};
use super::registry::Registry;
use super::{Channel, RawMessage, Why};

/// Who is shown the messages.
pub type Visit<'v> = dyn FnMut(&Channel, RawMessage<'_>) + 'v;

/// Definitions and messages.
pub struct Used<'v> {
    /// Schemas and channels seen so far.
    pub registry: Registry,
    /// Those of the summary, for what has lost its own.
    pub fallback: Registry,
    /// Messages used.
    pub messages: u64,
    /// Log time of the earliest.
    pub start: Option<u64>,
    /// Log time of the last one in the file so far.
    pub last: Option<u64>,
    /// Log time of the first one since this was last taken.
    pub next: Option<u64>,
    visit: &'v mut Visit<'v>,
}

/// What went wrong inside a chunk.
#[derive(Debug, Default)]
pub struct Inside {
    /// The first reason.
    pub why: Option<Why>,
    /// Messages that could not be used.
    pub lost: u64,
    /// Whether there may have been more messages.
    pub overrun: bool,
}

impl<'v> Used<'v> {
    /// Nothing yet.
    pub fn new(fallback: Registry, visit: &'v mut Visit<'v>) -> Self {
        Self {
            registry: Registry::default(),
            fallback,
            messages: 0,
            start: None,
            last: None,
            next: None,
            visit,
        }
    }

    /// What defines channels: the data so far, and the summary.
    pub fn known(&self) -> [&Registry; 2] {
        [&self.registry, &self.fallback]
    }

    /// Takes a schema or channel.
    pub fn define(&mut self, record: Inner<'_>) -> Result<(), Why> {
        self.registry.define(record, Some(&self.fallback))
    }

    /// Takes the records of a chunk. Where the chunk is `cut` off, nothing vouches for them: then a
    /// record that is followed by nonsense may be damaged itself.
    pub fn records(&mut self, bytes: &[u8], cut: bool) -> Inside {
        let mut inside = Inside::default();
        let mut records = Records::new(bytes);
        while let Some(record) = records.next() {
            let nonsense = |rest: &[u8]| {
                rest.first().is_some_and(
                    |opcode| !matches!(*opcode, op::SCHEMA..=op::MESSAGE | op::PRIVATE..),
                )
            };
            if cut && nonsense(records.rest()) {
                break;
            }
            let outcome = match record.opcode {
                op::MESSAGE => self.message(record.body).inspect_err(|_| {
                    inside.lost += 1;
                }),
                _ => self.define(record),
            };
            if let Err(why) = outcome {
                inside.why.get_or_insert(why);
            }
        }
        if !records.rest().is_empty() {
            inside.overrun = true;
            inside.why.get_or_insert(Why::Overrun);
        }
        inside
    }

    /// Takes a message.
    pub fn message(&mut self, body: &[u8]) -> Result<(), Why> {
        let (id, log_time, data) = record::message(body).map_err(|_| Why::Malformed)?;
        let channel = self.registry.channel(id, Some(&self.fallback))?;
        (self.visit)(channel, RawMessage { log_time, data });
        self.messages += 1;
        self.start = Some(self.start.map_or(log_time, |start| start.min(log_time)));
        self.last = Some(log_time);
        self.next.get_or_insert(log_time);
        Ok(())
    }
}
