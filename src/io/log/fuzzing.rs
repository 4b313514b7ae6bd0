//! One function for every part that reads bytes from a file: what a fuzzer calls, and what the tests
//! call with the fuzzer's corpus. Each panics only where the part breaks its promise.
//!
//! A new decoder gets a function here, a line in [`TARGETS`], a file in `fuzz/fuzz_targets`, an entry
//! in `fuzz/Cargo.toml` and a few small files in `fuzz/corpus`.

use std::io::Cursor;

use std::rc::Rc;

use super::container::{self, Channel, Schema, Unchecked};
use super::decoder::Decoder;
use super::value::{Fields, Path};
use super::{custom, description, json as json_text, types};
use crate::core::config::channel::ChannelFields;

/// A fuzzed part.
pub type Target = fn(&[u8]);

/// Every target: the name of its corpus, and its function.
pub const TARGETS: [(&str, Target); 7] = [
    ("container", container),
    ("custom", custom),
    ("description", description),
    ("json", json),
    ("protobuf", protobuf),
    ("ros1", ros1),
    ("ros2", ros2),
];

/// A whole file.
pub fn container(file: &[u8]) {
    for unchecked in [Unchecked::LeftOut, Unchecked::Used] {
        let mut taken = 0_u64;
        let losses = container::walk_in(Cursor::new(file), unchecked, &mut |_, message| {
            taken = taken.wrapping_add(message.log_time ^ message.data.len() as u64);
        });
        for loss in losses.into_iter().flatten() {
            assert!(loss.offset <= file.len() as u64, "{loss:?}");
            assert!(!loss.to_string().is_empty(), "{loss:?}");
        }
    }
}

/// A description of a channel by field paths, and a message: both JSON, with the description's length
/// in two bytes before it.
pub fn custom(input: &[u8]) {
    let Some((description, message)) = split(input) else {
        return;
    };
    let fields: Result<ChannelFields, _> = serde_json::from_slice(description);
    let Ok(described) = fields else {
        return;
    };
    let paths = custom::paths(&described).into_iter().map(Path::from);
    let paths: &Vec<Path> = &paths.collect();
    if let Ok(values) = json_text::decode(message, paths)
        && described.problem().is_none()
    {
        let _ = custom::read(&described, &Fields { paths, values });
    }
}

/// A ROS 2 definition and a message of it.
pub fn ros2(input: &[u8]) {
    message("cdr", "ros2msg", "fuzz_msgs/msg/Fuzz", input);
}

/// A ROS 1 definition and a message of it.
pub fn ros1(input: &[u8]) {
    message("ros1", "ros1msg", "fuzz_msgs/Fuzz", input);
}

/// Protobuf descriptors and a message of them.
pub fn protobuf(input: &[u8]) {
    message("protobuf", "protobuf", "Fuzz", input);
}

/// A JSON schema, which is not used, and a message.
pub fn json(input: &[u8]) {
    message("json", "jsonschema", "Fuzz", input);
}

/// A robot description.
pub fn description(input: &[u8]) {
    if let Ok(urdf) = std::str::from_utf8(input) {
        let _ = description::fixed_joints(urdf);
    }
}

/// A definition and a message of it, read as every type that is known: the definition's length in two
/// bytes, itself, the message.
fn message(encoding: &str, schema_encoding: &str, name: &str, input: &[u8]) {
    let Some((definition, message)) = split(input) else {
        return;
    };
    let channel = Channel {
        id: 0,
        topic: "/fuzz".to_owned(),
        encoding: encoding.to_owned(),
        schema: Rc::new(Schema {
            name: name.to_owned(),
            encoding: schema_encoding.to_owned(),
            data: definition.to_vec(),
        }),
    };
    for known in types::TYPES {
        if let Ok(decoder) = Decoder::of(&channel, &channel.schema.name, known.paths())
            && let Ok(fields) = decoder.decode(message)
        {
            let _ = (known.read)(&fields);
        }
    }
}

/// Two parts with the first one's length in two bytes before it.
fn split(input: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = input.split_first_chunk::<2>()?;
    Some(rest.split_at(usize::from(u16::from_le_bytes(*length)).min(rest.len())))
}
