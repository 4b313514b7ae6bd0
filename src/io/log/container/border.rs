//! Where records begin and end, by their lengths, by their fields, and by what follows them.

use std::io::{self, Read, Seek};

use super::record::{
    ChunkHeader, DATA_END, INDEX_ENTRY, INDEX_HEADER, MAX_CHUNK, MESSAGE_HEADER, PREFIX, op,
};
use super::source::Source;

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

/// The opcode and length at some place; `None` where the file ends.
pub fn prefix<R: Read + Seek>(source: &mut Source<R>, at: u64) -> io::Result<Option<Prefix>> {
    let bytes = source.peek::<{ PREFIX as usize }>(at)?;
    Ok(bytes.map(|[opcode, length @ ..]| Prefix {
        opcode,
        length: u64::from_le_bytes(length),
    }))
}

/// The header of a chunk that begins there, if it has room for one.
pub fn chunk_header<R: Read + Seek>(
    source: &mut Source<R>,
    at: u64,
) -> io::Result<Option<ChunkHeader>> {
    let body = source.get(at.saturating_add(PREFIX), ChunkHeader::ROOM)?;
    Ok(ChunkHeader::parse(body).ok())
}

/// Where a record of some kind ends by the counts in its fields. What the fields hold is not read, be
/// it as long as it may. `None` for kinds without counts, and where the file ends before.
pub fn end_of_fields<R: Read + Seek>(
    source: &mut Source<R>,
    at: u64,
    opcode: u8,
) -> io::Result<Option<u64>> {
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
    for _ in 0..short {
        let Some(count) = source.peek::<4>(end)? else {
            return Ok(None);
        };
        end = end.saturating_add(4 + u64::from(u32::from_le_bytes(count)));
    }
    for _ in 0..long {
        let Some(count) = source.peek::<8>(end)? else {
            return Ok(None);
        };
        end = end
            .saturating_add(8)
            .saturating_add(u64::from_le_bytes(count));
    }
    let end = end.saturating_add(behind);
    Ok((end <= source.length()).then_some(end))
}

/// Where the record that begins there ends, if nothing speaks against it: its length and its fields
/// agree.
pub fn end_of_whole<R: Read + Seek>(source: &mut Source<R>, at: u64) -> io::Result<Option<u64>> {
    let Some(prefix) = prefix(source, at)? else {
        return Ok(None);
    };
    let end = prefix.end(at);
    let fits = prefix.is_possible() && end <= source.length();
    let agrees = match prefix.opcode {
        op::MESSAGE => prefix.length >= MESSAGE_HEADER,
        op::MESSAGE_INDEX if prefix.length % INDEX_ENTRY != INDEX_HEADER => false,
        op::HEADER..=op::CHANNEL
        | op::CHUNK
        | op::MESSAGE_INDEX
        | op::ATTACHMENT
        | op::METADATA
        | op::DATA_END => end_of_fields(source, at, prefix.opcode)? == Some(end),
        _ => true,
    };
    Ok((fits && agrees).then_some(end))
}

/// Whether so many whole records follow each other from there on, or all up to the end of the data or of
/// the file. A file that is cut off may end within one.
pub fn leads_on<R: Read + Seek>(
    source: &mut Source<R>,
    mut at: u64,
    records: usize,
    is_cut_off: bool,
) -> io::Result<bool> {
    for _ in 0..records {
        if at == source.length() {
            return Ok(true);
        }
        let Some(end) = end_of_whole(source, at)? else {
            let runs_out = prefix(source, at)?.is_none_or(|next| {
                next.is_possible() && next.length <= MAX_CHUNK && next.end(at) > source.length()
            });
            return Ok(is_cut_off && at < source.length() && runs_out);
        };
        if matches!(source.peek(at)?, Some([op::DATA_END | op::FOOTER])) {
            return Ok(true);
        }
        at = end;
    }
    Ok(true)
}

/// Whether the data section ends there: a summary follows, or a footer, or nothing.
pub fn ends_data<R: Read + Seek>(
    source: &mut Source<R>,
    at: u64,
    is_cut_off: bool,
) -> io::Result<bool> {
    let belongs_to_data = |next: Prefix| {
        matches!(
            next.opcode,
            op::HEADER | op::MESSAGE..=op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA
        )
    };
    let ends = prefix(source, at)?.is_some_and(|it| (it.opcode, it.length) == (op::DATA_END, 4));
    let behind = at.saturating_add(DATA_END);
    Ok(ends
        && !prefix(source, behind)?.is_some_and(belongs_to_data)
        && leads_on(source, behind, 1, is_cut_off)?)
}

/// The first place in `from..to` where a record could begin at which reading goes on behind damage, at
/// a cheap look: a schema, channel, message or chunk, or the end of the data.
pub fn next_candidate<R: Read + Seek>(
    source: &mut Source<R>,
    from: u64,
    to: u64,
) -> io::Result<Option<u64>> {
    // No record that matters is longer than 2^40 bytes.
    let could_be = |window: &[u8]| {
        matches!(
            window,
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
    };
    let mut at = from;
    let mut stride = FIRST_STRIDE;
    while at < to {
        let bytes = source.get(at, stride.min(to - at) + PREFIX - 1)?;
        let mut windows = bytes.windows(PREFIX as usize);
        if let Some(index) = windows.position(could_be) {
            return Ok(Some(at + index as u64));
        }
        at = at.saturating_add(stride);
        stride = (2 * stride).min(STRIDE);
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, SeekFrom};

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
            assert_eq!(
                end_of_fields(&mut source, 20, opcode).unwrap(),
                end,
                "{opcode}"
            );
            assert_eq!(end_of_whole(&mut source, 20).unwrap(), end, "{opcode}");
            assert!(file.1 < 100, "{opcode}: {} bytes read", file.1);
        }
    }

    #[test]
    fn fields_end_where_the_file_does() {
        let record = [&[3][..], &[0; 8], &[0; 2], &counted(50)].concat();
        let mut source = Source::new(Cursor::new(record)).unwrap();
        assert_eq!(end_of_fields(&mut source, 0, 3).unwrap(), None);
        assert_eq!(end_of_fields(&mut source, u64::MAX - 1, 3).unwrap(), None);
    }
}
