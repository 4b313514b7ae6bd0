//! The table of keys.

mod channel;
mod input;
mod method;
mod sonar;

use super::{Bounds, Key, Unit};

const fn key(path: &'static str, unit: Unit, bounds: Bounds, doc: &'static str) -> Key {
    Key {
        path,
        unit,
        bounds,
        doc,
    }
}

/// Every key.
pub fn keys() -> impl Iterator<Item = &'static Key> {
    let tables = [input::KEYS, method::KEYS, sonar::KEYS, channel::KEYS];
    tables.into_iter().flatten()
}
