//! The records of an MCAP file, field by field.
//!
//! Only what is used is read, and every field is checked against the bytes that are there.

use super::fields::{Fields, Malformed};
use super::{Channel, Schema};

/// Opcodes.
pub mod op {
    #![allow(missing_docs, reason = "they are the names of the format")]
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const ATTACHMENT: u8 = 0x09;
    pub const ATTACHMENT_INDEX: u8 = 0x0A;
    pub const STATISTICS: u8 = 0x0B;
    pub const METADATA: u8 = 0x0C;
    pub const METADATA_INDEX: u8 = 0x0D;
    pub const SUMMARY_OFFSET: u8 = 0x0E;
    pub const DATA_END: u8 = 0x0F;
    /// From here on opcodes belong to applications.
    pub const PRIVATE: u8 = 0x80;
}

/// Opcode and length in front of every record, bytes.
pub const PREFIX: u64 = 9;

/// A schema and its number.
///
/// # Errors
/// A record that is too short.
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
///
/// # Errors
/// A record that is too short.
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
///
/// # Errors
/// A record that is too short.
pub fn message(body: &[u8]) -> Result<(u16, u64, &[u8]), Malformed> {
    let mut fields = Fields(body);
    let channel = fields.u16()?;
    fields.u32()?; // sequence
    let log_time = fields.u64()?;
    fields.u64()?; // publish time
    Ok((channel, log_time, fields.0))
}

/// What stands before the records of a chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChunkHeader {
    /// Log times of its first and last message.
    pub span: (u64, u64),
    /// Bytes of its records when decompressed.
    pub uncompressed: u64,
    /// Of the uncompressed records; 0 where it was not computed.
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

    /// Reads the header at the front of a chunk's body.
    ///
    /// # Errors
    /// A body that is too short.
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

    /// Whether the header fills a body of so many bytes, as it does in every file that was written
    /// by the book.
    pub fn fills(&self, body: u64) -> bool {
        self.length.checked_add(self.compressed) == Some(body)
    }
}

/// What the summary says of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChunkIndex {
    /// Log times of its first and last message.
    pub span: (u64, u64),
    /// Where the chunk's record begins.
    pub offset: u64,
    /// Bytes of the whole record.
    pub length: u64,
}

impl ChunkIndex {
    /// Reads a chunk index record.
    ///
    /// # Errors
    /// A body that is too short.
    pub fn parse(body: &[u8]) -> Result<Self, Malformed> {
        let mut fields = Fields(body);
        Ok(Self {
            span: (fields.u64()?, fields.u64()?),
            offset: fields.u64()?,
            length: fields.u64()?,
        })
    }

    /// The first byte behind the chunk.
    pub fn end(&self) -> u64 {
        self.offset.saturating_add(self.length)
    }
}

/// How many messages a message index lists.
///
/// # Errors
/// A body that is too short.
pub fn indexed_messages(body: &[u8]) -> Result<u64, Malformed> {
    const ENTRY: u32 = 16;
    let mut fields = Fields(body);
    fields.u16()?; // channel
    Ok((fields.u32()? / ENTRY).into())
}

/// One record inside a chunk or summary.
#[derive(Debug, Clone, Copy)]
pub struct Inner<'a> {
    /// Its kind.
    pub opcode: u8,
    /// Its fields.
    pub body: &'a [u8],
}

/// The records in a piece of memory, until one does not fit.
#[derive(Debug, Clone, Copy)]
pub struct Records<'a> {
    rest: &'a [u8],
}

impl<'a> Records<'a> {
    /// The records in `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Bytes not yet passed.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    fn split(&self) -> Result<(Inner<'a>, &'a [u8]), Malformed> {
        let mut fields = Fields(self.rest);
        let opcode = fields.u8()?;
        let length = fields.u64()?;
        let body = fields.take(usize::try_from(length).map_err(|_| Malformed)?)?;
        if opcode == 0 {
            return Err(Malformed); // no opcode; zeros are what a file is filled up with
        }
        Ok((Inner { opcode, body }, fields.0))
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Inner<'a>;

    /// The next record; `None` at the end and for one that does not fit, which stays in
    /// [`Records::rest`].
    fn next(&mut self) -> Option<Inner<'a>> {
        let (record, rest) = self.split().ok()?;
        self.rest = rest;
        Some(record)
    }
}
