//! Which program wrote a file.

use serde::Serialize;

/// The program, at the head of every file that it writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Tool {
    name: &'static str,
    version: &'static str,
}

impl Tool {
    /// This one.
    pub const THIS: Self = Self {
        name: "tmam",
        version: env!("CARGO_PKG_VERSION"),
    };
}
