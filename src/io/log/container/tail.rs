//! The end of the file: footer and summary.
//!
//! They are read first, because they say what the rest should be. A summary counts only when its
//! records fill the space up to the footer exactly and its checksum, if it has one, agrees.

use std::io::{self, Read, Seek};

use super::MAGIC;
use super::fields::Fields;
use super::record::{self, ChunkIndex, PREFIX, Records, op};
use super::registry::Registry;
use super::source::Source;

/// Bytes of a footer record: offsets of summary and summary offsets, and a checksum.
const FOOTER: u64 = PREFIX + 20;
/// Bytes of a data end record: a checksum.
pub const DATA_END: u64 = PREFIX + 4;
/// The footer's opcode and length.
const FOOTER_PREFIX: [u8; 9] = [op::FOOTER, 20, 0, 0, 0, 0, 0, 0, 0];
/// The data end's opcode and length.
pub const DATA_END_PREFIX: [u8; 9] = [op::DATA_END, 4, 0, 0, 0, 0, 0, 0, 0];
/// A summary is looked for, and read, up to this size: bytes.
const LARGEST_SUMMARY: u64 = 32 << 20;

/// What the end of the file says.
#[derive(Debug, Default)]
pub struct Tail {
    /// Whether a footer and the magic bytes end the file.
    pub footer: bool,
    /// Whether the magic bytes end the file.
    pub magic: bool,
    /// Where the data section's end record is.
    pub data_end: Option<u64>,
    /// Where the data section ends at the latest, by what is known of the end.
    pub limit: Option<u64>,
    /// What the footer leads to.
    pub summary: Option<Summary>,
    /// Whether the footer names a summary that is damaged.
    pub damaged: bool,
}

/// The summary section.
#[derive(Debug, Default)]
pub struct Summary {
    /// Schemas and channels.
    pub registry: Registry,
    /// Every chunk of the file.
    pub chunks: Vec<ChunkIndex>,
    /// Messages in the file.
    pub messages: Option<u64>,
    /// Log time of the first.
    pub start: Option<u64>,
    /// Whether a checksum agrees.
    pub verified: bool,
    /// How much farther back, or forward, the summary stands than the footer says: bytes that were
    /// put into the file, or taken out.
    pub shift: i64,
}

impl Tail {
    /// Reads the end of the file.
    pub fn read<R: Read + Seek>(source: &mut Source<R>) -> io::Result<Self> {
        let mut tail = Self::default();
        let Some(magic_at) = source.length().checked_sub(MAGIC.len() as u64) else {
            return Ok(tail);
        };
        tail.magic = source.peek(magic_at)? == Some(MAGIC);
        let Some(footer_at) = magic_at.checked_sub(FOOTER).filter(|_| tail.magic) else {
            return Ok(tail);
        };
        let footer: Vec<u8> = source.get(footer_at, FOOTER)?.to_vec();
        let Some(mut fields) = footer.strip_prefix(&FOOTER_PREFIX).map(Fields) else {
            return Ok(tail);
        };
        let (Ok(start), Ok(_), Ok(checksum)) = (fields.u64(), fields.u64(), fields.u32()) else {
            return Ok(tail);
        };
        tail.footer = true;
        if start == 0 {
            tail.data_end = data_end_before(source, footer_at)?;
            tail.limit = tail.data_end.or(Some(footer_at));
            return Ok(tail);
        }
        // Without the checksum itself.
        let covered = footer.get(..(FOOTER - 4) as usize).unwrap_or_default();
        let end = End {
            footer_at,
            covered,
            checksum,
        };
        if let Some(summary) = end.summary(source, start)? {
            tail.data_end = data_end_before(source, start)?;
            tail.limit = tail.data_end.or(Some(start));
            tail.summary = Some(summary);
            return Ok(tail);
        }
        match end.find(source)? {
            Some((found, mut summary)) => {
                summary.shift = found.wrapping_sub(start) as i64;
                tail.data_end = data_end_before(source, found)?;
                tail.limit = tail.data_end;
                tail.summary = Some(summary);
            }
            None => {
                tail.damaged = true;
                tail.data_end = data_end_before(source, start)?;
                tail.limit = tail.data_end;
            }
        }
        Ok(tail)
    }
}

fn data_end_before<R: Read + Seek>(
    source: &mut Source<R>,
    summary: u64,
) -> io::Result<Option<u64>> {
    let Some(at) = summary.checked_sub(DATA_END) else {
        return Ok(None);
    };
    Ok((source.peek(at)? == Some(DATA_END_PREFIX)).then_some(at))
}

/// What is known of a summary before it is found.
struct End<'a> {
    footer_at: u64,
    covered: &'a [u8],
    checksum: u32,
}

impl End<'_> {
    /// The summary, if it begins at `start`.
    fn summary<R: Read + Seek>(
        &self,
        source: &mut Source<R>,
        start: u64,
    ) -> io::Result<Option<Summary>> {
        let length = self.footer_at.checked_sub(start);
        let Some(length) = length.filter(|length| *length <= LARGEST_SUMMARY) else {
            return Ok(None);
        };
        Ok(self.parse(source.get(start, length)?))
    }

    /// The nearest data end before the footer that a summary follows: the file was damaged by bytes
    /// that came in or went away, and the footer's offset is no longer right.
    fn find<R: Read + Seek>(&self, source: &mut Source<R>) -> io::Result<Option<(u64, Summary)>> {
        let from = self.footer_at.saturating_sub(LARGEST_SUMMARY);
        let bytes = source.get(from, self.footer_at - from)?;
        let mut tried = 0;
        for (at, _) in bytes
            .windows(DATA_END_PREFIX.len())
            .enumerate()
            .rev()
            .filter(|(_, window)| *window == DATA_END_PREFIX)
        {
            let start = at.saturating_add(DATA_END as usize);
            let Some(section) = bytes.get(start..) else {
                continue;
            };
            if let Some(summary) = self.parse(section) {
                return Ok(Some((from + start as u64, summary)));
            }
            tried += 1;
            if tried > 16 {
                break; // each costs a pass over the rest; nothing honest looks like this
            }
        }
        Ok(None)
    }

    fn parse(&self, section: &[u8]) -> Option<Summary> {
        let mut summary = Summary::default();
        if self.checksum != 0 {
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(section);
            hasher.update(self.covered);
            summary.verified = hasher.finalize() == self.checksum;
            if !summary.verified {
                return None;
            }
        }
        let mut records = Records::new(section);
        for record in &mut records {
            match record.opcode {
                op::CHUNK_INDEX => summary.chunks.push(ChunkIndex::parse(record.body).ok()?),
                op::STATISTICS => {
                    let mut fields = Fields(record.body);
                    let messages = fields.u64().ok()?;
                    fields.take(2 + 4 * 4).ok()?; // numbers of schemas, channels and so on
                    summary.messages = Some(messages);
                    summary.start = fields.u64().ok().filter(|_| messages > 0);
                }
                // A definition that does not hold together is as good as none.
                op::SCHEMA | op::CHANNEL => drop(summary.registry.define(record, None)),
                record::op::HEADER | op::FOOTER | op::MESSAGE | op::CHUNK | op::DATA_END => {
                    return None;
                }
                _ => {}
            }
        }
        records.rest().is_empty().then_some(summary)
    }
}
