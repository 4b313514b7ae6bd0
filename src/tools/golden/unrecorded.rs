//! What a file with results does not say of what they came from.

use serde::Serialize;

use crate::core::config::Config;

/// Parameters that the program has and the file does not record under `config`.
pub fn unrecorded(bytes: &[u8], config: &Config) -> Vec<String> {
    absent_under("config", bytes, config, "")
}

/// The fields of `full` that the file does not have under `key`, each after `prefix`.
pub(super) fn absent_under(
    key: &str,
    bytes: &[u8],
    full: &impl Serialize,
    prefix: &str,
) -> Vec<String> {
    let recorded = serde_json::from_slice(bytes)
        .ok()
        .and_then(|file: serde_json::Value| file.get(key).cloned());
    let (Some(recorded), Ok(full)) = (recorded, serde_json::to_value(full)) else {
        return Vec::new();
    };
    let mut missing = Vec::new();
    absent(&recorded, &full, prefix, &mut missing);
    missing
}

fn absent(
    recorded: &serde_json::Value,
    full: &serde_json::Value,
    path: &str,
    missing: &mut Vec<String>,
) {
    let (Some(recorded), Some(full)) = (recorded.as_object(), full.as_object()) else {
        return;
    };
    for (key, value) in full {
        let path = if path.is_empty() {
            key.clone()
        } else {
            format!("{path}.{key}")
        };
        match recorded.get(key) {
            Some(recorded) => absent(recorded, value, &path, missing),
            None => missing.push(path),
        }
    }
}
