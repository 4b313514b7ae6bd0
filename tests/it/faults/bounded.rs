//! Files made to be read again and again.

use std::io::{Cursor, Read, Result, Seek, SeekFrom};

use tmam_replay::io::log::container::{Unchecked, walk_in};

use super::raw::{channel, claiming, file, message};

/// So many times its length may be read of a file that is damaged all over.
const MOST: u64 = 64;

/// A file that counts the bytes that are read of it.
struct Counted {
    file: Cursor<Vec<u8>>,
    read: u64,
}

impl Read for Counted {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let read = self.file.read(buffer)?;
        self.read += read as u64;
        Ok(read)
    }
}

impl Seek for Counted {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.file.seek(to)
    }
}

/// Repeats a record's beginning, which claims to reach far, and counts what is read of such a file.
fn check(case: &str, beginning: &[u8]) {
    const TIMES: usize = 12_000;
    let records = [channel(1, "/a"), message(1, 5), beginning.repeat(TIMES)];
    let file = file(&records);
    let length = file.len() as u64;
    let mut counted = Counted {
        file: Cursor::new(file),
        read: 0,
    };
    let losses = walk_in(&mut counted, Unchecked::LeftOut, &mut |_, _| {}).unwrap();
    assert!(!losses.is_empty(), "{case}");
    let most = MOST * length;
    assert!(counted.read <= most, "{case}: {} of {length}", counted.read);
}

#[test]
fn records_that_overlap_are_not_read_over_and_over() {
    for claimed in [1_u64 << 15, 1 << 17] {
        for opcode in [3, 4, 9, 12] {
            let case = format!("kind {opcode} of {claimed} bytes");
            check(&case, &claiming(opcode, claimed, b"\x01\0\x01\0\0\0x"));
            check(&case, &claiming(opcode, claimed, &[0; 8]));
        }
        // Chunks that are not compressed and should be longer or shorter than they are.
        let compressed = claimed - 40;
        let header = [
            &[0; 16][..],
            &100_u64.to_le_bytes(),
            &[0; 8], // no checksum, no compression
            &compressed.to_le_bytes(),
        ];
        check(
            &format!("chunk of {claimed} bytes"),
            &claiming(6, claimed, &header.concat()),
        );
    }
}
