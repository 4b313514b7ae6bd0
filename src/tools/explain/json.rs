//! An explanation, or a list of suspects, in JSON.

use std::io::Write;

use serde::Serialize;

use super::Explanation;
use super::suspects::Suspects;
use crate::core::config::Config;
use crate::core::observer::{Setting, Source};
use crate::core::tool::Tool;

/// The format of an explanation.
pub const SCHEMA: &str = "tmam.explanation/1";
/// The format of a list of suspects.
pub const SUSPECTS_SCHEMA: &str = "tmam.suspects/1";

#[derive(Serialize)]
struct File<'a, T> {
    schema: &'static str,
    tool: Tool,
    source: &'a Source,
    config: &'a Config,
    #[serde(flatten)]
    told: &'a T,
}

/// Writes an explanation, pretty, with one newline at its end.
///
/// # Errors
/// When `out` cannot be written.
pub fn write(
    out: impl Write,
    setting: &Setting<'_>,
    explanation: &Explanation,
) -> Result<(), std::io::Error> {
    file(out, SCHEMA, setting, explanation)
}

/// Writes a list of suspects in the same way.
///
/// # Errors
/// When `out` cannot be written.
pub fn write_suspects(
    out: impl Write,
    setting: &Setting<'_>,
    suspects: &Suspects,
) -> Result<(), std::io::Error> {
    file(out, SUSPECTS_SCHEMA, setting, suspects)
}

fn file(
    mut out: impl Write,
    schema: &'static str,
    setting: &Setting<'_>,
    told: &impl Serialize,
) -> Result<(), std::io::Error> {
    let file = File {
        schema,
        tool: Tool::THIS,
        source: setting.source,
        config: setting.config,
        told,
    };
    serde_json::to_writer_pretty(&mut out, &file)?;
    out.write_all(b"\n")
}
