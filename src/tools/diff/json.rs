//! The comparison for programs.

use serde_json::{Value as Json, json};

use super::{Pair, Side};
use crate::core::exit::Exit;
use crate::tools::check::json::{difference, labels};
use crate::tools::golden::{Comparison, Tolerance};

/// The format's name and version.
pub const SCHEMA: &str = "tmam.diff/1";

/// The comparison as JSON.
pub fn json(pair: &Pair, found: &Comparison, tolerance: &Tolerance, exit: Exit) -> Json {
    json!({
        "schema": SCHEMA,
        "tool": {"name": "tmam", "version": env!("CARGO_PKG_VERSION")},
        "exit_code": exit.code(),
        "a": side(&pair.a),
        "b": side(&pair.b),
        "notes": pair.notes,
        "tolerances": tolerance,
        "labels_compared": found.labels_compared,
        "first_frame": found.first_frame(),
        "differences": found.differences.iter().map(difference).collect::<Vec<_>>(),
        "borderline": found.borderline.iter().map(labels).collect::<Vec<_>>(),
    })
}

fn side(side: &Side) -> Json {
    json!({
        "file": side.path.display().to_string(),
        "kind": side.kind.name(),
        "log": side.log.as_ref().map(|log| &log.file),
        "events_sha256": side.log.as_ref().map(|log| &log.events_sha256),
        "map": side.results.map.len(),
        "extracted": side.results.extracted.len(),
        "labels": side.results.labels.as_ref().map(|labels| labels.len()),
        "lost": side.losses,
    })
}
