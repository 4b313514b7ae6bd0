//! Names of recordings, which the viewer goes by.

use rerun::{ApplicationId, StoreId, StoreKind};

use crate::core::observer::Setting;
use crate::core::world::World;

/// How much of a file's name goes into the name of its recordings' application.
const MAX_STEM: usize = 100;

/// Names for the recording and its blueprint that follow from log and configuration.
///
/// The viewer keeps a blueprint per application, and bounds that fit one log do not fit another:
/// so each log is its own application. Two configurations over one log are two recordings of it, and
/// so is one held against a world.
pub fn store_ids(setting: &Setting<'_>, world: Option<&World>) -> [StoreId; 2] {
    let source = setting.source;
    let mut content = serde_json::to_string(&(source, setting.config)).unwrap_or_default();
    if let Some(world) = world {
        content.push_str(&serde_json::to_string(world).unwrap_or_default());
    }
    let recording = format!("{}-{:016x}", source.start_ns, fnv1a(content.as_bytes()));
    named_ids("tmam", &source.file, recording)
}

/// Names for a recording of a kind of a log.
pub fn named_ids(kind: &str, file: &str, recording: String) -> [StoreId; 2] {
    // Other characters are not allowed in an application's name.
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let stem: String = stem
        .chars()
        .map(|c| {
            if c.is_ascii_alphanumeric() || c == '_' {
                c
            } else {
                '-'
            }
        })
        .take(MAX_STEM)
        .collect();
    let application = ApplicationId::new_or_unknown(format!("{kind}-{stem}"));
    let blueprint = format!("{recording}-blueprint");
    [
        StoreId::new(StoreKind::Recording, application.clone(), recording),
        StoreId::new(StoreKind::Blueprint, application, blueprint),
    ]
}

/// A hash that is the same everywhere.
pub fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
