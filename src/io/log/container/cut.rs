//! What follows the end of a file that ends too early.

use std::io::{Read, Seek};

use super::loss::{Loss, Why};
use super::record::{ChunkHeader, PREFIX, op};
use super::recover::A_CHUNK;
use super::scan::{self, Prefix, Sought, next_record};
use super::walker::{Next, Walker};
use super::{MAX_CHUNK, OpenError};

impl<R: Read + Seek> Walker<'_, R> {
    /// A record that the file ends within, if its length is right.
    pub(super) fn cut_off(&mut self, at: u64, prefix: Prefix) -> Next {
        let length = self.source.length();
        if prefix.opcode != op::CHUNK {
            return self.go_on(at, None);
        }
        let head = self.source.get(at + PREFIX, ChunkHeader::ROOM)?;
        let header = ChunkHeader::parse(head).ok();
        let Some(header) = header.filter(|header| header.fills(prefix.length)) else {
            return self.go_on(at, None);
        };
        let sought = Sought {
            data_end: true,
            ..A_CHUNK
        };
        if next_record(&mut self.source, at + 1, length, sought)?.is_some() {
            return self.go_on(at, None); // the file does go on
        }
        self.chunked = true;
        let before = self.used.messages;
        let from = at + PREFIX + header.length;
        let present = ChunkHeader {
            compressed: length.saturating_sub(from),
            ..header
        };
        let why = match self.unpacker.beginning(&mut self.source, from, &present)? {
            Err(why) => why,
            Ok(records) => {
                self.used.records(records, true);
                match self.used.messages - before {
                    0 => Why::Cut,
                    used => Why::CutOff { used },
                }
            }
        };
        self.losses.add(Loss {
            span: Some(present.span),
            ..Loss::new(at, length - at, "the last chunk", why)
        });
        Ok(Some(length))
    }

    /// What the file ends within.
    pub(super) fn cut_kind(&mut self, at: u64) -> Result<&'static str, OpenError> {
        let prefix = scan::prefix(&mut self.source, at)?;
        Ok(match prefix.map(|prefix| prefix.opcode) {
            Some(op::CHUNK) => "the last chunk",
            Some(op::MESSAGE) => "the last message",
            _ => "a record",
        })
    }

    /// Whether a record plainly begins there and the file ends within it.
    pub(super) fn is_cut(&mut self, at: u64) -> Result<bool, OpenError> {
        let length = self.source.length();
        let prefix = scan::prefix(&mut self.source, at)?;
        Ok(!self.tail.magic
            && prefix.is_none_or(|prefix| {
                prefix.is_possible() && prefix.length <= MAX_CHUNK && prefix.end(at) > length
            }))
    }
}
