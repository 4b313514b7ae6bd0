//! Schemas and channels by their numbers.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::record::{self, Inner, op};
use super::{Channel, Schema, Why};

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
    /// Takes a schema or channel; other records are passed over. `fallback` holds the definitions
    /// of the summary, for those whose own place is lost.
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
            _ => Ok(()),
        }
    }

    fn add(&mut self, schema: u16, channel: Channel, fallback: Option<&Self>) -> Result<(), Why> {
        let id = channel.id;
        let find = |registry: &Self| registry.schemas.get(&schema).cloned();
        let schema = match schema {
            0 => Rc::default(),
            _ => find(self)
                .or_else(|| fallback.and_then(find))
                .ok_or(Why::UnknownSchema(schema))?,
        };
        let channel = Channel { schema, ..channel };
        // A channel may be repeated, but not changed: its messages would change their meaning.
        if *self.channels.entry(id).or_insert_with(|| channel.clone()) == channel {
            return Ok(());
        }
        if self.ambiguous.insert(id) {
            Err(Why::Conflict(id))
        } else {
            Ok(())
        }
    }

    /// The channel of a message, from the summary where its own definition is lost.
    pub fn channel<'a>(&'a self, id: u16, fallback: Option<&'a Self>) -> Result<&'a Channel, Why> {
        if self.ambiguous.contains(&id) {
            return Err(Why::Conflict(id));
        }
        let find = |registry: &'a Self| registry.channels.get(&id);
        find(self)
            .or_else(|| fallback.and_then(find))
            .ok_or(Why::UnknownChannel(id))
    }

    /// Whether any channel is defined.
    pub fn knows(&self, id: u16) -> bool {
        self.channels.contains_key(&id)
    }
}
