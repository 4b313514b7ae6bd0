//! The records of a chunk: decompressed, held against the chunk's checksum, and what they hold.

use std::collections::BTreeMap;
use std::io::{self, BufReader, Read, Seek};

use super::loss::Why;
use super::record::{self, ChunkHeader, MAX_CHUNK, Records, op};
use super::source::Source;

/// Largest window that a zstd frame may ask for, as a power of two: beside the largest chunk it
/// keeps the whole program far from 300 MiB.
const ZSTD_WINDOW_LOG: u32 = 26;

/// How much all chunks of a file may unpack to: a constant, and a multiple of the file's size.
const BUDGET: (u64, u64) = (512 << 20, 100);

/// And how much may be unpacked of what only looks like a chunk.
const TRIALS: (u64, u64) = (16 << 20, 4);

/// Decompresses chunks, one after the other.
#[derive(Debug)]
pub struct Unpacker {
    buffer: Vec<u8>,
    file: u64,
    left: u64,
    trials: u64,
}

impl Unpacker {
    /// For a file of so many bytes.
    pub fn new(file: u64) -> Self {
        let budget = |(base, times): (u64, u64)| file.saturating_mul(times).saturating_add(base);
        Self {
            buffer: Vec::new(),
            file,
            left: budget(BUDGET),
            trials: budget(TRIALS),
        }
    }

    /// The records of a whole chunk, if they are what was written.
    ///
    /// The outer error is of the file's reading, the inner one of what is in it.
    pub fn records<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<Result<&[u8], Why>> {
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
        if let Some(why) = self.unpack(source, offset, header)? {
            return Ok(Err(why));
        }
        let found = self.buffer.len() as u64;
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
            crc32fast::hash(&self.buffer)
        };
        Ok(if found == expected {
            Ok(&self.buffer)
        } else {
            Err(Why::Checksum { expected, found })
        })
    }

    /// Whether what looks like a chunk is one, by its checksum. After many that are none, nothing is.
    pub fn proves<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<bool> {
        let cost = header.uncompressed.max(header.compressed);
        if header.checksum == 0 || cost > self.trials {
            return Ok(false);
        }
        let proved = self.records(source, offset, header)?.is_ok();
        if !proved {
            self.trials -= cost;
        }
        Ok(proved)
    }

    /// The records of a chunk that the file ends within, as far as they go.
    pub fn beginning<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<Result<&[u8], Why>> {
        if let Err(why) = self.admit(header) {
            return Ok(Err(why));
        }
        Ok(match self.unpack(source, offset, header)? {
            Some(why @ Why::Compression(_)) => Err(why),
            _ => Ok(&self.buffer),
        })
    }

    /// What was unpacked last.
    pub fn last(&self) -> &[u8] {
        &self.buffer
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

    /// Unpacks as many bytes as can be had, at most one more than the header claims, and says why
    /// there are no more.
    fn unpack<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<Option<Why>> {
        let limit = header.uncompressed.saturating_add(1);
        let buffer = &mut self.buffer;
        buffer.clear();
        let mut packed = BufReader::new(source.stream(offset, header.compressed)?);
        let read = match header.compression.as_str() {
            "" => {
                packed.take(limit).read_to_end(buffer)?; // of the file itself
                return Ok(None);
            }
            "zstd" => zstd::Decoder::with_buffer(packed).and_then(|mut decoder| {
                decoder.window_log_max(ZSTD_WINDOW_LOG)?;
                decoder.take(limit).read_to_end(buffer)
            }),
            "lz4" => lz4::Decoder::new(&mut packed)
                .and_then(|decoder| decoder.take(limit).read_to_end(buffer)),
            other => return Ok(Some(Why::Compression(other.to_owned()))),
        };
        Ok(read
            .err()
            .map(|error| Why::Decompression(error.to_string())))
    }
}

/// The log times of the messages in a chunk, by their channels.
pub type Times = BTreeMap<u16, Vec<u64>>;

pub fn times(records: &[u8]) -> Times {
    let mut times = Times::new();
    let messages = Records::new(records).filter(|record| record.opcode == op::MESSAGE);
    for (channel, time, _) in messages.filter_map(|record| record::message(record.body).ok()) {
        times.entry(channel).or_default().push(time);
    }
    times
}

/// From the first to the last of them.
pub fn span(times: &Times) -> Option<(u64, u64)> {
    let all = || times.values().flatten().copied();
    Some((all().min()?, all().max()?))
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
