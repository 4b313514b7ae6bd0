//! The MCAP container: from a file, whole or damaged, to the messages in it.
//!
//! Four rules hold everywhere. What a checksum covers is used only when the checksum agrees. What the
//! summary's index does not list, where a checksum vouches for the index, is not used, and neither is
//! what lies inside another record. Nothing is allocated or skipped on a claimed length that the file is
//! not long enough for. And what is left out becomes a [`Loss`]; reading goes on behind it, at the next
//! record that proves itself: a chunk by the index or its checksum, a message outside of chunks by the
//! records that follow it.
//!
//! What no checksum covers is used as it stands: chunks written without one, and messages and definitions
//! outside of chunks in a file that has none for its data section, or that has lost it by being cut off.
//! Where the data section's checksum fails these are left out, unless the caller takes them as
//! [`Unchecked::Used`]: any of them may be the damaged one. Of a last chunk that the file ends within,
//! whole messages are used and the loss says so.
//!
//! - `source`: bytes of the file, a window at a time; where records begin and end
//! - `record`: the fields of a record
//! - `summary`: footer and summary, which are read first, and the index of chunks
//! - `folder`: the parts of one recording, and folders of drives
//! - `packed`: files that are compressed as a whole
//! - `walker`: one record after the other, and where to go on behind a damaged one
//! - `chunk`: decompression and checksum
//! - `channels`: definitions held by their numbers, and messages handed over with them
//! - `loss`: what could not be read

mod channels;
mod chunk;
mod folder;
mod loss;
mod packed;
mod record;
mod source;
mod summary;
mod walker;

pub use folder::{drives, is_one_recording, place_of_ending};
pub use loss::Loss;
pub use record::{Channel, RawMessage, Schema};
pub use walker::{OpenError, Unchecked, walk, walk_in, walk_with};
