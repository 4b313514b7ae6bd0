//! Bytes of the file from any place, through a window that slides over it; and where records begin and end, by
//! their lengths, by their fields, and by what follows them.

use std::io::{self, Read, Seek, SeekFrom, Take};
use std::iter::repeat_n;

use super::record::{
    ChunkHeader, DATA_END, INDEX_ENTRY, INDEX_HEADER, MAX_CHUNK, MESSAGE_HEADER, PREFIX, op,
};

/// Read at a time where less is asked for: bytes.
const AHEAD: u64 = 256 << 10;
/// Records in a row that are taken for more than chance.
pub const CHAIN: usize = 3;
/// Bytes looked through at a time, at most and at first: the next record is often near.
const STRIDE: u64 = 64 << 10;
const FIRST_STRIDE: u64 = 256;

/// Opcode and length of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Prefix {
    pub opcode: u8,
    /// Bytes of its body.
    pub length: u64,
}

impl Prefix {
    /// The first byte behind the record, which may be behind the file's end.
    pub fn end(self, at: u64) -> u64 {
        at.saturating_add(PREFIX).saturating_add(self.length)
    }

    /// Whether there can be such a record.
    pub fn is_possible(self) -> bool {
        matches!(self.opcode, op::HEADER..=op::DATA_END | op::PRIVATE..)
    }
}

/// A file of known length.
#[derive(Debug)]
pub struct Source<R> {
    input: R,
    length: u64,
    window: Vec<u8>,
    window_at: u64,
}

impl<R: Read + Seek> Source<R> {
    pub fn new(mut input: R) -> io::Result<Self> {
        let length = input.seek(SeekFrom::End(0))?;
        Ok(Self {
            input,
            length,
            window: Vec::new(),
            window_at: 0,
        })
    }

    /// Bytes of the file.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// `count` bytes from `offset` on; fewer where the file ends.
    pub fn get(&mut self, offset: u64, count: u64) -> io::Result<&[u8]> {
        let count = count.min(self.length.saturating_sub(offset));
        if self.inside(offset, count).is_none() {
            self.slide(offset, count.max(AHEAD))?;
        }
        let end = usize::try_from(count).unwrap_or(usize::MAX);
        Ok(self.inside(offset, count).unwrap_or_else(|| {
            // The file has become shorter since it was opened.
            self.window.get(..end).unwrap_or(&self.window)
        }))
    }

