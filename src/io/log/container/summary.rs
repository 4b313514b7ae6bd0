//! The end of the file: data end, summary and footer; and the summary's index of chunks, held against the
//! chunks that stand in the file.
//!
//! They are read first, because they say what the rest should be. A summary counts only when its
//! records fill the space up to the footer exactly and its checksum, if it has one, agrees.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Seek};

use super::channels::Registry;
use super::record::{
    ChunkIndex, DATA_END, Fields, Identity, MAGIC, MAGIC_LENGTH, PREFIX, Records, op,
};
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
        let footer_at = magic_at.saturating_sub(FOOTER);
        let footer = source.get(footer_at, FOOTER)?.to_vec();
        let fields = footer.strip_prefix(&FOOTER_PREFIX).filter(|_| tail.magic);
        let Some(start) = fields.and_then(|fields| Fields(fields).u64().ok()) else {
            return Ok(tail);
        };
        tail.footer = true;
        let mut begin = if start == 0 { footer_at } else { start };
        if start > 0 {
            tail.summary = match Summary::between(source, start, footer_at, &footer)? {
                Some(summary) => Some(summary),
                None => Summary::find(source, footer_at, &footer)?.map(|(found, summary)| {
                    begin = found;
                    let shift = found.wrapping_sub(start) as i64;
                    Summary { shift, ..summary }
                }),
            };
            tail.damaged = tail.summary.is_none();
        }
        let data_end = begin.checked_sub(DATA_END);
        if let Some(at) = data_end
            && source.peek(at)? == Some(DATA_END_PREFIX)
        {
            tail.data_end = Some(at);
        }
        tail.limit = tail.data_end.or((!tail.damaged).then_some(begin));
        Ok(tail)
    }
}

impl Summary {
    /// The summary, if it begins at `start`.
    fn between<R: Read + Seek>(
        source: &mut Source<R>,
        start: u64,
        footer_at: u64,
        footer: &[u8],
    ) -> io::Result<Option<Self>> {
        let length = footer_at.checked_sub(start);
        let Some(length) = length.filter(|length| *length <= LARGEST_SUMMARY) else {
            return Ok(None);
        };
        Ok(Self::parse(source.get(start, length)?, footer))
    }

    /// The nearest data end before the footer that a summary follows: the file was damaged by bytes
    /// that came in or went away, and the footer's offset is no longer right.
    fn find<R: Read + Seek>(
        source: &mut Source<R>,
        footer_at: u64,
        footer: &[u8],
    ) -> io::Result<Option<(u64, Self)>> {
        /// Each costs a pass over the rest; nothing honest needs more.
        const TRIES: usize = 16;
        let from = footer_at.saturating_sub(LARGEST_SUMMARY);
        let bytes = source.get(from, footer_at - from)?;
        let ends = (bytes.windows(DATA_END_PREFIX.len()).enumerate().rev())
            .filter(|(_, window)| *window == DATA_END_PREFIX);
        let found = ends.take(TRIES).find_map(|(at, _)| {
            let start = at.saturating_add(DATA_END as usize);
            let summary = Self::parse(bytes.get(start..)?, footer)?;
            Some((from + start as u64, summary))
        });
        Ok(found)
    }

