//! What a golden file does not say of the configuration.

use crate::config::Config;

/// Parameters that the program has and the file does not record.
pub fn unrecorded(bytes: &[u8], config: &Config) -> Vec<String> {
    let recorded = serde_json::from_slice(bytes)
        .ok()
        .and_then(|file: serde_json::Value| file.get("config").cloned());
    let (Some(recorded), Ok(full)) = (recorded, serde_json::to_value(config)) else {
        return Vec::new();
    };
    let mut missing = Vec::new();
    absent(&recorded, &full, "", &mut missing);
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
