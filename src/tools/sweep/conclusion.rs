//! What follows from a sweep, in words: the best cell, what ties with it, and how far it leads over
//! what is configured.

use std::fmt::Write as _;

use super::Sweep;
use super::axes::Axis;
use super::configured::{Difference, Lead};

/// The best cell as flags, its lead, and whether a better one may lie outside the grid.
pub fn text(sweep: &Sweep) -> String {
    let Some((cell, _)) = sweep.best() else {
        return String::new();
    };
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
            let small = if difference.is_small() {
                "; that is next to nothing: take it for a tie"
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

fn by(sweep: &Sweep, difference: &Difference) -> String {
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
    if count > 1 && held.iter().all(|held| *held) {
        return format!("  {key} makes no difference among them: every value is as good\n");
    }
    let mut inner = held.iter().skip(1).take(count.saturating_sub(2));
    if count > 2 && !inner.any(|held| *held) {
        return format!("  {key} is best at an end of its values: sweep on beyond it\n");
    }
    String::new()
}
