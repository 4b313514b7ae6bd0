//! Channels and their messages: what of a file is handed over.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::loss::Why;
use super::record::{self, Channel, Inner, RawMessage, Records, Schema, op};

/// Bytes of message definitions that are held of a file.
const MOST_DEFINITIONS: usize = 32 << 20;

/// Definitions from one part of a file.
#[derive(Debug, Clone, Default)]
pub struct Registry {
    schemas: BTreeMap<u16, Rc<Schema>>,
    channels: BTreeMap<u16, Channel>,
    /// Channels whose messages could mean one thing or another.
    ambiguous: BTreeSet<u16>,
    /// Bytes of the schemas.
    held: usize,
}

impl Registry {
    /// Takes a schema or channel. `fallback` holds the definitions of the summary, for those whose
    /// own place is lost.
    pub fn define(&mut self, record: Inner<'_>, fallback: Option<&Self>) -> Result<(), Why> {
        match record.opcode {
            op::SCHEMA => {
                let (id, schema) = record::schema(record.body).map_err(|_| Why::Malformed)?;
                if let Some(known) = self.schemas.get(&id) {
                    // Repeated; or changed, and then nobody knows which of the two channels mean.
                    return if **known == schema {
                        Ok(())
                    } else {
                        Err(Why::SchemaConflict(id))
                    };
                }
                self.held = self.held.saturating_add(schema.data.len());
                if self.held > MOST_DEFINITIONS {
                    return Err(Why::Definitions);
                }
                self.schemas.insert(id, Rc::new(schema));
                Ok(())
            }
            op::CHANNEL => {
                let (schema, channel) = record::channel(record.body).map_err(|_| Why::Malformed)?;
                self.add(schema, channel, fallback)
            }
            opcode => Err(Why::Kind(opcode)),
        }
    }

    fn add(&mut self, schema: u16, channel: Channel, fallback: Option<&Self>) -> Result<(), Why> {
        let id = channel.id;
        let known = self.schema(schema).or_else(|| fallback?.schema(schema));
        let schema = known.ok_or(Why::UnknownSchema(schema))?;
        let channel = Channel { schema, ..channel };
        // A channel may be repeated, but not changed: its messages would change their meaning.
        if *self.channels.entry(id).or_insert_with(|| channel.clone()) == channel {
            return Ok(());
        }
        match self.ambiguous.insert(id) {
            true => Err(Why::Conflict(id)),
            false => Ok(()),
        }
    }

    /// The channel of a message, from the summary where its own definition is lost.
    fn channel<'a>(&'a self, id: u16, fallback: &'a Self) -> Result<&'a Channel, Why> {
        if self.ambiguous.contains(&id) {
            return Err(Why::Conflict(id));
        }
        let known = self
            .channels
            .get(&id)
            .or_else(|| fallback.channels.get(&id));
        known.ok_or(Why::UnknownChannel(id))
    }

    /// Whether it has this very definition, or another one of this number; `None` where it has none.
    pub fn repeats(&self, record: Inner<'_>) -> Option<bool> {
        if record.opcode == op::SCHEMA {
            let (id, schema) = record::schema(record.body).ok()?;
            return Some(**self.schemas.get(&id)? == schema);
        }
        let (schema, channel) = record::channel(record.body).ok()?;
        let known = self.channels.get(&channel.id)?;
        let schema = self.schema(schema);
        Some(schema.is_some_and(|schema| *known == Channel { schema, ..channel }))
    }

    /// 0 is the schema of channels that have none.
    fn schema(&self, id: u16) -> Option<Rc<Schema>> {
        match id {
            0 => Some(Rc::default()),
            id => self.schemas.get(&id).cloned(),
        }
    }
}

/// Who is shown the messages.
pub type Visit<'v> = dyn FnMut(&Channel, RawMessage<'_>) + 'v;

/// Hands messages over, each with its channel.
pub struct Delivery<'v> {
    registry: Registry,
    /// The summary's definitions, for what has lost its own.
    pub fallback: Registry,
    /// Messages handed over.
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

impl<'v> Delivery<'v> {
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

    /// Takes a schema or channel.
    pub fn define(&mut self, record: Inner<'_>) -> Result<(), Why> {
        self.registry.define(record, Some(&self.fallback))
    }

    /// Whether any channel has this number.
    pub fn knows(&self, channel: u16) -> bool {
        let mut known = [&self.registry, &self.fallback].into_iter();
        known.any(|known| known.channels.contains_key(&channel))
    }

    /// Takes the records of a chunk. Where the chunk is `cut` off, nothing vouches for them: then a
    /// record that is followed by nonsense may be damaged itself.
    pub fn records(&mut self, bytes: &[u8], cut: bool) -> Inside {
        let mut inside = Inside::default();
        let mut records = Records(bytes);
        while let Some(record) = records.next() {
            let belongs = |op: &u8| matches!(*op, op::SCHEMA..=op::MESSAGE | op::PRIVATE..);
            if cut && !records.0.first().is_none_or(belongs) {
                break;
            }
            let outcome = match record.opcode {
                op::MESSAGE => self.message(record.body).inspect_err(|_| {
                    inside.lost += 1;
                }),
                op::PRIVATE.. => Ok(()),
                _ => self.define(record),
            };
            if let Err(why) = outcome {
                inside.why.get_or_insert(why);
            }
        }
        if !records.0.is_empty() {
            inside.overrun = true;
            inside.why.get_or_insert(Why::Overrun);
        }
        inside
    }

    /// Hands a message over.
    pub fn message(&mut self, body: &[u8]) -> Result<(), Why> {
        let (id, log_time, data) = record::message(body).map_err(|_| Why::Malformed)?;
        let channel = self.registry.channel(id, &self.fallback)?;
        (self.visit)(channel, RawMessage { log_time, data });
        self.messages += 1;
        self.start = Some(self.start.map_or(log_time, |start| start.min(log_time)));
        self.last = Some(log_time);
        self.next.get_or_insert(log_time);
        Ok(())
    }
}
