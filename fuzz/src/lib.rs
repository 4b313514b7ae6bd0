//! The part of `tmam` that reads bytes from files, without the rest.

/// How channels of unknown types are described.
#[path = "../../src/core/config"]
#[allow(dead_code, reason = "only decoding is fuzzed")]
pub mod config {
    pub mod channel;
}

/// How numbers are said.
#[path = "../../src/core/wording.rs"]
#[allow(dead_code, reason = "only decoding is fuzzed")]
pub mod wording;

/// And rounded.
#[path = "../../src/core/rounding.rs"]
#[allow(dead_code, reason = "only decoding is fuzzed")]
pub mod rounding;

/// The room `log/`, as far as it is fuzzed.
#[path = "../../src/io/log"]
#[allow(dead_code, reason = "only decoding is fuzzed")]
pub mod log {
    pub mod container;
    mod custom;
    mod decoder;
    mod description;
    pub mod fuzzing;
    mod json;
    mod messages;
    mod msg_schema;
    mod protobuf;
    mod ros1;
    mod ros2;
    mod standard;
    mod value;
}
