//! The summary's index of chunks, held against the chunks that stand in the file.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Seek};

use super::record::{ChunkHeader, ChunkIndex, Fields, MAGIC, Malformed, PREFIX, op};
use super::source::Source;
use super::tail::Summary;

/// The index; entries leave it as their chunks are met.
#[derive(Debug, Default)]
pub struct Index {
    /// Entries by the places where their chunks really are, as the chunks' headers say.
    standing: BTreeMap<u64, ChunkIndex>,
    /// Entries whose chunks are not where they should be: the file or the index is damaged.
    astray: BTreeSet<ChunkIndex>,
    /// The same, by the places where they should be.
    astray_at: BTreeMap<u64, ChunkIndex>,
    /// From here on no chunk belongs to the log that the index does not list; `None` where it does
    /// not say so, since no checksum vouches for it or no chunk is where it says.
    binding_from: Option<u64>,
    /// Whether any chunk was where it says.
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
        // Of logs that were put one behind the other it is the last one's.
        let shift = u64::try_from(summary.shift).unwrap_or_default();
        let is_joined = shift > 0 && source.peek(shift)? == Some(MAGIC);
        let begin = if is_joined { shift } else { 0 };
        for entry in &summary.chunks {
            let moved = entry.offset.saturating_add_signed(summary.shift);
            let mut place = None;
            for offset in [entry.offset, moved] {
                if place.is_none()
                    && offset >= begin
                    && chunk_at(source, offset)? == Some((entry.span, entry.uncompressed))
                {
                    place = Some(offset);
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
        index.is_credible = !index.standing.is_empty();
        if summary.verified && (index.is_credible || summary.chunk_count == Some(0)) {
            index.binding_from = Some(begin);
        }
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
    pub fn lists(&self, at: u64, header: &ChunkHeader) -> bool {
        self.standing.contains_key(&at)
            || self.stray(Some(header.span), header.uncompressed).is_some()
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

    /// Takes the entry of a whole chunk, which is known by the log times of its messages.
    pub fn meet(&mut self, at: u64, span: Option<(u64, u64)>, uncompressed: u64) -> Listing {
        let here = self.at(at);
        if here.is_some_and(|entry| span.is_none_or(|span| span == entry.span)) {
            self.lose(at);
            return Listing::Listed;
        }
        if let Some(entry) = self.stray(span, uncompressed) {
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

    /// An entry that says this of a chunk, and is wrong about the place.
    fn stray(&self, span: Option<(u64, u64)>, uncompressed: u64) -> Option<ChunkIndex> {
        let span = span.unwrap_or_default();
        let [first, last] = [0, u64::MAX].map(|bound| ChunkIndex {
            span,
            uncompressed,
            offset: bound,
            length: bound,
        });
        self.astray.range(first..=last).next().copied()
    }
}

/// Log times and uncompressed size, as the header of the chunk that begins there has them.
type Identity = ((u64, u64), u64);

fn chunk_at<R: Read + Seek>(source: &mut Source<R>, at: u64) -> io::Result<Option<Identity>> {
    let Some(bytes) = source.peek::<{ PREFIX as usize + 3 * 8 }>(at)? else {
        return Ok(None);
    };
    let mut fields = Fields(&bytes);
    let mut identity = || {
        let opcode = fields.u8()?;
        fields.u64()?; // length
        let span = (fields.u64()?, fields.u64()?);
        Ok::<_, Malformed>((opcode, (span, fields.u64()?)))
    };
    let chunk = identity().ok().filter(|(opcode, _)| *opcode == op::CHUNK);
    Ok(chunk.map(|(_, identity)| identity))
}
