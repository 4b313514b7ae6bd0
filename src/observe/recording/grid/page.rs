//! The page beside the pictures: the best cells, what follows, and how to read it.

use std::fmt::Write as _;

use rerun::TextDocument;

use crate::tools::sweep::columns::Column;
use crate::tools::sweep::{Axis, Sweep, conclusion};

/// Cells in the table.
const ROWS: usize = 20;
/// Width of the table in characters, each column with a gap behind it: more would be cut.
const WIDTH: usize = 72;
const GAP: usize = 2;

/// The page; `columns` are those that are drawn.
pub fn page(sweep: &Sweep, columns: &[&'static Column]) -> TextDocument {
    let mut text = format!("# Sweep of {}\n\n", sweep.file);
    // Writing into a string cannot fail.
    for line in conclusion::text(sweep).lines() {
        let _ = writeln!(text, "{}  ", line.trim_start());
    }
    for note in &sweep.notes {
        let _ = writeln!(text, "\nNote: {note}");
    }
    text.push('\n');
    text.push_str(&table(sweep, columns));
    let shown = sweep.cells.len().min(ROWS);
    let failed = match sweep.failed() {
        0 => String::new(),
        n => format!("; {n} could not be replayed"),
    };
    let _ = write!(
        text,
        "\n{} of {} cells, the best first, {}{failed}. `--csv` has all of them with every column.\n\n{HOW_TO_READ}",
        shown,
        sweep.cells.len(),
        if sweep.with_truth {
            "by the truth"
        } else {
            "without the truth"
        },
    );
    TextDocument::from_markdown(text)
}

/// The best cells, in as many columns as have room: first the keys, then what cells are ranked by.
fn table(sweep: &Sweep, columns: &[&'static Column]) -> String {
    let axes: Vec<(usize, &Axis)> = sweep
        .grid
        .axes()
        .iter()
        .enumerate()
        .filter(|(_, axis)| axis.values.len() > 1)
        .collect();
    // A name with a bar would end its column.
    let heads = axes
        .iter()
        .map(|(_, axis)| axis.heading().replace('|', "/"));
    let heads = heads.chain(columns.iter().map(|c| c.heading().to_owned()));
    let mut rows = vec![heads.collect::<Vec<String>>()];
    for cell in sweep.cells.iter().take(ROWS) {
        let Ok(score) = &cell.score else { break };
        let values = sweep.grid.values(cell.index);
        let values = axes.iter().filter_map(|(place, _)| values.get(*place));
        let values = values.map(ToString::to_string);
        rows.push(
            values
                .chain(columns.iter().map(|c| c.text(score)))
                .collect(),
        );
    }
    let fitting = fitting(&rows);
    let mut text = String::new();
    for (place, row) in rows.iter().enumerate() {
        let cells = row.get(..fitting).unwrap_or(row);
        let _ = writeln!(text, "| {} |", cells.join(" | "));
        if place == 0 {
            let _ = writeln!(text, "|{}", " ---: |".repeat(cells.len()));
        }
    }
    text
}

/// How many columns have room; one at least.
fn fitting(rows: &[Vec<String>]) -> usize {
    let count = rows.first().map_or(0, Vec::len);
    let mut taken = 0;
    let fits = |column: &usize| {
        let cells = rows.iter().filter_map(|row| row.get(*column));
        taken += GAP + cells.map(|text| text.chars().count()).max().unwrap_or(0);
        taken <= WIDTH
    };
    (0..count).take_while(fits).count().max(1)
}

const HOW_TO_READ: &str = "\
## How to read it

Every picture shows one number of the table for every cell of the grid. In heat maps yellow is the best cell \
and dark blue the worst, whichever way is better; where more than two keys were swept, a place shows the one \
cell behind it that is best by the ranking, in every picture the same. Grey could not be replayed. Red frames, \
or lines, are the cells that are best by the ranking; white is where the configured values lie. Where numbers have no room in their cells, point at the dot in a cell to read its \
number.

**bits** - what it takes to write down a reading to the millimetre when the map is known, the map included. A \
wrong mount or a late clock puts readings beside the walls that other readings made, or doubles the walls; \
both cost bits. **explained** - share of the arcs that the noise-aware map explains. **suspect** - share of the \
labels that their own readings contradict. **labelled** - share of the arcs that got a label. **map errors** - \
walls and points that the map lacks, has twice, or invents. **wrong** - share of the labels that the truth \
contradicts.
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_would_be_cut_are_left_out() {
        let row = |widths: &[usize]| widths.iter().map(|n| "x".repeat(*n)).collect::<Vec<_>>();
        assert_eq!(fitting(&[row(&[20, 20, 20]), row(&[1, 1, 1])]), 3);
        assert_eq!(fitting(&[row(&[20, 20, 20]), row(&[1, 30, 1])]), 2);
        assert_eq!(fitting(&[row(&[200, 1])]), 1);
    }
}
