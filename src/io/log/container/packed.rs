//! Files that are compressed as a whole: `bag_0.mcap.zstd`, as `ros2 bag record --compression-mode file` writes
//! them, and `.mcap.gz`.

use std::fs::File;
use std::io::{self, Read, Seek};

use flate2::read::MultiGzDecoder;

const GZIP: [u8; 2] = [0x1f, 0x8b];
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// How much a file may unpack to: bytes, and a multiple of what it takes packed.
const BUDGET: (u64, u64) = (512 << 20, 100);

/// The file, or what it unpacks to, in a file that no other program sees. Of one that is cut off, what there is.
pub fn unpacked(mut file: File) -> io::Result<File> {
    let mut begin = [0; 4];
    let known = file.read(&mut begin)?;
    file.rewind()?;
    let budget = file.metadata()?.len().saturating_mul(BUDGET.1);
    let mut contents: Box<dyn Read> = match begin.get(..known) {
        Some(bytes) if bytes.starts_with(&GZIP) => Box::new(MultiGzDecoder::new(file)),
        Some(bytes) if bytes.starts_with(&ZSTD) => Box::new(zstd::Decoder::new(file)?),
        _ => return Ok(file),
    };
    let mut whole = tempfile::tempfile()?;
    let mut buffer = vec![0; 64 << 10];
    let mut room = budget.saturating_add(BUDGET.0);
    while let Ok(read @ 1..) = contents.read(&mut buffer)
        && let Some(rest) = room.checked_sub(read as u64)
        && let Some(bytes) = buffer.get(..read)
    {
        room = rest;
        io::Write::write_all(&mut whole, bytes)?;
    }
    whole.rewind()?;
    Ok(whole)
}
