//! A sweep as a table for other programs.

use std::io;

use super::Sweep;
use super::columns::columns;
use crate::core::rounding::rounded;

/// Writes every cell, the best first: its rank, its values as `--set` takes them, its numbers, and
/// why it failed.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write(out: impl io::Write, sweep: &Sweep) -> io::Result<()> {
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
            let value = score.ok().and_then(|score| (column.of)(score));
            value.map_or_else(String::new, |value| rounded(value).to_string())
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
