//! What follows damage: where to go on, what was lost, and how the file ends.

use std::io::{self, Read, Seek};

use super::border::{self, CHAIN, Prefix};
use super::loss::{BEHIND, Loss, SUMMARY, Why};
use super::record::{
    self, ChunkHeader, MAGIC, MAGIC_LENGTH, MAX_CHUNK, MESSAGE_HEADER, PREFIX, op,
};
use super::walker::{Next, Walker, kind};

impl<R: Read + Seek> Walker<'_, R> {
    /// Reports a chunk that cannot be used, and goes on behind it, or within it where another record
    /// proves that it ends earlier than it says.
    pub(super) fn lose_chunk(
        &mut self,
        at: u64,
        end: u64,
        span: Option<(u64, u64)>,
        why: Why,
    ) -> Next {
        self.chunked = true;
        let next = match why {
            // Nothing speaks against the length of these.
            Why::Compression(_) | Why::TooLarge(_) | Why::Bomb(_) => end,
            _ if self.leads_on(end, CHAIN)? => end,
            _ => self.search(at + 1, end, Some(end))?.unwrap_or(end),
        };
        let (behind, messages) = if next == end {
            self.message_indexes(end, None)?
        } else {
            (next, None)
        };
        let entry = self.index.lose(at);
        self.losses.add(Loss {
            span: entry.map(|entry| entry.span).or(span),
            messages,
            ..Loss::new(at, next - at, "a chunk", why)
        });
        Ok(Some(behind))
    }

    /// Reports damage where a record should begin, and goes on at the next one that proves itself.
    pub(super) fn go_on(&mut self, at: u64, prefix: Prefix) -> Next {
        let length = self.source.length();
        if let Some(entry) = self.index.at(at) {
            let end = at.saturating_add(entry.length);
            if end <= self.limit(at) && self.leads_on(end, CHAIN)? {
                return self.lose_chunk(at, end, None, Why::NotIndexed(entry.length));
            }
        }
        // The record before may have lost bytes, and run over this one's beginning.
        let previous = std::mem::replace(&mut self.previous, at);
        if let Some(missed) = self.search(previous + 1, at, Some(at))? {
            let loss = Loss::new(previous, missed - previous, "a part", Why::Prefix);
            self.losses.add(loss);
            return Ok(Some(missed));
        }
        let is_cut = !self.tail.magic && prefix.is_possible() && prefix.end(at) > length;
        let limit = self.limit(at + 1);
        let found = self.search(at + 1, limit, None)?;
        if is_cut
            && found.is_none()
            && prefix.opcode == op::CHUNK
            && let Some(next) = self.cut_chunk(at, prefix)?
        {
            return Ok(Some(next));
        }
        let next = found.unwrap_or(limit);
        let rest = if next == length {
            "everything to the end of the file"
        } else {
            "a part"
        };
        let (what, why) = if self.source.is_zero(at, next)? {
            (rest, Why::Zeros)
        } else if is_cut && next == length && prefix.length <= MAX_CHUNK {
            let what = match prefix.opcode {
                op::CHUNK => "the last chunk",
                op::MESSAGE => "the last message",
                _ => "a record",
            };
            (what, Why::Cut)
        } else {
            let what = match prefix.opcode {
                op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA => kind(prefix.opcode),
                _ => rest,
            };
            (what, Why::Prefix)
        };
        let loss = Loss::new(at, next - at, what, why);
        self.losses.add(match self.index.lose(at) {
            Some(entry) => Loss {
                what: "a chunk",
                span: Some(entry.span),
                ..loss
            },
            None => loss,
        });
        Ok(Some(next))
    }

    /// The first record in `from..to` that proves itself. Where the records that it is looked for in say
    /// twice that they are one, `within` its end, only a record that runs over that end speaks against it.
    fn search(&mut self, from: u64, to: u64, within: Option<u64>) -> io::Result<Option<u64>> {
        let indexed = self.index.next(from).filter(|place| *place < to);
        let stop = indexed.unwrap_or(to);
        let mut at = from;
        while let Some(candidate) = border::next_candidate(&mut self.source, at, stop)? {
            if self.proves_itself(candidate, within)? {
                return Ok(Some(candidate));
            }
            at = candidate + 1;
        }
        Ok(indexed)
    }

    fn proves_itself(&mut self, at: u64, within: Option<u64>) -> io::Result<bool> {
        let Some(prefix) = border::prefix(&mut self.source, at)? else {
            return Ok(false);
        };
        match prefix.opcode {
            op::CHUNK => self.chunk_proves_itself(at, prefix, within),
            op::DATA_END if self.tail.data_end.is_none() => {
                border::ends_data(&mut self.source, at, !self.tail.magic)
            }
            // A damaged chunk may hold what looks like these.
            op::SCHEMA | op::CHANNEL if !self.chunked => self.leads_on(at, CHAIN),
            op::MESSAGE if !self.chunked => {
                let head = self
                    .source
                    .peek::<{ MESSAGE_HEADER as usize }>(at + PREFIX)?;
                let message = head.as_ref().and_then(|head| record::message(head).ok());
                let is_known = message.is_some_and(|(id, ..)| self.delivery.knows(id));
                Ok(is_known && self.leads_on(at, CHAIN)?)
            }
            _ => Ok(false),
        }
    }

    /// A chunk proves itself by the index, where there is one that binds, or else by its checksum, or
    /// without one by what follows.
    fn chunk_proves_itself(
        &mut self,
        at: u64,
        prefix: Prefix,
        within: Option<u64>,
    ) -> io::Result<bool> {
        let Some(header) = self.sound_header(at, prefix)? else {
            return Ok(false);
        };
        if self.index.binds(at) {
            return Ok(self.index.lists(at, &header));
        }
        let end = prefix.end(at);
        if within.is_some_and(|outer| end <= outer) {
            return Ok(false);
        }
        if end > self.source.length() {
            return Ok(!self.tail.magic); // the last one, which was cut off
        }
        if header.checksum == 0 {
            return self.leads_on(end, CHAIN);
        }
        let from = at + PREFIX + header.length;
        self.unpacker.proves(&mut self.source, from, &header)
    }

    /// The header of what may be a chunk, if it says the same of its length as the record does.
    fn sound_header(&mut self, at: u64, prefix: Prefix) -> io::Result<Option<ChunkHeader>> {
        let header = border::chunk_header(&mut self.source, at)?;
        Ok(header.filter(|header| {
            header.length.checked_add(header.compressed) == Some(prefix.length)
                && header.uncompressed.max(header.compressed) <= MAX_CHUNK
                && matches!(header.compression.as_str(), "" | "zstd" | "lz4")
        }))
    }

    /// Uses what there is of a chunk that the file ends within.
    fn cut_chunk(&mut self, at: u64, prefix: Prefix) -> Next {
        let Some(header) = self.sound_header(at, prefix)? else {
            return Ok(None);
        };
        self.chunked = true;
        let length = self.source.length();
        let before = self.delivery.messages;
        let from = at + PREFIX + header.length;
        let present = ChunkHeader {
            compressed: length.saturating_sub(from),
            ..header
        };
        let why = match self.unpacker.beginning(&mut self.source, from, &present)? {
            Err(why) => why,
            Ok(records) => {
                self.delivery.records(records, true);
                match self.delivery.messages - before {
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

    /// Behind the magic bytes of a second log, where the first one ends here and the second follows.
    pub(super) fn behind_joint(&mut self, at: u64) -> io::Result<Option<u64>> {
        let length = self.source.length();
        if self.joints == 0 {
            return Ok(None); // each look costs a pass over what follows
        }
        self.joints -= 1;
        let mut end = at;
        while let Some(prefix) = border::prefix(&mut self.source, end)?
            && prefix.is_possible()
            && prefix.end(end) < length
        {
            end = prefix.end(end);
            if prefix.opcode == op::FOOTER {
                for magic in [end, end + MAGIC_LENGTH] {
                    if self.source.peek(magic)? != Some(MAGIC) {
                        return Ok(None);
                    }
                }
                let next = end + 2 * MAGIC_LENGTH;
                let what = "the end of a log";
                self.losses.add(Loss::new(at, next - at, what, Why::Joined));
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    /// The file's end, before the data section's.
    pub(super) fn end(&mut self, at: u64) -> Next {
        let length = self.source.length();
        if at < length {
            let why = if self.source.is_zero(at, length)? {
                Why::Zeros
            } else {
                Why::Cut
            };
            self.losses.add(Loss::new(at, length - at, "a record", why));
        } else if !self.losses.reach(length) {
            self.losses
                .add(Loss::new(length, 0, "the end", Why::NoFooter));
        }
        Ok(None)
    }

    /// What follows the data section: the summary, and what should not be there.
    pub(super) fn close(&mut self, summary: u64) -> Next {
        let length = self.source.length();
        let rest = length.saturating_sub(summary);
        if self.tail.footer {
            if self.tail.damaged {
                self.losses
                    .add(Loss::new(summary, rest, SUMMARY, Why::Summary));
            }
            return Ok(None);
        }
        let mut at = summary;
        while let Some(prefix) = border::prefix(&mut self.source, at)?
            && prefix.is_possible()
            && prefix.end(at) <= length
        {
            at = prefix.end(at);
            if prefix.opcode == op::FOOTER && self.source.peek(at)? == Some(MAGIC) {
                let end = at + MAGIC_LENGTH;
                let why = if self.source.is_zero(end, length)? {
                    Why::Zeros
                } else {
                    Why::Trailing
                };
                self.losses.add(Loss::new(end, length - end, BEHIND, why));
                return Ok(None);
            }
        }
        let why = if self.tail.magic {
            Why::Summary
        } else {
            Why::NoFooter
        };
        self.losses.add(Loss::new(summary, rest, SUMMARY, why));
        Ok(None)
    }
}
