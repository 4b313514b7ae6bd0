//! The records of a chunk: decompressed, held against the chunk's checksum, and what they hold.

use std::collections::BTreeMap;
use std::io::{self, BufReader, Read, Seek};

use zstd::zstd_safe::DCtx;

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
pub struct Unpacker {
    buffer: Vec<u8>,
    zstd: DCtx<'static>,
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
            zstd: DCtx::create(),
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
        let claimed = header.uncompressed;
        let size = |found| (found != claimed).then_some(Why::Size { claimed, found });
        // These need not be read to be told.
        let mut flaw = size(header.compressed).filter(|_| header.compression.is_empty());
        if flaw.is_none() {
            flaw = self.unpack(source, offset, header)?;
        }
        let expected = header.checksum;
        let flaw = flaw.or_else(|| size(self.buffer.len() as u64)).or_else(|| {
            let found = if expected == 0 {
                0
            } else {
                crc32fast::hash(&self.buffer)
            };
            (found != expected).then_some(Why::Checksum { expected, found })
        });
        Ok(flaw.map_or(Ok(&self.buffer), Err))
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
        Ok(match self.unpack(source, offset, header)? {
            Some(why) if !matches!(why, Why::Decompression(_)) => Err(why),
            _ => Ok(&self.buffer),
        })
    }

    /// What was unpacked last.
    pub fn last(&self) -> &[u8] {
        &self.buffer
    }

    /// Unpacks as many bytes as can be had, at most one more than the header claims, and says why
    /// there are no more. Refuses what would take too much memory or time.
    fn unpack<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        offset: u64,
        header: &ChunkHeader,
    ) -> io::Result<Option<Why>> {
        let largest = header.uncompressed.max(header.compressed);
        if largest > MAX_CHUNK {
            return Ok(Some(Why::TooLarge(largest)));
        }
        let Some(left) = self.left.checked_sub(largest) else {
            return Ok(Some(Why::Bomb(self.file)));
        };
        self.left = left;
        let limit = header.uncompressed.saturating_add(1);
        let buffer = &mut self.buffer;
        buffer.clear();
        let mut packed = BufReader::new(source.stream(offset, header.compressed)?);
        let read = match header.compression.as_str() {
            "" => {
                packed.take(limit).read_to_end(buffer)?; // of the file itself
                return Ok(None);
            }
            "zstd" => {
                let mut decoder = zstd::Decoder::with_context(packed, &mut self.zstd);
                let limited = decoder.window_log_max(ZSTD_WINDOW_LOG);
                limited.and_then(|()| decoder.take(limit).read_to_end(buffer))
            }
            "lz4" => lz4::Decoder::new(&mut packed)
                .and_then(|decoder| decoder.take(limit).read_to_end(buffer)),
            other => return Ok(Some(Why::Compression(other.to_owned()))),
        };
        let why = |error: io::Error| Why::Decompression(error.to_string());
        Ok(read.err().map(why))
    }
}

/// The log times of the messages in a chunk, by their channels.
pub type Times = BTreeMap<u16, Vec<u64>>;

pub fn times(records: &[u8]) -> Times {
    let mut times = Times::new();
    let messages = Records(records).filter(|record| record.opcode == op::MESSAGE);
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
