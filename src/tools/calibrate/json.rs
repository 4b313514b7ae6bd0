//! A calibration in JSON: SI units and radians.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::{Calibration, Row, State};
use crate::core::calibrate::search::Standing;
use crate::core::rounding::rounded;
use crate::io::config::changed::ChangedKey;
use crate::observe::causes;
use crate::tools::document;

impl Calibration<'_> {
    /// Writes it in JSON.
    ///
    /// # Errors
    /// When `out` cannot be written to.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let rows: Vec<Value> = self.rows.iter().map(|row| self.row(row)).collect();
        let keys = self.keys();
        let keys: Vec<Value> = keys.iter().map(key).collect();
        let content = json!({
            "file": self.file,
            "parameters": rows,
            "causes": causes::all(&self.search, self.events, self.config),
            "keys": keys,
            "as_configured": standing(&self.search.standings[0]),
            "mended": standing(&self.search.standings[1]),
            "replays": self.search.replays,
        });
        document::write(out, "tmam.calibration/1", &content)
    }

    fn row(&self, row: &Row) -> Value {
        let why = match row.state {
            State::CannotTell(why) => Some(why.text()),
            _ => None,
        };
        let estimated = row.estimated;
        json!({
            "parameter": causes::named(row.parameter, self.events),
            "change": estimated.map(|one| rounded(one.value)),
            "sigma": estimated.map(|one| rounded(one.deviation)),
            "gain_bits_per_arc": rounded(row.gain),
            "state": row.state.name(),
            "why": why,
        })
    }
}

fn key(key: &ChangedKey) -> Value {
    json!({ "key": key.path, "configured": key.configured, "value": key.value })
}

fn standing(standing: &Standing) -> Value {
    json!({
        "bits": standing.bits.per_arc().map(rounded),
        "explained": standing.bits.explained_share().map(rounded),
        "suspects": standing.suspects,
        "lines": standing.map[0],
        "points": standing.map[1],
    })
}
