//! One function for every part that reads bytes from a file: what a fuzzer calls, and what the tests
//! call with the fuzzer's corpus. Each panics only where the part breaks its promise.
//!
//! A new decoder gets a function here, a line in [`TARGETS`], a file in `fuzz/fuzz_targets`, an entry
//! in `fuzz/Cargo.toml` and a few small files in `fuzz/corpus`.

use std::io::Cursor;

use super::container;
use super::ros2;

/// A fuzzed part.
pub type Target = fn(&[u8]);

/// Every target: the name of its corpus, and its function.
pub const TARGETS: [(&str, Target); 2] = [("container", container), ("ros2", ros2)];

/// A whole file.
pub fn container(file: &[u8]) {
    let mut taken = 0_u64;
    let losses = container::walk_in(Cursor::new(file), &mut |_, message| {
        taken = taken.wrapping_add(message.log_time ^ message.data.len() as u64);
    });
    for loss in losses.into_iter().flatten() {
        assert!(loss.offset <= file.len() as u64, "{loss:?}");
        assert!(!loss.to_string().is_empty(), "{loss:?}");
    }
}

/// A definition and a message of it: the definition's length in two bytes, itself, the message.
pub fn ros2(input: &[u8]) {
    let Some((length, rest)) = input.split_first_chunk::<2>() else {
        return;
    };
    let length = usize::from(u16::from_le_bytes(*length)).min(rest.len());
    let (definition, message) = rest.split_at(length);
    if let Ok(decoder) = ros2::Decoder::new("fuzz_msgs/msg/Fuzz", definition) {
        let _ = decoder.decode(message);
    }
}
