//! A sweep as something to draw.

use std::fmt::Write as _;
use std::io;

use super::columns::{Better, Column, columns};
use super::files;
use super::grid::Axis;
use super::result::{Cell, Sweep};
use super::text::conclusion;
use crate::observe::drawing;

/// Numbers that are drawn of every cell.
const MOST_COLUMNS: usize = 4;

/// What is drawn of a sweep: the keys with several values, and the numbers that tell most.
///
/// # Errors
/// Never in practice: it is written to memory.
pub fn grid(sweep: &Sweep) -> io::Result<drawing::Grid> {
    let mut content = Vec::new();
    files::json(&mut content, sweep)?;
    let axes = sweep.grid.axes().iter().enumerate();
    let swept: Vec<(usize, &Axis)> = axes.filter(|(_, axis)| axis.values.len() > 1).collect();
    let columns = drawn(sweep);
    let cell = |cell: &Cell| {
        let places = sweep.grid.places(cell.index);
        let places = swept.iter().filter_map(|(axis, _)| places.get(*axis));
        let score = cell.score.as_ref().ok();
        drawing::Cell {
            places: places.copied().collect(),
            numbers: score.map(|score| columns.iter().map(|column| (column.of)(score)).collect()),
        }
    };
    Ok(drawing::Grid {
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
            .map(|(place, axis)| drawing::Axis {
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
            .map(|column| drawing::Column {
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
fn drawn(sweep: &Sweep) -> Vec<&'static Column> {
    let told = ["bits", "explained_share", "suspect_share", "labelled_share"];
    let of_name = |name| columns(sweep.with_truth).find(|column| column.name == name);
    let mut drawn: Vec<&'static Column> = Vec::new();
    for column in (sweep.ranked_by.iter().copied()).chain(told.into_iter().filter_map(of_name)) {
        let scores = sweep
            .cells
            .iter()
            .filter_map(|cell| cell.score.as_ref().ok());
        let tells = scores.filter_map(column.of).next().is_some();
        if tells && column.name != "sound_share" && drawn.iter().all(|c| c.name != column.name) {
            drawn.push(column);
        }
    }
    drawn.truncate(MOST_COLUMNS);
    drawn
}
