//! A sweep for other programs: every cell, the best first, in CSV and in JSON (`tmam.sweep/1`).

use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::columns::columns;
use super::result::{Cell, Sweep};
use super::runner::CellError;
use super::score::Score;
use crate::core::tool::Tool;

/// Writes every cell in CSV: its rank, its values as `--set` takes them, its numbers, and why it failed.
///
/// # Errors
/// When `out` cannot be written to.
pub fn csv(out: impl Write, sweep: &Sweep) -> io::Result<()> {
    let mut csv = ::csv::Writer::from_writer(out);
    let columns: Vec<_> = columns(sweep.with_truth).collect();
    let axes = sweep.grid.axes().iter().map(|axis| match axis.unit_name() {
        "" => axis.key(),
        unit => format!("{} [{unit}]", axis.key()),
    });
    let head = std::iter::once("rank".to_owned())
        .chain(axes)
        .chain(columns.iter().map(|column| column.name.to_owned()))
        .chain(std::iter::once("failed".to_owned()));
    csv.write_record(head)?;
    for (rank, cell) in sweep.cells.iter().enumerate() {
        let values = sweep.grid.values(cell.index).into_iter();
        let score = cell.score.as_ref();
        let numbers = columns.iter().map(|column| {
            let number = score.ok().and_then(|score| column.rounded(score));
            number.map_or_else(String::new, |number| number.to_string())
        });
        let failed = score.err().map_or_else(String::new, ToString::to_string);
        let record = std::iter::once((rank + 1).to_string())
            .chain(values.map(|value| value.to_string()))
            .chain(numbers)
            .chain(std::iter::once(failed));
        csv.write_record(record)?;
    }
    csv.flush()
}

/// Writes every cell in JSON.
///
/// # Errors
/// When `out` cannot be written to.
pub fn json(mut out: impl Write, sweep: &Sweep) -> io::Result<()> {
    let axes =
        sweep.grid.axes().iter().map(
            |axis| json!({ "key": axis.key(), "unit": axis.unit_name(), "values": axis.values }),
        );
    let ranked_by = sweep.ranked_by.iter().map(|column| column.name);
    let of_cell = |cell: &Cell| row(sweep, json!(sweep.grid.values(cell.index)), &cell.score);
    let configured = &sweep.configured;
    let whole = json!({
        "schema": "tmam.sweep/1",
        "tool": Tool::THIS,
        "source": { "file": sweep.log.file, "complete": sweep.log.is_complete() },
        "truth": sweep.with_truth,
        "axes": axes.collect::<Vec<Value>>(),
        "ranked_by": ranked_by.collect::<Vec<&str>>(),
        "configured": row(sweep, json!(configured.values), &configured.score),
        "cells": sweep.cells.iter().map(of_cell).collect::<Vec<Value>>(),
    });
    serde_json::to_writer_pretty(&mut out, &whole)?;
    out.write_all(b"\n")
}

/// What some values come to.
fn row(sweep: &Sweep, values: Value, score: &Result<Score, CellError>) -> Value {
    let score = match score {
        Ok(score) => score,
        Err(error) => return json!({ "values": values, "failed": error.to_string() }),
    };
    let scores = columns(sweep.with_truth).map(|column| {
        let number = match column.rounded(score) {
            Some(count) if column.is_count() => json!(count as u64),
            other => json!(other),
        };
        (column.name.to_owned(), number)
    });
    json!({ "values": values, "scores": scores.collect::<Map<String, Value>>() })
}
