//! The records of a chunk: decompressed, and checked against the chunk's checksum.

use std::io::{self, Read, Seek};

use super::record::ChunkHeader;
use super::source::Source;
use super::{MAX_CHUNK, Why};

/// Largest window that a zstd frame may ask for, as a power of two: beside the largest chunk it
/// keeps the whole program far from 300 MiB.
const ZSTD_WINDOW_LOG: u32 = 26;

/// How much all chunks of a file may unpack to: a constant, and a multiple of the file's size.
const BUDGET: (u64, u64) = (512 << 20, 100);

/// Decompresses chunks, one after the other.
#[derive(Debug)]
pub struct Unpacker {
    buffer: Vec<u8>,
    file: u64,
    left: u64,
}

impl Unpacker {
    /// For a file of so many bytes.
    pub fn new(file: u64) -> Self {
        Self {
            buffer: Vec::new(),
            file,
            left: BUDGET.0.saturating_add(file.saturating_mul(BUDGET.1)),
        }
    }

    /// The records of a whole chunk, if they are what was written.
    ///
    /// The outer error is of the file's reading, the inner one of what is in it.
    pub fn records<'a, R: Read + Seek>(
        &'a mut self,
        source: &'a mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<Result<&'a [u8], Why>> {
        // Before it is read: these need not be decompressed to be told.
        if header.compression.is_empty() && header.compressed != header.uncompressed {
            return Ok(Err(Why::Size {
                claimed: header.uncompressed,
                found: header.compressed,
            }));
        }
        if let Err(why) = self.admit(header) {
            return Ok(Err(why));
        }
        let bytes = match self.unpack(source, offset, header)? {
            (_, Some(why)) => return Ok(Err(why)),
            (bytes, None) => bytes,
        };
        let found = bytes.len() as u64;
        if found != header.uncompressed {
            return Ok(Err(Why::Size {
                claimed: header.uncompressed,
                found,
            }));
        }
        let expected = header.checksum;
        let found = if expected == 0 {
            0
        } else {
            crc32fast::hash(bytes)
        };
        Ok(if found == expected {
            Ok(bytes)
        } else {
            Err(Why::Checksum { expected, found })
        })
    }

    /// The records of a chunk that the file ends within, as far as they go.
    pub fn beginning<'a, R: Read + Seek>(
        &'a mut self,
        source: &'a mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<Result<&'a [u8], Why>> {
        if let Err(why) = self.admit(header) {
            return Ok(Err(why));
        }
        Ok(match self.unpack(source, offset, header)? {
            (_, Some(why @ Why::Compression(_))) => Err(why),
            (bytes, _) => Ok(bytes),
        })
    }

    /// Refuses what would take too much memory or time.
    fn admit(&mut self, header: &ChunkHeader) -> Result<(), Why> {
        let largest = header.uncompressed.max(header.compressed);
        if largest > MAX_CHUNK {
            return Err(Why::TooLarge(largest));
        }
        self.left = self.left.checked_sub(largest).ok_or(Why::Bomb(self.file))?;
        Ok(())
    }

    /// As many bytes as can be had, at most one more than the header claims, and why there are no
    /// more.
    fn unpack<'a, R: Read + Seek>(
        &'a mut self,
        source: &'a mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<(&'a [u8], Option<Why>)> {
        let limit = header.uncompressed.saturating_add(1);
        self.buffer.clear();
        if header.compression.is_empty() {
            // It may be read where it lies.
            return Ok((source.get(offset, header.compressed)?, None));
        }
        let packed = io::BufReader::new(source.stream(offset, header.compressed)?);
        let read = match header.compression.as_str() {
            "zstd" => zstd::Decoder::with_buffer(packed).and_then(|mut decoder| {
                decoder.window_log_max(ZSTD_WINDOW_LOG)?;
                decoder.take(limit).read_to_end(&mut self.buffer)
            }),
            "lz4" => lz4::Decoder::new(packed)
                .and_then(|decoder| decoder.take(limit).read_to_end(&mut self.buffer)),
            other => return Ok((&[], Some(Why::Compression(other.to_owned())))),
        };
        let problem = read
            .err()
            .map(|error| Why::Decompression(error.to_string()));
        Ok((&self.buffer, problem))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn header(compression: &str, uncompressed: u64) -> ChunkHeader {
        ChunkHeader {
            span: (0, 0),
            uncompressed,
            checksum: 0,
            compression: compression.to_owned(),
            length: 40,
            compressed: 1 << 20,
        }
    }

    #[test]
    fn two_lengths_that_should_be_one_are_compared_before_anything_is_read() {
        let mut file = Cursor::new(vec![0; 1 << 20]);
        let mut source = Source::new(&mut file).unwrap();
        let mut unpacker = Unpacker::new(0);
        let outcome = unpacker.records(&mut source, 0, &header("", 100)).unwrap();
        let (claimed, found) = (100, 1 << 20);
        assert_eq!(outcome, Err(Why::Size { claimed, found }));
        assert_eq!(file.position(), found, "it was read");
    }

    #[test]
    fn what_is_read_counts_as_well_as_what_it_unpacks_to() {
        let mut source = Source::new(Cursor::new(vec![0; 1 << 20])).unwrap();
        let mut unpacker = Unpacker::new(0);
        for (chunk, left) in [(header("zstd", 100), 511), (header("zstd", 2 << 20), 509)] {
            assert!(unpacker.records(&mut source, 0, &chunk).unwrap().is_err());
            assert_eq!(unpacker.left, left << 20);
        }
    }
}
