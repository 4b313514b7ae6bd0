//! The MCAP container: from a file to its messages, chunk by chunk.
//!
//! Chunks are checked against their CRC before a message of theirs is used, and nothing is
//! allocated that the file is not long enough to fill. A chunk that cannot be trusted is left out
//! and reported; reading goes on behind it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::rc::Rc;

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::LogError;

/// The largest chunk, compressed or not, that is read: bytes.
const MAX_CHUNK: usize = 128 << 20;

/// One channel of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// Its number in the file.
    pub id: u16,
    /// Its topic.
    pub topic: String,
    /// How its messages are encoded: `cdr`, `json`, ...
    pub encoding: String,
    /// What its messages mean.
    pub schema: Rc<Schema>,
}

/// The definition of a message type; all empty for a channel without one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Schema {
    /// `sensor_msgs/msg/Range`, ...
    pub name: String,
    /// `ros2msg`, `jsonschema`, ...
    pub encoding: String,
    /// Its text or descriptors.
    pub data: Vec<u8>,
}

/// One message as it lies in the file.
#[derive(Debug, Clone, Copy)]
pub struct RawMessage<'a> {
    /// When it was recorded, nanoseconds.
    pub log_time: u64,
    /// Its bytes.
    pub data: &'a [u8],
}

/// Something that could not be read from the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loss {
    /// Where in the file, bytes from its start.
    pub offset: u64,
    /// What was lost and why, for a person.
    pub what: String,
}

/// The channels and schemas seen so far.
#[derive(Debug, Default)]
struct Registry {
    schemas: BTreeMap<u16, Rc<Schema>>,
    channels: BTreeMap<u16, Channel>,
}

/// Calls `visit` with every message of the file that can be trusted, in file order.
///
/// # Errors
/// A file that cannot be opened or is not an MCAP file. Everything else is a [`Loss`].
pub fn walk(
    path: &Path,
    visit: &mut dyn FnMut(&Channel, RawMessage<'_>),
) -> Result<Vec<Loss>, LogError> {
    let io = |source| LogError::Io {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if metadata.is_dir() {
        return Err(io(std::io::ErrorKind::IsADirectory.into()));
    }
    let length = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
    if length < mcap::MAGIC.len() {
        return Err(LogError::NotMcap {
            path: path.to_owned(),
        });
    }
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_skip_end_magic(true)
            .with_record_length_limit(length.min(MAX_CHUNK)),
    );
    let mut registry = Registry::default();
    let mut losses = Vec::new();
    let mut offset = mcap::MAGIC.len() as u64;
    let mut closed = false;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(need)) => {
                let read = file.read(reader.insert(need)).map_err(io)?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { opcode, data }) => {
                closed = matches!(opcode, op::DATA_END | op::FOOTER);
                if closed {
                    break; // behind it lies only the summary, which repeats what was read
                }
                let at = offset;
                offset += RECORD_HEADER + data.len() as u64;
                if let Err(why) = registry.record(opcode, data, visit) {
                    losses.push(Loss {
                        offset: at,
                        what: format!("{}: {why}", describe(opcode, data)),
                    });
                }
            }
            Err(mcap::McapError::BadMagic) => {
                return Err(LogError::NotMcap {
                    path: path.to_owned(),
                });
            }
            Err(error) => {
                losses.push(Loss {
                    offset,
                    what: format!("everything from here to the end of the file: {error}"),
                });
                return Ok(losses);
            }
        }
    }
    if !closed {
        losses.push(Loss {
            offset,
            what: "the file ends without a footer: its recorder did not finish".to_owned(),
        });
    }
    Ok(losses)
}

/// Opcode and length in front of every record, bytes.
const RECORD_HEADER: u64 = 9;

fn describe(opcode: u8, data: &[u8]) -> String {
    match (opcode, mcap::parse_record(op::CHUNK, data)) {
        (op::CHUNK, Ok(Record::Chunk { header, .. })) => format!(
            "a chunk with messages logged from {:.3} s to {:.3} s",
            header.message_start_time as f64 * 1e-9,
            header.message_end_time as f64 * 1e-9
        ),
        (op::CHUNK, _) => "a chunk".to_owned(),
        _ => format!("a record (opcode {opcode:#04x})"),
    }
}

impl Registry {
    fn record(
        &mut self,
        opcode: u8,
        data: &[u8],
        visit: &mut dyn FnMut(&Channel, RawMessage<'_>),
    ) -> Result<(), mcap::McapError> {
        // Only these kinds are parsed: the others carry nothing that is used here.
        match opcode {
            op::CHUNK => self.chunk(data, visit),
            op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                match mcap::parse_record(opcode, data)? {
                    Record::Schema { header, data } => {
                        let schema = Schema {
                            name: header.name,
                            encoding: header.encoding,
                            data: data.into_owned(),
                        };
                        self.schemas.insert(header.id, Rc::new(schema));
                    }
                    Record::Channel(channel) => self.channel(channel)?,
                    Record::Message { header, data } => {
                        let unknown =
                            mcap::McapError::UnknownChannel(header.sequence, header.channel_id);
                        let channel = self.channels.get(&header.channel_id).ok_or(unknown)?;
                        let message = RawMessage {
                            log_time: header.log_time,
                            data: &data,
                        };
                        visit(channel, message);
                    }
                    _ => {}
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn channel(&mut self, channel: mcap::records::Channel) -> Result<(), mcap::McapError> {
        let schema = if channel.schema_id == 0 {
            Rc::default()
        } else {
            self.schemas
                .get(&channel.schema_id)
                .cloned()
                .ok_or_else(|| {
                    mcap::McapError::UnknownSchema(channel.topic.clone(), channel.schema_id)
                })?
        };
        let channel = Channel {
            id: channel.id,
            topic: channel.topic,
            encoding: channel.message_encoding,
            schema,
        };
        // A channel may be repeated, but not changed: its messages would change their meaning.
        let known = self
            .channels
            .entry(channel.id)
            .or_insert_with(|| channel.clone());
        if *known == channel {
            Ok(())
        } else {
            Err(mcap::McapError::ConflictingChannels(channel.topic))
        }
    }

    fn chunk(
        &mut self,
        data: &[u8],
        visit: &mut dyn FnMut(&Channel, RawMessage<'_>),
    ) -> Result<(), mcap::McapError> {
        let mut reader = LinearReader::new_with_options(
            LinearReaderOptions::default()
                .with_skip_start_magic(true)
                .with_skip_end_magic(true)
                .with_prevalidate_chunk_crcs(true)
                .with_record_length_limit(MAX_CHUNK),
        );
        let mut header = vec![op::CHUNK];
        header.extend_from_slice(&(data.len() as u64).to_le_bytes());
        let mut rest = header.as_slice().chain(data);
        let mut first_problem = None;
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(need) => {
                    let read = rest.read(reader.insert(need))?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => {
                    if opcode != op::CHUNK
                        && let Err(problem) = self.record(opcode, data, visit)
                    {
                        first_problem.get_or_insert(problem);
                    }
                }
            }
        }
        first_problem.map_or(Ok(()), Err)
    }
}
