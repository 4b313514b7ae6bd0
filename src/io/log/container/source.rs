//! Bytes of the file from any place, through a window that slides over it.

use std::io::{self, Read, Seek, SeekFrom, Take};

/// Read at a time where less is asked for: bytes.
const AHEAD: u64 = 256 << 10;

/// A file of known length.
#[derive(Debug)]
pub struct Source<R> {
    input: R,
    length: u64,
    window: Vec<u8>,
    window_at: u64,
}

impl<R: Read + Seek> Source<R> {
    pub fn new(mut input: R) -> io::Result<Self> {
        let length = input.seek(SeekFrom::End(0))?;
        Ok(Self {
            input,
            length,
            window: Vec::new(),
            window_at: 0,
        })
    }

    /// Bytes of the file.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// `count` bytes from `offset` on; fewer where the file ends.
    pub fn get(&mut self, offset: u64, count: u64) -> io::Result<&[u8]> {
        let count = count.min(self.length.saturating_sub(offset));
        if self.inside(offset, count).is_none() {
            self.slide(offset, count.max(AHEAD))?;
        }
        let end = usize::try_from(count).unwrap_or(usize::MAX);
        Ok(self.inside(offset, count).unwrap_or_else(|| {
            // The file has become shorter since it was opened.
            self.window.get(..end).unwrap_or(&self.window)
        }))
    }

    /// A few bytes from `offset` on, without sliding the window there.
    pub fn peek<const N: usize>(&mut self, offset: u64) -> io::Result<Option<[u8; N]>> {
        if let Some(found) = self.inside(offset, N as u64) {
            return Ok(found.first_chunk::<N>().copied());
        }
        let mut bytes = [0; N];
        if offset.saturating_add(N as u64) > self.length {
            return Ok(None);
        }
        self.input.seek(SeekFrom::Start(offset))?;
        match self.input.read_exact(&mut bytes) {
            Ok(()) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// A reader of `count` bytes from `offset` on, for what need not be in memory at once.
    pub fn stream(&mut self, offset: u64, count: u64) -> io::Result<Take<&mut R>> {
        self.input.seek(SeekFrom::Start(offset))?;
        Ok((&mut self.input).take(count))
    }

    /// The checksum of the bytes `from..to`.
    pub fn checksum(&mut self, from: u64, to: u64) -> io::Result<crc32fast::Hasher> {
        let mut hasher = crc32fast::Hasher::new();
        let mut reader = self.stream(from, to.saturating_sub(from))?;
        let mut buffer = vec![0; 64 << 10];
        loop {
            let read = reader.read(&mut buffer)?;
            let Some(bytes) = buffer.get(..read).filter(|bytes| !bytes.is_empty()) else {
                return Ok(hasher);
            };
            hasher.update(bytes);
        }
    }

    /// Whether there is something between `from` and `to`, and all of it zeros.
    pub fn is_zero(&mut self, from: u64, to: u64) -> io::Result<bool> {
        const STRIDE: u64 = 64 << 10;
        let mut at = from;
        while at < to {
            let bytes = self.get(at, STRIDE.min(to - at))?;
            if bytes.iter().any(|byte| *byte != 0) {
                return Ok(false);
            }
            at += STRIDE;
        }
        Ok(from < to)
    }

    fn inside(&self, offset: u64, count: u64) -> Option<&[u8]> {
        let from = usize::try_from(offset.checked_sub(self.window_at)?).ok()?;
        let to = from.checked_add(usize::try_from(count).ok()?)?;
        self.window.get(from..to)
    }

    fn slide(&mut self, offset: u64, count: u64) -> io::Result<()> {
        self.window.clear();
        if count == AHEAD {
            self.window.shrink_to(2 * AHEAD as usize); // a huge record was here, and is gone
        }
        self.window_at = offset;
        self.input.seek(SeekFrom::Start(offset))?;
        let count = count.min(self.length.saturating_sub(offset));
        self.window
            .reserve_exact(usize::try_from(count).unwrap_or_default());
        (&mut self.input)
            .take(count)
            .read_to_end(&mut self.window)?;
        Ok(())
    }
}
