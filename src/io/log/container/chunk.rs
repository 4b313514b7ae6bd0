//! The records of a chunk: decompressed, held against the chunk's checksum, and what they hold.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::thread::{self, JoinHandle};

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

/// A larger chunk is not unpacked ahead, so that no more than twice as much is in memory: bytes, compressed or not.
const LARGEST_AHEAD: u64 = 16 << 20;

/// Decompresses chunks, one after the other.
pub struct Unpacker {
    last: Unpacked,
    /// What the chunk before it was unpacked with.
    spare: Option<Unpacked>,
    ahead: Option<Ahead>,
    file: u64,
    left: u64,
    trials: u64,
}

/// A chunk that is unpacked on a thread of its own.
struct Ahead {
    offset: u64,
    header: ChunkHeader,
    thread: JoinHandle<(Unpacked, Option<Why>)>,
}

/// What a chunk unpacked to, and what for.
struct Unpacked {
    bytes: Vec<u8>,
    /// Of these bytes, where it is known already.
    checksum: Option<u32>,
    zstd: DCtx<'static>,
}

impl Unpacker {
    /// For a file of so many bytes.
    pub fn new(file: u64) -> Self {
        let budget = |(base, times): (u64, u64)| file.saturating_mul(times).saturating_add(base);
        Self {
            last: Unpacked::new(),
            spare: None,
            ahead: None,
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
        let last = &self.last;
        let flaw = flaw.or_else(|| size(last.bytes.len() as u64)).or_else(|| {
            let found = match expected {
                0 => 0,
                _ => (last.checksum).unwrap_or_else(|| crc32fast::hash(&last.bytes)),
            };
            (found != expected).then_some(Why::Checksum { expected, found })
        });
        Ok(flaw.map_or(Ok(&last.bytes), Err))
    }

    /// Begins to unpack the chunk that comes next, on a thread of its own.
    pub fn begin<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        offset: u64,
        header: ChunkHeader,
    ) -> io::Result<()> {
        if header.compression.is_empty()
            || header.uncompressed.max(header.compressed) > LARGEST_AHEAD
        {
            return Ok(());
        }
        let mut packed = Vec::new();
        let mut stream = source.stream(offset, header.compressed)?;
        stream.read_to_end(&mut packed)?;
        let mut unpacked = self.spare.take().unwrap_or_else(Unpacked::new);
        let of = header.clone();
        let thread = thread::spawn(move || {
            let flaw = unpacked.unpack(packed.as_slice(), &of);
            unpacked.checksum = Some(crc32fast::hash(&unpacked.bytes));
            (unpacked, flaw)
        });
        self.ahead = Some(Ahead {
            offset,
            header,
            thread,
        });
        Ok(())
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
            _ => Ok(&self.last.bytes),
        })
    }

    /// What was unpacked last.
    pub fn last(&self) -> &[u8] {
        &self.last.bytes
    }

    /// Unpacks a chunk, and says what is wrong with it. Refuses what would take too much memory or time.
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
        let is_it = |ahead: &Ahead| ahead.offset == offset && ahead.header == *header;
        if let Some(ahead) = self.ahead.take().filter(is_it) {
            let ended = ahead.thread.join();
            let (unpacked, flaw) = ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            self.spare = Some(std::mem::replace(&mut self.last, unpacked));
            return Ok(flaw);
        }
        self.last.checksum = None;
        let mut packed = BufReader::new(source.stream(offset, header.compressed)?);
        if header.compression.is_empty() {
            self.last.bytes.clear();
            let limit = header.uncompressed.saturating_add(1);
            packed.take(limit).read_to_end(&mut self.last.bytes)?; // of the file itself
            return Ok(None);
        }
        Ok(self.last.unpack(&mut packed, header))
    }
}

impl Unpacked {
    fn new() -> Self {
        Self {
            bytes: Vec::new(),
            checksum: None,
            zstd: DCtx::create(),
        }
    }

    /// Unpacks as many bytes as can be had, at most one more than the header claims, and says why there are no more.
    fn unpack(&mut self, packed: impl BufRead, header: &ChunkHeader) -> Option<Why> {
        let limit = header.uncompressed.saturating_add(1);
        let bytes = &mut self.bytes;
        bytes.clear();
        let read = match header.compression.as_str() {
            "zstd" => {
                let mut decoder = zstd::Decoder::with_context(packed, &mut self.zstd);
                let limited = decoder.window_log_max(ZSTD_WINDOW_LOG);
                limited.and_then(|()| decoder.take(limit).read_to_end(bytes))
            }
            "lz4" => {
                lz4::Decoder::new(packed).and_then(|decoder| decoder.take(limit).read_to_end(bytes))
            }
            other => return Some(Why::Compression(other.to_owned())),
        };
        let why = |error: io::Error| Why::Decompression(error.to_string());
        read.err().map(why)
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
    fn a_chunk_that_was_unpacked_ahead_is_the_same() {
        let text = b"sonar".repeat(1000);
        let packed = zstd::encode_all(&text[..], 0).unwrap();
        let of = |uncompressed: u64| ChunkHeader {
            checksum: crc32fast::hash(&text),
            compressed: packed.len() as u64,
            ..header("zstd", uncompressed)
        };
        let mut source = Source::new(Cursor::new(packed.clone())).unwrap();
        let mut unpacker = Unpacker::new(0);
        // Of the last two something else was begun than is wanted.
        for (begun, wanted) in [(5000, 5000), (4999, 4999), (5000, 4999), (4999, 5000)] {
            let [begun, wanted] = [begun, wanted].map(of);
            unpacker.begin(&mut source, 0, begun.clone()).unwrap();
            let found = unpacker.records(&mut source, 0, &wanted).unwrap();
            let found = found.map(<[u8]>::to_vec);
            let mut alone = Unpacker::new(0);
            let expected = alone.records(&mut source, 0, &wanted).unwrap();
            assert_eq!(found, expected.map(<[u8]>::to_vec));
            assert_eq!(unpacker.last.checksum.is_some(), begun == wanted);
        }
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
