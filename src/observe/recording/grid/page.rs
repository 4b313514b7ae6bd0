//! The page beside the pictures: the best cells, what follows, and how to read it.

use std::fmt::Write as _;

use rerun::TextDocument;

use crate::observe::drawing::Grid;

/// Cells in the table.
const ROWS: usize = 20;
/// Width of the table in characters, each column with a gap behind it: more would be cut.
const WIDTH: usize = 72;
const GAP: usize = 2;

pub fn page(grid: &Grid) -> TextDocument {
    let failed = grid.cells.iter().filter(|cell| cell.numbers.is_none());
    let failed = match failed.count() {
        0 => String::new(),
        n => format!("; {n} could not be replayed"),
    };
    TextDocument::from_markdown(format!(
        "# Sweep of {}\n\n{}\n{}\n{} of {} cells, the best first, {}{failed}. `--csv` has all of them with every \
         column.\n\n{HOW_TO_READ}",
        grid.file,
        grid.conclusion,
        table(grid),
        grid.cells.len().min(ROWS),
        grid.cells.len(),
        grid.ranked_by,
    ))
}

/// The best cells, in as many columns as have room: first the keys, then what cells are ranked by.
fn table(grid: &Grid) -> String {
    // A name with a bar would end its column.
    let keys = grid.axes.iter().map(|axis| axis.heading.replace('|', "/"));
    let heads = keys.chain(grid.columns.iter().map(|column| column.heading.clone()));
    let mut rows = vec![heads.collect::<Vec<String>>()];
    for cell in grid.cells.iter().take(ROWS) {
        let Some(numbers) = &cell.numbers else { break };
        let values = grid.axes.iter().zip(&cell.places);
        let values = values.filter_map(|(axis, place)| axis.values.get(*place));
        let values = values.map(ToString::to_string);
        let numbers = grid.columns.iter().zip(numbers);
        let numbers = numbers.map(|(column, number)| column.text(*number));
        rows.push(values.chain(numbers).collect());
    }
    let fitting = fitting(&rows);
    let mut text = String::new();
    for (place, row) in rows.iter().enumerate() {
        let cells = row.get(..fitting).unwrap_or(row);
        // Writing into a string cannot fail.
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

const HOW_TO_READ: &str = include_str!("page.md");

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
