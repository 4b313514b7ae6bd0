//! The part of `tmam` that reads bytes from files, without the rest.

/// What decoding needs of the ground floor: channels of unknown types, and how numbers are said.
#[path = "../../src/core"]
#[allow(dead_code, reason = "only decoding is fuzzed")]
pub mod core {
    pub mod legible;
    pub mod rounding;
    pub mod wording;

    pub mod config {
        pub mod channel;
    }
}

#[path = "../../src/io"]
pub mod io {
    /// The room `log/`, as far as it is fuzzed.
    #[allow(dead_code, reason = "only decoding is fuzzed")]
    pub mod log {
        mod clouds;
        pub mod container;
        mod custom;
        mod decoder;
        mod definition;
        mod description;
        pub mod fuzzing;
        mod json;
        mod message;
        mod poses;
        mod protobuf;
        mod ranges;
        mod ros;
        mod types;
        mod value;
    }
}

pub use io::log;
