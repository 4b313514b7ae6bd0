//! A sweep for a person: the best cells, and what follows from them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::columns::{Better, Column, columns};
use super::grid::Axis;
use super::result::{Lead, LeadDifference, Sweep};
use crate::core::legible::one_line;
use crate::core::rounding::fixed;
use crate::core::wording::counted;
use crate::io::log::itemised;
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
    text.push_str(&conclusion(sweep));
    text
}

fn head(sweep: &Sweep) -> String {
    let axes = sweep.grid.axes().iter();
    let axes = axes.map(|axis| format!("{} x {}", axis.values.len(), axis.key()));
    let ranked = sweep.ranked_by.iter().map(|column| {
        let better = match column.better {
            Better::Low => "low",
            Better::High => "high",
        };
        format!("{} ({better})", column.name)
    });
    format!(
        "{}{}: {}, {}; {}\nranked by {}\n\n",
        one_line(&sweep.log.file),
        if sweep.log.is_complete() {
            ""
        } else {
            " (INCOMPLETE)"
        },
        counted(sweep.cells.len() as u64, "cell"),
        axes.collect::<Vec<_>>().join(", "),
        if sweep.with_truth {
            "held against the truth"
        } else {
            "without the truth"
        },
        ranked.collect::<Vec<_>>().join(", then "),
    )
}

fn best(sweep: &Sweep, rows: usize) -> String {
    let ranks = |column: &Column| sweep.ranked_by.iter().any(|one| one.name == column.name);
    let is_shown = |column: &&Column| {
        // With those of the truth there is no room for all.
        let fits = !sweep.with_truth || !matches!(column.name, "chi2" | "rms" | "sound_share");
        ranks(column) || fits && !column.head.is_empty()
    };
    let shown: Vec<&Column> = columns(sweep.with_truth).filter(is_shown).collect();
    let heads: Vec<String> = (sweep.grid.axes().iter().map(Axis::heading))
        .chain(shown.iter().map(|column| column.heading().to_owned()))
        .collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = table(&heads, 0);
    for cell in sweep.cells.iter().take(rows) {
        let Ok(score) = &cell.score else { break };
        let values = sweep.grid.values(cell.index).into_iter();
        let values = values.map(|value| value.to_string());
        let numbers = shown.iter().map(|column| column.number((column.of)(score)));
        table.add_row(values.chain(numbers));
    }
    render(&table)
}

