//! In place of the table of arcs where the feature `parquet` is off.

use std::io::{self, Write};

use crate::core::observer::Setting;
use crate::core::replay::Outcome;
use crate::core::tmam::arc::Arc;

/// What really echoed at an arc.
pub type TruthOf<'t> = dyn Fn(&Arc) -> Option<(&'static str, Option<usize>)> + 't;

/// What the log is called among others, and whether the folder that the table lies in says so.
#[derive(Debug, Clone, Copy)]
pub struct TableName<'a> {
    pub drive: &'a str,
    pub is_partition: bool,
}

/// Says how to get a tmam that writes it.
///
/// # Errors
/// Always.
pub fn write(
    _out: impl Write,
    _name: TableName<'_>,
    _setting: &Setting<'_>,
    _outcome: &Outcome,
    _truth: &TruthOf<'_>,
) -> io::Result<()> {
    Err(io::Error::other(
        "this tmam was built without the feature `parquet` and writes no tables; `cargo install tmam-replay` \
         builds one that does",
    ))
}
