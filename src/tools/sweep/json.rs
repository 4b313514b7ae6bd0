//! A sweep in JSON (`tmam.sweep/1`).

use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::columns::columns;
use super::score::Score;
use super::{Cell, CellError, Sweep};
use crate::core::rounding::rounded;

/// Writes every cell, the best first.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write(mut out: impl Write, sweep: &Sweep) -> io::Result<()> {
    let axes: Vec<Value> = sweep
        .grid
        .axes()
        .iter()
        .map(|axis| {
            json!({
                "key": axis.key(),
                "unit": axis.unit_name(),
                "values": axis.values,
            })
        })
        .collect();
    let ranked_by: Vec<&str> = sweep.ranked_by.iter().map(|column| column.name).collect();
    let whole = json!({
        "schema": "tmam.sweep/1",
        "tool": { "name": "tmam", "version": env!("CARGO_PKG_VERSION") },
        "source": { "file": sweep.file, "complete": sweep.complete },
        "truth": sweep.with_truth,
        "axes": axes,
        "ranked_by": ranked_by,
        "configured": row(sweep, json!(sweep.configured.values), &sweep.configured.score),
        "cells": sweep.cells.iter().map(|cell| of_cell(sweep, cell)).collect::<Vec<Value>>(),
    });
    serde_json::to_writer_pretty(&mut out, &whole)?;
    out.write_all(b"\n")
}

fn of_cell(sweep: &Sweep, cell: &Cell) -> Value {
    row(sweep, json!(sweep.grid.values(cell.index)), &cell.score)
}

/// What some values come to.
fn row(sweep: &Sweep, values: Value, score: &Result<Score, CellError>) -> Value {
    match score {
        Ok(score) => {
            let numbers: Map<String, Value> = columns(sweep.with_truth)
                .map(|column| {
                    let value = (column.of)(score).map(rounded);
                    // What counts is a whole number.
                    let number = match value {
                        Some(x) if column.scale == 1.0 && column.decimals == 0 => json!(x as u64),
                        other => json!(other),
                    };
                    (column.name.to_owned(), number)
                })
                .collect();
            json!({ "values": values, "scores": numbers })
        }
        Err(error) => json!({ "values": values, "failed": error.to_string() }),
    }
}
