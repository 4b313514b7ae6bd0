//! JSON documents: the format and the program stand at their head.

use std::io::{self, Write};

use serde::Serialize;

use crate::core::tool::Tool;

#[derive(Serialize)]
struct Document<'a, T> {
    schema: &'static str,
    tool: Tool,
    #[serde(flatten)]
    content: &'a T,
}

/// Writes a document, pretty and with a newline at its end.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write<T: Serialize>(
    out: &mut dyn Write,
    schema: &'static str,
    content: &T,
) -> io::Result<()> {
    let document = Document {
        schema,
        tool: Tool::THIS,
        content,
    };
    serde_json::to_writer_pretty(&mut *out, &document)?;
    out.write_all(b"\n")
}
