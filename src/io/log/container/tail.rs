//! The end of the file: data end, summary and footer.
//!
//! They are read first, because they say what the rest should be. A summary counts only when its
//! records fill the space up to the footer exactly and its checksum, if it has one, agrees.

use std::io::{self, Read, Seek};

use super::channels::Registry;
use super::record::{ChunkIndex, DATA_END, Fields, MAGIC, MAGIC_LENGTH, PREFIX, Records, op};
use super::source::Source;

/// Bytes of a footer record: offsets of summary and summary offsets, and a checksum.
const FOOTER: u64 = PREFIX + 20;
/// The footer's opcode and length.
const FOOTER_PREFIX: [u8; 9] = [op::FOOTER, 20, 0, 0, 0, 0, 0, 0, 0];
/// The data end's opcode and length.
const DATA_END_PREFIX: [u8; 9] = [op::DATA_END, 4, 0, 0, 0, 0, 0, 0, 0];
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
    /// The index: the chunks of the file.
    pub chunks: Vec<ChunkIndex>,
    /// How many chunks there should be.
    pub chunk_count: Option<u32>,
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
    pub fn read<R: Read + Seek>(source: &mut Source<R>) -> io::Result<Self> {
        let mut tail = Self::default();
        let Some(magic_at) = source.length().checked_sub(MAGIC_LENGTH) else {
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
        let found = end.find(source)?;
        let begin = found.as_ref().map_or(start, |(found, _)| *found);
        tail.data_end = data_end_before(source, begin)?;
        tail.limit = tail.data_end;
        tail.damaged = found.is_none();
        tail.summary = found.map(|(found, summary)| Summary {
            shift: found.wrapping_sub(start) as i64,
            ..summary
        });
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
        /// Each costs a pass over the rest; nothing honest needs more.
        const TRIES: usize = 16;
        let from = self.footer_at.saturating_sub(LARGEST_SUMMARY);
        let bytes = source.get(from, self.footer_at - from)?;
        let ends = (bytes.windows(DATA_END_PREFIX.len()).enumerate().rev())
            .filter(|(_, window)| *window == DATA_END_PREFIX);
        for (at, _) in ends.take(TRIES) {
            let start = at.saturating_add(DATA_END as usize);
            if let Some(summary) = bytes.get(start..).and_then(|section| self.parse(section)) {
                return Ok(Some((from + start as u64, summary)));
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
                    fields.take(2 + 3 * 4).ok()?; // numbers of schemas, channels and so on
                    summary.chunk_count = Some(fields.u32().ok()?);
                    summary.messages = Some(messages);
                    summary.start = fields.u64().ok().filter(|_| messages > 0);
                }
                // A definition that does not hold together is as good as none.
                op::SCHEMA | op::CHANNEL => drop(summary.registry.define(record, None)),
                op::HEADER | op::FOOTER | op::MESSAGE | op::CHUNK | op::DATA_END => return None,
                _ => {}
            }
        }
        records.rest().is_empty().then_some(summary)
    }
}

/// Whether the checksum of the data section, which begins with the file or a log in it, agrees; so
/// does one that was not computed.
///
/// Writers differ in whether it covers the magic bytes and the header too. Any of them will do.
pub fn data_agrees<R: Read + Seek>(
    source: &mut Source<R>,
    begin: u64,
    data_end: u64,
) -> io::Result<bool> {
    let Some(bytes) = source.peek::<4>(data_end.saturating_add(PREFIX))? else {
        return Ok(true);
    };
    let expected = u32::from_le_bytes(bytes);
    if expected == 0 {
        return Ok(true);
    }
    let magic = begin + MAGIC_LENGTH;
    let length = source.peek::<8>(magic + 1)?.map_or(0, u64::from_le_bytes);
    let header = (magic + PREFIX)
        .saturating_add(length)
        .min(data_end)
        .max(magic);
    let mut from_start = source.checksum(begin, magic)?;
    let mut from_magic = source.checksum(magic, header)?;
    let data = source.checksum(header, data_end)?;
    from_magic.combine(&data);
    from_start.combine(&from_magic);
    Ok([from_start, from_magic, data]
        .into_iter()
        .any(|hasher| hasher.finalize() == expected))
}
