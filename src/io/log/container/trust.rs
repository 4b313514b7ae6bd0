//! The checksum over the whole data section, for what no other checksum covers.

use std::io::{self, Read, Seek};

use super::MAGIC;
use super::record::PREFIX;
use super::source::Source;

/// Whether the data section's checksum agrees; `None` where there is none.
///
/// Writers differ in where the section begins: with the file, behind the magic bytes, or behind the
/// header. Any of them will do.
pub fn data_section<R: Read + Seek>(
    source: &mut Source<R>,
    data_end: u64,
) -> io::Result<Option<bool>> {
    let Some(bytes) = source.peek::<4>(data_end.saturating_add(PREFIX))? else {
        return Ok(None);
    };
    let expected = u32::from_le_bytes(bytes);
    if expected == 0 {
        return Ok(None);
    }
    let magic = MAGIC.len() as u64;
    let length = source.peek::<8>(magic + 1)?.map_or(0, u64::from_le_bytes);
    let header_end = (magic + PREFIX)
        .saturating_add(length)
        .min(data_end)
        .max(magic);
    let [magic_part, header, data] = [(0, magic), (magic, header_end), (header_end, data_end)]
        .map(|(from, to)| checksum(source, from, to));
    let (magic_part, header, data) = (magic_part?, header?, data?);
    let mut from_magic = header.clone();
    from_magic.combine(&data);
    let mut from_start = magic_part;
    from_start.combine(&from_magic);
    Ok(Some(
        [from_start, from_magic, data]
            .into_iter()
            .any(|hasher| hasher.finalize() == expected),
    ))
}

fn checksum<R: Read + Seek>(
    source: &mut Source<R>,
    from: u64,
    to: u64,
) -> io::Result<crc32fast::Hasher> {
    let mut hasher = crc32fast::Hasher::new();
    let mut reader = source.stream(from, to.saturating_sub(from))?;
    let mut buffer = vec![0; 64 << 10];
    loop {
        let read = reader.read(&mut buffer)?;
        let Some(bytes) = buffer.get(..read).filter(|bytes| !bytes.is_empty()) else {
            return Ok(hasher);
        };
        hasher.update(bytes);
    }
}
