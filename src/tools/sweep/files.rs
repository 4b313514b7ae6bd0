//! A sweep for other programs: every cell, the best first, in CSV and in JSON (`tmam.sweep/1`), and what is
//! drawn of it.

use std::fmt::Write as _;
use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::columns::{Better, Column, columns};
use super::grid::Axis;
use super::result::{Cell, Sweep};
use super::runner::CellError;
use super::score::Score;
use super::text::conclusion;
use crate::core::tool::Tool;
use crate::observe::drawing;

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

/// Numbers that are drawn of every cell.
const MOST_COLUMNS: usize = 4;

/// What is drawn of a sweep: the keys with several values, and the numbers that tell most.
///
/// # Errors
/// Never in practice: it is written to memory.
pub fn drawn(sweep: &Sweep) -> io::Result<drawing::DrawnGrid> {
    let mut content = Vec::new();
    json(&mut content, sweep)?;
    let axes = sweep.grid.axes().iter().enumerate();
    let swept: Vec<(usize, &Axis)> = axes.filter(|(_, axis)| axis.values.len() > 1).collect();
    let columns = drawn_columns(sweep);
    let cell = |cell: &Cell| {
        let places = sweep.grid.places(cell.index);
        let places = swept.iter().filter_map(|(axis, _)| places.get(*axis));
        let score = cell.score.as_ref().ok();
        drawing::DrawnCell {
            places: places.copied().collect(),
            numbers: score.map(|score| columns.iter().map(|column| (column.of)(score)).collect()),
        }
    };
    Ok(drawing::DrawnGrid {
        file: sweep.log.file.clone(),
        content,
        conclusion: lines(sweep),
        ranked_by: if sweep.with_truth {
            "by the truth"
        } else {
            "without the truth"
        },
        axes: swept
            .iter()
            .map(|(place, axis)| drawing::DrawnAxis {
                short: axis.short(),
                name: match axis.unit_name() {
                    "" => axis.key(),
                    unit => format!("{}, {unit}", axis.key()),
                },
                heading: axis.heading(),
                values: axis.values.clone(),
                configured: sweep.configured.values.get(*place).copied().flatten(),
            })
            .collect(),
        columns: columns
            .iter()
            .map(|column| drawing::DrawnColumn {
                heading: column.heading().to_owned(),
                low_is_better: column.better == Better::Low,
                decimals: column.decimals,
                scale: column.scale,
            })
            .collect(),
        cells: sweep.cells.iter().map(cell).collect(),
        best: if sweep.is_flat() {
            0
        } else {
            sweep.leaders().count()
        },
    })
}

fn lines(sweep: &Sweep) -> String {
    let mut text = String::new();
    // Writing into a string cannot fail.
    for line in conclusion(sweep).lines() {
        let _ = writeln!(text, "{}  ", line.trim_start());
    }
    for note in &sweep.log.notes {
        let _ = writeln!(text, "\nNote: {note}");
    }
    text
}

/// The columns that are drawn: what the cells are ranked by, and what tells most beside it.
fn drawn_columns(sweep: &Sweep) -> Vec<&'static Column> {
    let told = ["bits", "explained_share", "suspect_share", "labelled_share"];
    let of_name = |name| columns(sweep.with_truth).find(|column| column.name == name);
    let mut drawn: Vec<&'static Column> = Vec::new();
    for column in (sweep.ranked_by.iter().copied()).chain(told.into_iter().filter_map(of_name)) {
        let scores = sweep
            .cells
            .iter()
            .filter_map(|cell| cell.score.as_ref().ok());
        let tells = scores.filter_map(column.of).next().is_some();
        if tells && drawn.iter().all(|c| c.name != column.name) {
            drawn.push(column);
        }
    }
    drawn.truncate(MOST_COLUMNS);
    drawn
}
