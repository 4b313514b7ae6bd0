//! The records of an MCAP file, field by field.
//!
//! Only what is used is read, and every field is checked against the bytes that are there.

use std::rc::Rc;

/// Stands at both ends of a file.
pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Bytes of [`MAGIC`].
pub const MAGIC_LENGTH: u64 = MAGIC.len() as u64;

pub mod op {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const ATTACHMENT: u8 = 0x09;
    pub const STATISTICS: u8 = 0x0B;
    pub const METADATA: u8 = 0x0C;
    pub const DATA_END: u8 = 0x0F;
    /// From here on opcodes belong to applications.
    pub const PRIVATE: u8 = 0x80;
}

/// Opcode and length in front of every record, bytes.
pub const PREFIX: u64 = 9;
/// Bytes of a data end record, which holds a checksum.
pub const DATA_END: u64 = PREFIX + 4;
/// Bytes of a message's body before its content.
pub const MESSAGE_HEADER: u64 = 22;
/// Bytes of a message index's body before its entries: the channel, and the bytes of all entries.
pub const INDEX_HEADER: u64 = 6;
/// Bytes of an entry of a message index: log time, and place in the chunk.
pub const INDEX_ENTRY: u64 = 16;

/// A field that its record is too short for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a field runs beyond its record")]
pub struct Malformed;

/// The fields of a record, taken from the front.
#[derive(Debug, Clone, Copy)]
pub struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let (head, rest) = self.0.split_at_checked(count).ok_or(Malformed)?;
        self.0 = rest;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let (head, rest) = self.0.split_first_chunk::<N>().ok_or(Malformed)?;
        self.0 = rest;
        Ok(*head)
    }

    pub fn u8(&mut self) -> Result<u8, Malformed> {
        self.array().map(u8::from_le_bytes)
    }

    pub fn u16(&mut self) -> Result<u16, Malformed> {
        self.array().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes with their count, in four bytes, before them.
    pub fn counted(&mut self) -> Result<&'a [u8], Malformed> {
        let count = self.u32()?;
        self.take(usize::try_from(count).map_err(|_| Malformed)?)
    }

    /// Text; replaces what is not UTF-8 in it.
    pub fn text(&mut self) -> Result<String, Malformed> {
        self.counted()
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}

/// The largest chunk or message, compressed or not, that is read: bytes.
pub const MAX_CHUNK: u64 = 128 << 20;

/// One channel of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// Its number in the file.
    pub id: u16,
    pub topic: String,
    /// How its messages are encoded: `cdr`, `json`, ...
    pub encoding: String,
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
    pub data: &'a [u8],
}

/// A schema and its number.
pub fn schema(body: &[u8]) -> Result<(u16, Schema), Malformed> {
    let mut fields = Fields(body);
    let id = fields.u16()?;
    let schema = Schema {
        name: fields.text()?,
        encoding: fields.text()?,
        data: fields.counted()?.to_vec(),
    };
    Ok((id, schema))
}

/// A channel, still without its schema, and the number of that.
pub fn channel(body: &[u8]) -> Result<(u16, Channel), Malformed> {
    let mut fields = Fields(body);
    let id = fields.u16()?;
    let schema_id = fields.u16()?;
    let channel = Channel {
        id,
        topic: fields.text()?,
        encoding: fields.text()?,
        schema: Default::default(),
    };
    fields.counted()?; // metadata
    Ok((schema_id, channel))
}

/// A message: its channel, its log time, its bytes.
pub fn message(body: &[u8]) -> Result<(u16, u64, &[u8]), Malformed> {
    let mut fields = Fields(body);
    let channel = fields.u16()?;
    fields.u32()?; // sequence
    let log_time = fields.u64()?;
    fields.u64()?; // publish time
    Ok((channel, log_time, fields.0))
}

/// The part of a chunk before its records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChunkHeader {
    /// Log times of its first and last message.
    pub span: (u64, u64),
    /// Bytes of its records when decompressed.
    pub uncompressed: u64,
    /// Of the uncompressed records; 0 where the writer computed none.
    pub checksum: u32,
    /// `zstd`, `lz4`, or empty.
    pub compression: String,
    /// Bytes of this header, in the record's body.
    pub length: u64,
    /// Bytes of the records as they lie in the file.
    pub compressed: u64,
}

impl ChunkHeader {
    /// So many bytes of a chunk's body hold its header, unless its compression has an absurd name.
    pub const ROOM: u64 = 40 + 64;

    pub fn parse(body: &[u8]) -> Result<Self, Malformed> {
        let mut fields = Fields(body);
        let header = Self {
            span: (fields.u64()?, fields.u64()?),
            uncompressed: fields.u64()?,
            checksum: fields.u32()?,
            compression: fields.text()?,
            length: 0,
            compressed: fields.u64()?,
        };
        let length = body.len().saturating_sub(fields.0.len()) as u64;
        Ok(Self { length, ..header })
    }

    /// What it says of the chunk.
    pub fn identity(&self) -> Identity {
        let length = PREFIX + self.length;
        Identity {
            span: self.span,
            uncompressed: self.uncompressed,
            length: length.saturating_add(self.compressed),
        }
    }
}

/// What tells one chunk from another, in its own header and in the summary's index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Identity {
    /// Log times of its first and last message.
    pub span: (u64, u64),
    /// Bytes of its records when decompressed.
    pub uncompressed: u64,
    /// Bytes of its whole record.
    pub length: u64,
}

/// An entry of the summary's index: a chunk. Ordered by the chunk itself, and then by its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ChunkIndex {
    pub chunk: Identity,
    /// Where its record begins.
    pub offset: u64,
}

impl ChunkIndex {
    pub fn parse(body: &[u8]) -> Result<Self, Malformed> {
        let mut fields = Fields(body);
        let span = (fields.u64()?, fields.u64()?);
        let (offset, length) = (fields.u64()?, fields.u64()?);
        fields.counted()?; // where the message indexes are
        fields.u64()?; // and how long
        fields.counted()?; // compression
        fields.u64()?; // compressed size
        let uncompressed = fields.u64()?;
        let chunk = Identity {
            span,
            uncompressed,
            length,
        };
        Ok(Self { chunk, offset })
    }
}

/// One record inside a chunk or summary.
#[derive(Debug, Clone, Copy)]
pub struct Inner<'a> {
    pub opcode: u8,
    pub body: &'a [u8],
}

/// The records in a piece of memory, until one does not fit: what is not yet passed.
#[derive(Debug, Clone, Copy)]
pub struct Records<'a>(pub &'a [u8]);

impl<'a> Iterator for Records<'a> {
    type Item = Inner<'a>;

    /// The next record; `None` at the end and for one that does not fit, which stays.
    fn next(&mut self) -> Option<Inner<'a>> {
        let mut fields = Fields(self.0);
        // Zeros are what a file is filled up with.
        let opcode = fields.u8().ok().filter(|opcode| *opcode != 0)?;
        let length = usize::try_from(fields.u64().ok()?).ok()?;
        let body = fields.take(length).ok()?;
        self.0 = fields.0;
        Some(Inner { opcode, body })
    }
}
