//! Where the summary's index says that chunks are.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek};

use super::fields::Fields;
use super::record::{ChunkHeader, ChunkIndex, PREFIX, op};
use super::source::Source;
use super::tail::Summary;

/// The chunks of the index.
#[derive(Debug, Default)]
pub struct Places {
    /// Where they are, for certain.
    certain: BTreeMap<u64, ChunkIndex>,
    /// Where they were when the file was written.
    written: BTreeMap<u64, ChunkIndex>,
}

impl Places {
    /// Finds the chunks of the index. Where each chunk that it names is, as long as a checksum vouches
    /// for it, the file's length has not changed and one of them really stands there: writers err, too.
    /// Else only those that stand.
    pub fn find<R: Read + Seek>(source: &mut Source<R>, summary: &Summary) -> io::Result<Self> {
        let mut places = Self::default();
        for index in &summary.chunks {
            places.written.insert(index.offset, *index);
            for shift in [0, summary.shift] {
                let offset = index.offset.saturating_add_signed(shift);
                let moved = ChunkIndex { offset, ..*index };
                if stands(source, &moved)? {
                    places.certain.insert(offset, moved);
                }
            }
        }
        if summary.verified && summary.shift == 0 && !places.certain.is_empty() {
            places.certain.clone_from(&places.written);
        }
        Ok(places)
    }

    /// The chunk that begins there.
    pub fn at(&self, offset: u64) -> Option<&ChunkIndex> {
        self.certain.get(&offset)
    }

    /// The first chunk that begins behind there.
    pub fn after(&self, offset: u64) -> Option<&ChunkIndex> {
        let behind = offset.checked_add(1)?;
        self.certain.range(behind..).next().map(|(_, index)| index)
    }

    /// What the index says of a chunk there, even if it is not certain to be there still.
    pub fn described(&self, offset: u64) -> Option<&ChunkIndex> {
        self.at(offset).or_else(|| self.written.get(&offset))
    }

    /// Whether the file has chunks.
    pub fn any(&self) -> bool {
        !self.written.is_empty()
    }
}

fn stands<R: Read + Seek>(source: &mut Source<R>, index: &ChunkIndex) -> io::Result<bool> {
    const ENOUGH: usize = (PREFIX + 2 * 8) as usize;
    let Some(bytes) = source.peek::<ENOUGH>(index.offset)? else {
        return Ok(false);
    };
    let mut fields = Fields(&bytes);
    let mut same = || {
        Some(
            fields.u8().ok()? == op::CHUNK
                && fields.u64().ok()?.checked_add(PREFIX)? == index.length
                && (fields.u64().ok()?, fields.u64().ok()?) == index.span,
        )
    };
    Ok(same().unwrap_or(false))
}

/// Whether a body is a chunk's, whatever its record's kind.
pub fn is_chunk<R: Read + Seek>(source: &mut Source<R>, at: u64, length: u64) -> io::Result<bool> {
    let bytes = source.get(at, ChunkHeader::ROOM.min(length))?;
    Ok(ChunkHeader::parse(bytes).is_ok_and(|header| {
        header.fills(length)
            && header.compressed > 0
            && matches!(header.compression.as_str(), "" | "zstd" | "lz4")
    }))
}
