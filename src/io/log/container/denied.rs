//! Records that the index speaks against: it has another one where they begin, or a chunk within them.
//! Either they are damaged or the index is wrong, and some records prove which.

use std::io::{Read, Seek};

use super::OpenError;
use super::extent;
use super::record::{ChunkHeader, PREFIX, op};
use super::scan::Prefix;
use super::walker::Walker;

impl<R: Read + Seek> Walker<'_, R> {
    /// Whether the index speaks against a record, and the record does not prove it wrong.
    pub(super) fn is_denied(&mut self, at: u64, prefix: Prefix) -> Result<bool, OpenError> {
        let end = prefix.end(at);
        let runs_over_chunk = self.places.after(at).is_some_and(|next| next.offset < end);
        let is_another = self
            .places
            .at(at)
            .is_some_and(|index| prefix.opcode != op::CHUNK || index.end() != end);
        Ok((runs_over_chunk || is_another) && !self.proves_itself(at, prefix)?)
    }

    /// Whether a record shows by itself that it is whole: a chunk by its checksum, others by
    /// their fields and what follows them.
    fn proves_itself(&mut self, at: u64, prefix: Prefix) -> Result<bool, OpenError> {
        let end = prefix.end(at);
        if end > self.limit(at) {
            return Ok(false);
        }
        let body = at + PREFIX;
        match prefix.opcode {
            op::CHUNK => {
                let head = ChunkHeader::ROOM.min(prefix.length);
                let header = ChunkHeader::parse(self.source.get(body, head)?);
                let Some(header) = header.ok().filter(|header| header.fills(prefix.length)) else {
                    return Ok(false);
                };
                let from = body + header.length;
                Ok(header.checksum != 0
                    && self
                        .unpacker
                        .records(&mut self.source, from, &header)?
                        .is_ok())
            }
            op::MESSAGE_INDEX => {
                const HEAD: u64 = 6; // the channel, and the bytes of all entries
                let entries = self.source.peek::<4>(body + 2)?.map(u32::from_le_bytes);
                let fills = prefix.is_message_index()
                    && entries.map(|entries| HEAD + u64::from(entries)) == Some(prefix.length);
                Ok(fills && self.could_begin(end)?)
            }
            opcode => {
                let fields = extent::of_fields(&mut self.source, opcode, body, prefix.length)?;
                Ok(fields == Some(prefix.length) && self.could_begin(end)?)
            }
        }
    }
}