    /// Held against the checksum that ends the footer, which covers all before it.
    fn parse(section: &[u8], footer: &[u8]) -> Option<Self> {
        let mut summary = Self::default();
        let (covered, checksum) = footer.split_last_chunk()?;
        let checksum = u32::from_le_bytes(*checksum);
        if checksum != 0 {
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(section);
            hasher.update(covered);
            summary.verified = hasher.finalize() == checksum;
            if !summary.verified {
                return None;
            }
        }
        let mut records = Records(section);
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
        records.0.is_empty().then_some(summary)
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

/// The index; entries leave it as their chunks are met.
#[derive(Debug, Default)]
pub struct Index {
    /// Entries by the places where their chunks really are, as the chunks' headers say.
    standing: BTreeMap<u64, ChunkIndex>,
    /// Entries whose chunks are not where they should be: the file or the index is damaged.
    astray: BTreeSet<ChunkIndex>,
    /// The same, by the places where they should be.
    astray_at: BTreeMap<u64, ChunkIndex>,
    /// From here on nothing belongs to the log that a checksum vouches for the summary of; `None` where
    /// none does, or no chunk is where it says.
    binding_from: Option<u64>,
    /// Whether any chunk was where it says, be it as long as it may.
    is_credible: bool,
}

/// How a chunk and the index agree.
#[derive(Debug, PartialEq, Eq)]
pub enum Listing {
    /// The index has it, or does not bind.
    Listed,
    /// The index has another chunk at its place.
    Other(ChunkIndex),
    /// The index has no such chunk.
    Unlisted,
}

impl Index {
    pub fn find<R: Read + Seek>(source: &mut Source<R>, summary: &Summary) -> io::Result<Self> {
        let mut index = Self::default();
        // Of logs that were put one behind the other it is the last one's, and so it is where a log lies
        // in another one.
        let shift = u64::try_from(summary.shift).unwrap_or_default();
        let mut begin = if source.peek(shift)? == Some(MAGIC) {
            shift
        } else {
            0
        };
        if begin == 0 && shift > 0 {
            let mut stands = false;
            for entry in &summary.chunks {
                stands |= chunk_at(source, entry.offset)? == Some(entry.chunk);
            }
            begin = if stands { 0 } else { shift };
        }
        for entry in &summary.chunks {
            let moved = entry.offset.saturating_add_signed(summary.shift);
            let mut place = None;
            for offset in [moved, entry.offset] {
                if let Some(chunk) = chunk_at(source, offset)?.filter(|_| offset >= begin) {
                    place = (chunk == entry.chunk).then_some(offset).or(place);
                    let length = entry.chunk.length;
                    index.is_credible |= entry.chunk == Identity { length, ..chunk };
                }
            }
            match place {
                Some(place) => drop(index.standing.insert(place, *entry)),
                None => {
                    index.astray.insert(*entry);
                    index.astray_at.insert(entry.offset, *entry);
                }
            }
        }
        let binds = summary.verified && (index.is_credible || summary.chunk_count == Some(0));
        index.binding_from = binds.then_some(begin);
        Ok(index)
    }

    /// Where the log begins that the index is of.
    pub fn begin(&self) -> u64 {
        self.binding_from.unwrap_or_default()
    }

    /// Whether it says of a place that no chunk belongs there but those that it lists.
    pub fn binds(&self, at: u64) -> bool {
        self.binding_from.is_some_and(|from| at >= from)
    }

    /// Whether it has any chunk left.
    pub fn is_empty(&self) -> bool {
        self.standing.is_empty() && self.astray.is_empty()
    }

    /// The first place from `at` on where one of its chunks stands.
    pub fn next(&self, at: u64) -> Option<u64> {
        self.standing.range(at..).next().map(|(place, _)| *place)
    }

    /// Whether it lists a chunk, as far as the chunk's header tells.
    pub fn lists(&self, at: u64, chunk: Identity) -> bool {
        self.standing.contains_key(&at) || self.stray(chunk).is_some()
    }

    /// The entry of the chunk that begins, or should begin, there.
    pub fn at(&self, at: u64) -> Option<ChunkIndex> {
        let entry = self.standing.get(&at).or_else(|| self.astray_at.get(&at));
        entry.copied()
    }

    /// Takes the entry of the chunk that begins, or should begin, there.
    pub fn lose(&mut self, at: u64) -> Option<ChunkIndex> {
        let entry = self.standing.remove(&at);
        entry.or_else(|| {
            let entry = self.astray_at.remove(&at)?;
            self.astray.remove(&entry).then_some(entry)
        })
    }

    /// Takes the entry of a whole chunk, which is known by the log times of its messages, its size and its
    /// length.
    pub fn meet(&mut self, at: u64, chunk: Identity) -> Listing {
        let here = self.at(at);
        if here.is_some_and(|entry| entry.chunk == chunk) {
            self.lose(at);
            return Listing::Listed;
        }
        if let Some(entry) = self.stray(chunk) {
            self.astray.remove(&entry);
            if self.astray_at.get(&entry.offset) == Some(&entry) {
                self.astray_at.remove(&entry.offset);
            }
            return Listing::Listed;
        }
        match here {
            Some(entry) => {
                self.lose(at);
                Listing::Other(entry)
            }
            None if self.binds(at) => Listing::Unlisted,
            None => Listing::Listed,
        }
    }

    /// Takes all entries whose chunks were not met.
    pub fn rest(&mut self) -> impl Iterator<Item = ChunkIndex> + use<> {
        let is_credible = self.is_credible;
        let standing = std::mem::take(&mut self.standing).into_values();
        let astray = std::mem::take(&mut self.astray);
        standing.chain(astray).filter(move |_| is_credible)
    }

    /// An entry of this chunk that is wrong about the place.
    fn stray(&self, chunk: Identity) -> Option<ChunkIndex> {
        let [first, last] = [0, u64::MAX].map(|offset| ChunkIndex { chunk, offset });
        self.astray.range(first..=last).next().copied()
    }
}

/// The chunk that begins there, as its header has it.
fn chunk_at<R: Read + Seek>(source: &mut Source<R>, at: u64) -> io::Result<Option<Identity>> {
    let bytes = source.peek::<{ PREFIX as usize + 3 * 8 }>(at)?;
    let identity = |bytes: [u8; PREFIX as usize + 3 * 8]| {
        let mut fields = Fields(&bytes);
        let opcode = fields.u8().ok()?;
        let length = fields.u64().ok()?.saturating_add(PREFIX);
        let span = (fields.u64().ok()?, fields.u64().ok()?);
        (opcode == op::CHUNK).then_some(Identity {
            span,
            uncompressed: fields.u64().ok()?,
            length,
        })
    };
    Ok(bytes.and_then(identity))
}