fn failures(sweep: &Sweep) -> String {
    // By reason: how many cells, and the first of them.
    let mut reasons: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for cell in &sweep.cells {
        if let Err(error) = &cell.score {
            let reason = reasons.entry(error.to_string()).or_insert((0, cell.index));
            reason.0 += 1;
        }
    }
    let mut text = String::new();
    let mut reasons: Vec<_> = reasons.into_iter().collect();
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
    for note in &sweep.log.notes {
        let _ = writeln!(text, "note: {note}");
    }
    if !sweep.log.losses.is_empty() {
        let losses = itemised(&sweep.log.losses);
        let file = one_line(&sweep.log.file);
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

/// The best cell as flags, its lead over what is configured, and whether a better one may lie outside
/// the grid.
pub fn conclusion(sweep: &Sweep) -> String {
    let Some((cell, best)) = sweep.best() else {
        return String::new();
    };
    if sweep
        .ranked_by
        .iter()
        .all(|column| (column.of)(best).is_none())
    {
        return "Nothing ranks these cells: only TMAM's map says what should have echoed. --truth WORLD.json, or \
                --sort by what is counted, does.\n"
            .to_owned();
    }
    if sweep.is_flat() {
        return "All cells are alike: nothing that was swept makes a difference here.\n".to_owned();
    }
    let mut text = String::new();
    // Writing into a string cannot fail.
    let flags = sweep.grid.flags(cell.index);
    let _ = writeln!(
        text,
        "best: {flags}\n  as flags of tmam replay, beside the others given here"
    );
    let alike = sweep.leaders().count() - 1;
    if alike > 0 {
        let _ = writeln!(text, "  {alike} other cells do just as well");
    }
    for (place, axis) in sweep.grid.axes().iter().enumerate() {
        text.push_str(&along(sweep, place, axis));
    }
    let _ = write!(
        text,
        "configured: {}\n  {}\n",
        configured(sweep),
        lead(sweep)
    );
    text
}

/// What is configured of what is swept.
pub fn configured(sweep: &Sweep) -> String {
    let axes = sweep.grid.axes().iter();
    let values = axes.zip(&sweep.configured.values).map(|(axis, value)| {
        let key = axis.key();
        value.map_or_else(
            || format!("{key} as each message has it"),
            |value| format!("{key}={value}"),
        )
    });
    values.collect::<Vec<String>>().join(" ")
}

/// How far the best cell leads.
pub fn lead(sweep: &Sweep) -> String {
    match sweep.lead() {
        None => String::new(),
        Some(Lead::Alike) => "the best cell is no better than that".to_owned(),
        Some(Lead::Failed(problem)) => format!("cannot be replayed: {problem}"),
        Some(Lead::Better(difference)) => {
            let small = if difference.is_small() || sweep.is_tie() {
                "; that is next to nothing: take it for a tie, and keep what is configured"
            } else {
                ""
            };
            format!("the best cell is better {}{small}", by(sweep, &difference))
        }
        Some(Lead::Worse(difference)) => format!(
            "no cell is as good as that; the best one is worse {}",
            by(sweep, &difference)
        ),
    }
}

fn by(sweep: &Sweep, difference: &LeadDifference) -> String {
    let column = difference.column;
    let before = sweep.ranked_by.iter().take(difference.alike);
    let before: Vec<&str> = before.map(|column| column.heading()).collect();
    let alike = match before.as_slice() {
        [] => String::new(),
        names => format!(", alike in {}", names.join(" and ")),
    };
    let numbers = format!(
        "({} against {}{alike})",
        column.number(difference.best),
        column.number(difference.configured)
    );
    match (difference.best, difference.configured) {
        (Some(best), Some(configured)) if !difference.is_small() => {
            let lead = column.number(Some((best - configured).abs()));
            format!("by {lead} {} {numbers}", column.heading())
        }
        (Some(_), Some(_)) => {
            let least = column.least();
            format!("by less than {least} {} {numbers}", column.heading())
        }
        _ => format!("in {} {numbers}", column.heading()),
    }
}

/// Where the best cells lie among the values of a key.
fn along(sweep: &Sweep, place: usize, axis: &Axis) -> String {
    let count = axis.values.len();
    let mut held = vec![false; count];
    for cell in sweep.leaders() {
        let at = sweep.grid.places(cell.index).get(place).copied();
        if let Some(held) = at.and_then(|at| held.get_mut(at)) {
            *held = true;
        }
    }
    let key = axis.key();
    if matches!(sweep.lead(), Some(Lead::Better(_)))
        && !sweep.is_tie()
        && let Some(value) = sweep.interpolated(place)
    {
        return format!(
            "  {key} is best at about {} between its values\n",
            significant(value, axis)
        );
    }
    if count > 1 && held.iter().all(|held| *held) {
        return format!("  {key} makes no difference among them: every value is as good\n");
    }
    let mut inner = held.iter().skip(1).take(count.saturating_sub(2));
    if count > 2 && !inner.any(|held| *held) {
        return format!("  {key} is best at an end of its values: sweep on beyond it\n");
    }
    String::new()
}

/// A value to a tenth of the step between an axis's values.
fn significant(value: f64, axis: &Axis) -> String {
    let steps = axis.values.array_windows().map(|[a, b]| (b - a).abs());
    let step = steps.fold(f64::INFINITY, f64::min);
    let decimals = libm::ceil(1.0 - libm::log10(step)).clamp(0.0, 9.0) as usize;
    fixed(value, decimals)
}
