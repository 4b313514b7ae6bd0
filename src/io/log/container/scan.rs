//! Where reading can go on behind damage, when no index tells.

use std::io::{self, Read, Seek};

use super::MAX_CHUNK;
use super::extent;
use super::record::{self, ChunkHeader, PREFIX, op};
use super::registry::Registry;
use super::source::Source;
use super::tail::{DATA_END, DATA_END_PREFIX};

/// Bytes looked through at a time, at most and at first.
const STRIDE: u64 = 64 << 10;
const FIRST_STRIDE: u64 = 256;
/// Records in a row that are taken for more than chance.
const CHAIN: usize = 3;
/// A definition longer than this is taken for chance: bytes.
pub const LARGEST_DEFINITION: u64 = 1 << 20;

/// What is looked for.
#[derive(Debug, Clone, Copy)]
pub struct Sought<'a> {
    /// Whether the end of the data section may be where it seems to be.
    pub data_end: bool,
    /// Messages outside of chunks, by the channels known, from the data and from the summary; not
    /// looked for in a file with chunks, since a damaged chunk may hold what looks like them.
    pub messages: Option<[&'a Registry; 2]>,
}

/// The first place in `from..to` where a record plainly begins.
pub fn next_record<R: Read + Seek>(
    source: &mut Source<R>,
    from: u64,
    to: u64,
    sought: Sought<'_>,
) -> io::Result<Option<u64>> {
    let mut at = from;
    // The next record is often near: what is read for nothing when it is should be little.
    let mut stride = FIRST_STRIDE;
    while at < to {
        let bytes = source.get(at, stride.min(to - at) + PREFIX - 1)?;
        let candidates: Vec<u64> = bytes
            .windows(PREFIX as usize)
            .enumerate()
            .filter(|(_, window)| could_be(window))
            .map(|(index, _)| at + index as u64)
            .collect();
        for candidate in candidates {
            if begins(source, candidate, sought)? {
                return Ok(Some(candidate));
            }
        }
        at = at.saturating_add(stride);
        stride = (2 * stride).min(STRIDE);
    }
    Ok(None)
}

/// A cheap look at opcode and length: no record that matters is longer than 2^40 bytes.
fn could_be(prefix: &[u8]) -> bool {
    matches!(
        prefix,
        [
            op::SCHEMA..=op::CHUNK | op::DATA_END,
            _,
            _,
            _,
            _,
            _,
            0,
            0,
            0
        ]
    )
}

/// Whether a record plainly begins there.
pub fn begins<R: Read + Seek>(
    source: &mut Source<R>,
    at: u64,
    sought: Sought<'_>,
) -> io::Result<bool> {
    let Some(prefix) = prefix(source, at)? else {
        return Ok(false);
    };
    match prefix.opcode {
        op::CHUNK => chunk(source, at, prefix.length),
        op::DATA_END if sought.data_end => is_data_end(source, at),
        op::SCHEMA | op::CHANNEL | op::MESSAGE => match sought.messages {
            Some(registries) => chain(source, at, Some(registries)),
            None => Ok(false),
        },
        _ => Ok(false),
    }
}

/// Opcode and length of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Prefix {
    /// Its kind.
    pub opcode: u8,
    /// Bytes of its body.
    pub length: u64,
}

impl Prefix {
    /// The first byte behind the record, which may be behind the file's end.
    pub fn end(self, at: u64) -> u64 {
        at.saturating_add(PREFIX).saturating_add(self.length)
    }

    /// Whether it is a message index by its length too: a channel, and any number of entries.
    pub fn is_message_index(self) -> bool {
        const ENTRY: u64 = 16;
        self.opcode == op::MESSAGE_INDEX && self.length % ENTRY == 6
    }

    /// Whether there can be such a record.
    pub fn is_possible(self) -> bool {
        matches!(self.opcode, op::HEADER..=op::DATA_END | op::PRIVATE..)
    }
}

/// The opcode and length at some place; `None` where the file ends.
pub fn prefix<R: Read + Seek>(source: &mut Source<R>, at: u64) -> io::Result<Option<Prefix>> {
    let bytes = source.peek::<{ PREFIX as usize }>(at)?;
    Ok(bytes.map(|[opcode, length @ ..]| Prefix {
        opcode,
        length: u64::from_le_bytes(length),
    }))
}

/// Whether a chunk begins there. It may run beyond the file's end: the last one was cut off.
fn chunk<R: Read + Seek>(source: &mut Source<R>, at: u64, length: u64) -> io::Result<bool> {
    let header = source.get(at + PREFIX, ChunkHeader::ROOM.min(length))?;
    Ok(ChunkHeader::parse(header).is_ok_and(|header| {
        header.fills(length)
            && header.span.0 <= header.span.1
            && header.uncompressed.max(header.compressed) <= MAX_CHUNK
            && matches!(header.compression.as_str(), "" | "zstd" | "lz4")
    }))
}

/// Whether the data section ends there: a record of a summary follows, or the footer.
pub fn is_data_end<R: Read + Seek>(source: &mut Source<R>, at: u64) -> io::Result<bool> {
    if source.peek(at)? != Some(DATA_END_PREFIX) {
        return Ok(false);
    }
    let behind = at.saturating_add(DATA_END);
    let next = prefix(source, behind)?;
    let length = source.length();
    Ok(next.map_or(behind == length, |next| {
        let fits = next.end(behind) <= length;
        fits && (matches!(next.opcode, op::SCHEMA | op::CHANNEL | op::PRIVATE..)
            || (op::CHUNK_INDEX..=op::SUMMARY_OFFSET).contains(&next.opcode)
            || (next.opcode, next.length) == (op::FOOTER, 20))
    }))
}

/// Whether several messages and definitions stand there in a row. A message may begin it whose channel
/// is known, or any where none need be; further ones may be of channels whose definition the damage took,
/// or that follow here.
pub fn chain<R: Read + Seek>(
    source: &mut Source<R>,
    mut at: u64,
    registries: Option<[&Registry; 2]>,
) -> io::Result<bool> {
    for place in 0..CHAIN {
        if at == source.length() {
            return Ok(true);
        }
        let Some(next) = prefix(source, at)? else {
            return Ok(false);
        };
        let end = next.end(at);
        let body = at.saturating_add(PREFIX);
        let fits = end <= source.length();
        let plausible = fits
            && match next.opcode {
                op::MESSAGE => {
                    const HEADER: usize = 22;
                    let header = source.peek::<HEADER>(body)?.unwrap_or_default();
                    next.length >= HEADER as u64
                        && record::message(&header).is_ok_and(|(id, ..)| {
                            place > 0
                                || registries.is_none_or(|known| known.iter().any(|r| r.knows(id)))
                        })
                }
                op::SCHEMA | op::CHANNEL => {
                    next.length <= LARGEST_DEFINITION
                        && extent::of_fields(source, next.opcode, body, next.length)?.is_some()
                }
                op::DATA_END => return is_data_end(source, at),
                _ => false,
            };
        if !plausible {
            return Ok(false);
        }
        at = end;
    }
    Ok(true)
}
