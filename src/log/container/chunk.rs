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
        self.left = self
            .left
            .checked_sub(header.uncompressed)
            .ok_or(Why::Bomb(self.file))?;
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
