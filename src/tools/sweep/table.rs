//! A sweep for a person: the best cells first.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::Sweep;
use super::axes::Axis;
use super::columns::{Better, columns};
use super::conclusion;
use crate::core::wording::counted;
use crate::tools::tables::{render, table};

/// Reasons of failure that are told.
const REASONS: usize = 5;

/// The best `rows` cells, and what follows from them.
pub fn text(sweep: &Sweep, rows: usize) -> String {
    let mut text = head(sweep);
    text.push_str(&best(sweep, rows));
    // Writing into a string cannot fail.
    let succeeded = sweep.cells.len() - sweep.failed();
    if succeeded > rows {
        let _ = writeln!(
            text,
            "  and {} more; --rows shows more of them, --csv FILE has all",
            succeeded - rows
        );
    }
    text.push_str(&failures(sweep));
    text.push('\n');
    text.push_str(&conclusion::text(sweep));
    text
}

fn head(sweep: &Sweep) -> String {
    let axes: Vec<String> = sweep
        .grid
        .axes()
        .iter()
        .map(|axis| format!("{} x {}", axis.values.len(), axis.key()))
        .collect();
    let ranked: Vec<String> = sweep
        .ranked_by
        .iter()
        .map(|column| {
            let better = match column.better {
                Better::Low => "low",
                Better::High => "high",
            };
            format!("{} ({better})", column.name)
        })
        .collect();
    format!(
        "{}{}: {}, {}; {}\nranked by {}\n\n",
        sweep.file,
        if sweep.complete { "" } else { " (INCOMPLETE)" },
        counted(sweep.cells.len() as u64, "cell"),
        axes.join(", "),
        if sweep.with_truth {
            "held against the truth"
        } else {
            "without the truth"
        },
        ranked.join(", then "),
    )
}

fn best(sweep: &Sweep, rows: usize) -> String {
    let shown: Vec<_> = columns(sweep.with_truth)
        .filter(|column| {
            let is_first = sweep.first_column().map(|first| first.name) == Some(column.name);
            // With those of the truth there is no room for all.
            let fits = !sweep.with_truth || !matches!(column.name, "chi2" | "rms");
            is_first || fits && !column.head.is_empty()
        })
        .collect();
    let axes = sweep.grid.axes().iter().map(Axis::heading);
    let heads: Vec<String> = axes
        .chain(shown.iter().map(|column| column.heading().to_owned()))
        .collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = table(&heads, 0);
    for cell in sweep.cells.iter().take(rows) {
        let Ok(score) = &cell.score else { break };
        let values = sweep.grid.values(cell.index).into_iter();
        let values = values.map(|value| value.to_string());
        table.add_row(values.chain(shown.iter().map(|column| column.text(score))));
    }
    render(&table)
}

fn failures(sweep: &Sweep) -> String {
    let mut reasons: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for cell in &sweep.cells {
        if let Err(error) = &cell.score {
            let reason = reasons.entry(error.to_string()).or_insert((0, cell.index));
            reason.0 += 1;
        }
    }
    let mut text = String::new();
    let mut reasons: Vec<(String, (usize, usize))> = reasons.into_iter().collect();
    reasons.sort_by_key(|(_, (_, first))| *first);
    for (reason, (count, first)) in reasons.iter().take(REASONS) {
        let also = match count {
            1 => String::new(),
            n => format!(" and {} more", n - 1),
        };
        let cell = sweep.grid.flags(*first);
        let _ = writeln!(text, "  failed: {cell}{also}: {reason}");
    }
    if reasons.len() > REASONS {
        let _ = writeln!(text, "  failed: {} more reasons", reasons.len() - REASONS);
    }
    text
}

/// What a person must know of the log.
pub fn problems(sweep: &Sweep) -> String {
    let mut text = String::new();
    for note in &sweep.notes {
        let _ = writeln!(text, "note: {note}");
    }
    if !sweep.losses.is_empty() {
        let losses = crate::io::log::itemised(&sweep.losses);
        let file = &sweep.file;
        let _ = writeln!(
            text,
            "warning: {file} could not be read whole. Lost:{losses}"
        );
    }
    if !sweep.has_arcs() {
        text.push_str(
            "warning: not one reading is an echo; look at range, min_range and max_range\n",
        );
    }
    text
}
