//! How far the fields of a record in the file reach, by their counts alone: what they hold is not read, be
//! it as long as it may.

use std::io::{self, Read, Seek};

use super::record::op;
use super::source::Source;

/// A place among the fields of a record; `None` once one ran beyond its end.
struct Place {
    at: Option<u64>,
    end: u64,
}

impl Place {
    fn pass(&mut self, count: u64) {
        let end = self.end;
        let next = self.at.and_then(|at| at.checked_add(count));
        self.at = next.filter(|next| *next <= end);
    }

    /// Bytes with their count, in four bytes, before them.
    fn pass_counted<R: Read + Seek>(&mut self, source: &mut Source<R>) -> io::Result<()> {
        let count = match self.at {
            Some(at) => source.peek::<4>(at)?,
            None => None,
        };
        self.pass(4);
        self.pass(count.map_or(u64::MAX, |count| u32::from_le_bytes(count).into()));
        Ok(())
    }
}

/// Bytes that the fields of a header, schema, channel, attachment or metadata record fill of its body, which is at
/// some place and claims a length; `None` where they run beyond that or the file.
pub fn of_fields<R: Read + Seek>(
    source: &mut Source<R>,
    opcode: u8,
    body: u64,
    length: u64,
) -> io::Result<Option<u64>> {
    let end = body.saturating_add(length).min(source.length());
    let mut place = Place {
        at: Some(body),
        end,
    };
    let (fixed, counted) = match opcode {
        op::SCHEMA => (2, 3),      // id; name, encoding, data
        op::CHANNEL => (4, 3),     // id, schema; topic, encoding, metadata
        op::ATTACHMENT => (16, 2), // times; name, media type
        op::HEADER => (0, 2),      // profile, library
        op::METADATA => (0, 2),    // name, what it says
        _ => return Ok(None),
    };
    place.pass(fixed);
    for _ in 0..counted {
        place.pass_counted(source)?;
    }
    if opcode == op::ATTACHMENT {
        let data = match place.at {
            Some(at) => source.peek::<8>(at)?,
            None => None,
        };
        place.pass(8);
        place.pass(data.map_or(u64::MAX, u64::from_le_bytes));
        place.pass(4); // checksum
    }
    Ok(place.at.map(|at| at - body))
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
            let fields = body.len() as u64;
            let mut file = Counted(Cursor::new([&[1; 20][..], &body, &[2; 40]].concat()), 0);
            let mut source = Source::new(&mut file).unwrap();
            let mut of = |length| of_fields(&mut source, opcode, 20, length).unwrap();
            assert_eq!(of(fields), Some(fields), "{opcode}");
            assert_eq!(of(fields + 30), Some(fields), "{opcode}");
            assert_eq!(of(fields - 1), None, "{opcode}");
            assert!(file.1 < 100, "{opcode}: {} bytes read", file.1);
        }
    }

    #[test]
    fn fields_end_where_the_file_does() {
        let mut source = Source::new(Cursor::new([&[0; 2][..], &counted(50)].concat())).unwrap();
        assert_eq!(of_fields(&mut source, 3, 0, u64::MAX).unwrap(), None);
        assert_eq!(of_fields(&mut source, 3, u64::MAX - 1, 9).unwrap(), None);
    }
}