    /// A few bytes from `offset` on, without sliding the window there.
    pub fn peek<const N: usize>(&mut self, offset: u64) -> io::Result<Option<[u8; N]>> {
        if let Some(found) = self.inside(offset, N as u64) {
            return Ok(found.first_chunk::<N>().copied());
        }
        let mut bytes = [0; N];
        if offset.saturating_add(N as u64) > self.length {
            return Ok(None);
        }
        self.input.seek(SeekFrom::Start(offset))?;
        match self.input.read_exact(&mut bytes) {
            Ok(()) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// A reader of `count` bytes from `offset` on, for what need not be in memory at once.
    pub fn stream(&mut self, offset: u64, count: u64) -> io::Result<Take<&mut R>> {
        self.input.seek(SeekFrom::Start(offset))?;
        Ok((&mut self.input).take(count))
    }

    /// The checksum of the bytes `from..to`.
    pub fn checksum(&mut self, from: u64, to: u64) -> io::Result<crc32fast::Hasher> {
        let mut hasher = crc32fast::Hasher::new();
        let mut reader = self.stream(from, to.saturating_sub(from))?;
        let mut buffer = vec![0; 64 << 10];
        loop {
            let read = reader.read(&mut buffer)?;
            let Some(bytes) = buffer.get(..read).filter(|bytes| !bytes.is_empty()) else {
                return Ok(hasher);
            };
            hasher.update(bytes);
        }
    }

    /// Whether there is something between `from` and `to`, and all of it zeros.
    pub fn is_zero(&mut self, from: u64, to: u64) -> io::Result<bool> {
        const STRIDE: u64 = 64 << 10;
        let mut at = from;
        while at < to {
            let bytes = self.get(at, STRIDE.min(to - at))?;
            if bytes.iter().any(|byte| *byte != 0) {
                return Ok(false);
            }
            at += STRIDE;
        }
        Ok(from < to)
    }

    fn inside(&self, offset: u64, count: u64) -> Option<&[u8]> {
        let from = usize::try_from(offset.checked_sub(self.window_at)?).ok()?;
        let to = from.checked_add(usize::try_from(count).ok()?)?;
        self.window.get(from..to)
    }

    fn slide(&mut self, offset: u64, count: u64) -> io::Result<()> {
        self.window.clear();
        if count == AHEAD {
            self.window.shrink_to(2 * AHEAD as usize); // a huge record was here, and is gone
        }
        self.window_at = offset;
        self.input.seek(SeekFrom::Start(offset))?;
        let count = count.min(self.length.saturating_sub(offset));
        self.window
            .reserve_exact(usize::try_from(count).unwrap_or_default());
        (&mut self.input)
            .take(count)
            .read_to_end(&mut self.window)?;
        Ok(())
    }

    /// The opcode and length at some place; `None` where the file ends.
    pub fn prefix(&mut self, at: u64) -> io::Result<Option<Prefix>> {
        let bytes = self.peek::<{ PREFIX as usize }>(at)?;
        Ok(bytes.map(|[opcode, length @ ..]| Prefix {
            opcode,
            length: u64::from_le_bytes(length),
        }))
    }

    /// The header of a chunk that begins there, if it has room for one.
    pub fn chunk_header(&mut self, at: u64) -> io::Result<Option<ChunkHeader>> {
        let body = self.get(at.saturating_add(PREFIX), ChunkHeader::ROOM)?;
        Ok(ChunkHeader::parse(body).ok())
    }

    /// Where a record of some kind ends by the counts in its fields, be that behind the file's end. What the
    /// fields hold is not read. `None` for kinds without counts.
    pub fn end_of_fields(&mut self, at: u64, opcode: u8) -> io::Result<Option<u64>> {
        /// Bytes of fixed length in front, parts with their length in 4 bytes, and in 8, and bytes behind.
        type Layout = (u64, usize, usize, u64);
        let (front, short, long, behind): Layout = match opcode {
            op::HEADER => (0, 2, 0, 0),        // profile, library
            op::FOOTER => (20, 0, 0, 0),       // offsets, checksum
            op::SCHEMA => (2, 3, 0, 0),        // id; name, encoding, data
            op::CHANNEL => (4, 3, 0, 0),       // id, schema; topic, encoding, metadata
            op::CHUNK => (28, 1, 1, 0),        // times, size, checksum; compression; records
            op::MESSAGE_INDEX => (2, 1, 0, 0), // channel; entries
            op::ATTACHMENT => (16, 2, 1, 4),   // times; name, media type; data; checksum
            op::METADATA => (0, 2, 0, 0),      // name, what it says
            op::DATA_END => (4, 0, 0, 0),      // checksum
            _ => return Ok(None),
        };
        let mut end = at.saturating_add(PREFIX).saturating_add(front);
        for width in repeat_n(4, short).chain(repeat_n(8, long)) {
            let count = match width {
                4 => self.peek::<4>(end)?.map(|it| u32::from_le_bytes(it).into()),
                _ => self.peek::<8>(end)?.map(u64::from_le_bytes),
            };
            // Where the file ends before a count, they end behind it.
            let count = count.unwrap_or(u64::MAX);
            end = end.saturating_add(width).saturating_add(count);
        }
        Ok(Some(end.saturating_add(behind)))
    }

    /// Where the record that begins there ends, if nothing speaks against it: its length and its fields
    /// agree.
    pub fn end_of_whole(&mut self, at: u64) -> io::Result<Option<u64>> {
        let Some(prefix) = self.prefix(at)? else {
            return Ok(None);
        };
        let end = prefix.end(at);
        let agrees = match prefix.opcode {
            op::MESSAGE => prefix.length >= MESSAGE_HEADER,
            op::MESSAGE_INDEX if prefix.length % INDEX_ENTRY != INDEX_HEADER => false,
            opcode => self.end_of_fields(at, opcode)?.is_none_or(|it| it == end),
        };
        Ok((agrees && prefix.is_possible() && end <= self.length).then_some(end))
    }

    /// Whether so many whole records follow each other from there on, or all up to the end of the data or of
    /// the file. A file that is cut off may end within one.
    pub fn leads_on(&mut self, mut at: u64, records: usize, is_cut_off: bool) -> io::Result<bool> {
        for _ in 0..records {
            if at == self.length {
                return Ok(true);
            }
            let Some(end) = self.end_of_whole(at)? else {
                let runs_out = self.prefix(at)?.is_none_or(|next| {
                    next.is_possible() && next.length <= MAX_CHUNK && next.end(at) > self.length
                });
                return Ok(is_cut_off && at < self.length && runs_out);
            };
            if matches!(self.peek(at)?, Some([op::DATA_END | op::FOOTER])) {
                return Ok(true);
            }
            at = end;
        }
        Ok(true)
    }

    /// Whether the data section ends there: a summary follows, or a footer, or nothing.
    pub fn ends_data(&mut self, at: u64, is_cut_off: bool) -> io::Result<bool> {
        let belongs_to_data = |next: Prefix| {
            matches!(
                next.opcode,
                op::HEADER | op::MESSAGE..=op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA
            )
        };
        let ends = (self.prefix(at)?).is_some_and(|it| (it.opcode, it.length) == (op::DATA_END, 4));
        let behind = at.saturating_add(DATA_END);
        Ok(ends
            && !self.prefix(behind)?.is_some_and(belongs_to_data)
            && self.leads_on(behind, 1, is_cut_off)?)
    }

    /// The first place in `from..to` where a record could begin at which reading goes on behind damage, at
    /// a cheap look: a schema, channel, message or chunk, or the end of the data.
    pub fn next_candidate(&mut self, from: u64, to: u64) -> io::Result<Option<u64>> {
        // No record that matters is longer than 2^40 bytes.
        let could_be = |window: &[u8]| match window {
            [opcode, .., 0, 0, 0] => matches!(*opcode, op::SCHEMA..=op::CHUNK | op::DATA_END),
            _ => false,
        };
        let (mut at, mut stride) = (from, FIRST_STRIDE);
        while at < to {
            let bytes = self.get(at, stride.min(to - at) + PREFIX - 1)?;
            let mut windows = bytes.windows(PREFIX as usize);
            if let Some(index) = windows.position(could_be) {
                return Ok(Some(at + index as u64));
            }
            at = at.saturating_add(stride);
            stride = (2 * stride).min(STRIDE);
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// A file that counts the bytes that are read of it.
    struct Counted(Cursor<Vec<u8>>, u64);

    impl Read for Counted {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let read = self.0.read(buffer)?;
            self.1 += read as u64;
            Ok(read)
        }
    }

    impl Seek for Counted {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.0.seek(to)
        }
    }

    fn counted(length: u32) -> Vec<u8> {
        [&length.to_le_bytes()[..], &vec![7; length as usize]].concat()
    }

    #[test]
    fn what_the_fields_hold_is_not_read() {
        let schema = [&[0; 2][..], &counted(3), &counted(0), &counted(1 << 20)].concat();
        let channel = [&[0; 4][..], &counted(1 << 20), &counted(4), &counted(0)].concat();
        let eight = 5_u64.to_le_bytes();
        let attachment = [&[0; 16][..], &counted(9), &counted(2), &eight, &[0; 9]].concat();
        let metadata = [counted(1), counted(30)].concat();
        for (opcode, body) in [(3, schema), (4, channel), (9, attachment), (12, metadata)] {
            let length = (body.len() as u64).to_le_bytes();
            let record = [&[opcode][..], &length, &body].concat();
            let end = Some(20 + record.len() as u64);
            let mut file = Counted(Cursor::new([&[1; 20][..], &record, &[2; 40]].concat()), 0);
            let mut source = Source::new(&mut file).unwrap();
            assert_eq!(source.end_of_fields(20, opcode).unwrap(), end, "{opcode}");
            assert_eq!(source.end_of_whole(20).unwrap(), end, "{opcode}");
            assert!(file.1 < 100, "{opcode}: {} bytes read", file.1);
        }
    }

    #[test]
    fn fields_that_run_beyond_the_file_are_not_whole() {
        let record = [&[3][..], &[0; 8], &[0; 2], &counted(50)].concat();
        let mut source = Source::new(Cursor::new(record)).unwrap();
        for at in [0, u64::MAX - 1] {
            let end = source.end_of_fields(at, 3).unwrap();
            assert_eq!(
                (end, source.end_of_whole(at).unwrap()),
                (Some(u64::MAX), None)
            );
        }
    }
}
