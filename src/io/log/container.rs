//! The MCAP container: from a file, whole or damaged, to the messages in it.
//!
//! Three rules hold everywhere. What a checksum covers is used only when the checksum agrees. Nothing is
//! allocated or skipped on a claimed length that the file is not long enough for. And what is left out
//! becomes a [`Loss`]; reading goes on behind it, at the place that the summary's index names, or else at
//! the next place where a chunk plainly begins.
//!
//! What no checksum covers is used as it stands: chunks written without one, messages outside of chunks
//! in a file that has none for its data section, or that has lost it by being cut off. Messages outside
//! of chunks whose data section's checksum fails are all left out: any of them may be the damaged one,
//! unless the caller takes them as [`Unchecked::Used`].
//! Of a last chunk that the file ends within, whole messages are used and the loss says so.
//!
//! - [`record`]: what the fields of a record are; `fields`: one after the other; `extent`: how far
//!   they reach
//! - `source`: bytes of the file, a window at a time
//! - `tail`: footer and summary, which are read first
//! - `walker`: one record after the other; `used`: what is used of them
//! - `recover`: what follows a damaged one; `cut`: a file that ends too early; `loss`, `losses`: what is said of it
//! - `ends`: where the data and the file end; `overlap`: borders in doubt outside of chunks
//! - `scan`: where to go on when no index tells
//! - `place`: the index of chunks; `denied`: what it speaks against
//! - `chunk`: decompression and checksum; `trust`, `doubt`: the checksum over everything
//! - `registry`: schemas and channels

mod chunk;
mod cut;
mod denied;
mod doubt;
mod ends;
mod extent;
mod fields;
mod loss;
mod losses;
mod overlap;
mod place;
pub mod record;
mod recover;
mod registry;
mod scan;
mod source;
mod tail;
mod trust;
mod used;
mod walker;

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;
use std::rc::Rc;

pub use loss::{Loss, Why};

/// The largest chunk or message, compressed or not, that is read: bytes.
pub const MAX_CHUNK: u64 = 128 << 20;

/// What stands at both ends of a file.
pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// One channel of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// Its number in the file.
    pub id: u16,
    /// Its topic.
    pub topic: String,
    /// How its messages are encoded: `cdr`, `json`, ...
    pub encoding: String,
    /// What its messages mean.
    pub schema: Rc<Schema>,
}

/// The definition of a message type; all empty for a channel without one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Schema {
    /// `sensor_msgs/msg/Range`, ...
    pub name: String,
    /// `ros2msg`, `jsonschema`, ...
    pub encoding: String,
    /// Its text or descriptors.
    pub data: Vec<u8>,
}

/// One message as it lies in the file.
#[derive(Debug, Clone, Copy)]
pub struct RawMessage<'a> {
    /// When it was recorded, nanoseconds.
    pub log_time: u64,
    /// Its bytes.
    pub data: &'a [u8],
}

/// What is done with messages that only the data section's checksum covers, where that does not
/// agree: any of them may be damaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unchecked {
    /// None is used.
    LeftOut,
    /// All are.
    Used,
}

/// Why nothing at all can be read of a file.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It is a pipe or a device: the end of a log is read first.
    #[error("it is a pipe or a device, which cannot be read from any place")]
    NoFile,
    /// It is a file of 0 bytes.
    #[error("it is empty: 0 bytes")]
    Empty,
    /// It is something else.
    #[error("it neither begins nor ends with the MCAP magic bytes")]
    NotMcap,
}

/// Calls `visit` with every message of the file that can be trusted, in file order.
///
/// # Errors
/// A file that cannot be opened or is not an MCAP file. Everything else is a [`Loss`].
pub fn walk(
    path: &Path,
    unchecked: Unchecked,
    visit: &mut dyn FnMut(&Channel, RawMessage<'_>),
) -> Result<Vec<Loss>, OpenError> {
    // Opening a pipe would wait for a writer.
    let metadata = std::fs::metadata(path)?;
    let kind = metadata.file_type();
    if kind.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory).into());
    }
    if !kind.is_file() {
        return Err(OpenError::NoFile);
    }
    if metadata.len() == 0 {
        return Err(OpenError::Empty);
    }
    walk_in(File::open(path)?, unchecked, visit)
}

/// [`walk`] over anything that can be read from any place.
///
/// # Errors
/// Input that cannot be read or is not an MCAP file.
pub fn walk_in<R: Read + Seek>(
    input: R,
    unchecked: Unchecked,
    visit: &mut dyn FnMut(&Channel, RawMessage<'_>),
) -> Result<Vec<Loss>, OpenError> {
    walker::Walker::new(input, unchecked, visit)?.run()
}
