//! The rule line by line, the second opinion, and what would have changed the label.

use std::fmt::Write as _;

use super::degrees;
use crate::tools::explain::Explanation;
use crate::tools::explain::rule::{Change, Condition};
use crate::tools::explain::windows::Window;
use crate::tools::tables::{render, table};

/// What the rule's part is called.
pub fn title(told: &Explanation) -> &'static str {
    match (is_triple(told), told.decided_by) {
        (false, _) => "ANGLES THAT IT WOULD HAVE AS THE MIDDLE OF A TRIPLE",
        (true, "angles") => "THE RULE",
        (true, _) => "WHAT THE PAPER'S RULE WOULD SAY",
    }
}

fn is_triple(told: &Explanation) -> bool {
    !matches!(told.reason, Some("missing" | "gap" | "turning"))
}

/// Both angles and the rule on them.
pub fn angles(told: &Explanation) -> String {
    let mut text = String::new();
    let Some(angles) = &told.angles else {
        return text;
    };
    let full = format!(
        "{}: the full beam width, for want of such points on a common side",
        degrees(told.arc.beam_width)
    );
    for (name, what, angle, sigma, has) in [
        (
            "theta_c",
            "contact",
            angles.theta_c,
            angles.theta_c_sigma,
            angles.has_contact,
        ),
        (
            "theta_i",
            "intersection",
            angles.theta_i,
            angles.theta_i_sigma,
            angles.has_intersection,
        ),
    ] {
        let said = match (has, sigma) {
            (false, _) => full.clone(),
            (true, None) => format!("{} between {what} points", degrees(angle)),
            (true, Some(sigma)) => format!(
                "{} +- {} between {what} points",
                degrees(angle),
                degrees(sigma)
            ),
        };
        let _ = writeln!(text, "  {name}  {said}");
    }
    for condition in &angles.conditions {
        let _ = writeln!(text, "  {}", comparison(condition));
    }
    let margin = degrees(angles.margin);
    let _ = match angles.reason {
        None => writeln!(text, "  so {}, with {margin} to spare", angles.label),
        Some(reason) => writeln!(
            text,
            "  so unidentified ({reason}); {margin} short of the nearer label"
        ),
    };
    let apart = (angles.theta_c - angles.theta_i).abs();
    if let (Some(c), Some(i)) = (angles.theta_c_sigma, angles.theta_i_sigma)
        && angles.has_contact
        && angles.has_intersection
        && apart < (c * c + i * i).sqrt()
    {
        text.push_str(
            "  The two angles differ by less than noise spreads them: too short a base line to decide.\n",
        );
    }
    text
}

fn comparison(condition: &Condition) -> String {
    let bound = degrees(condition.bound);
    let bound = match condition.times {
        Some(times) if times > 0.0 => format!(
            "{} * theta_i = {:.3} * {} = {bound}",
            condition.parameter,
            condition.bound / times,
            degrees(times)
        ),
        Some(_) => format!("{} * theta_i = {bound}", condition.parameter),
        None => format!("{} = {bound}", condition.parameter),
    };
    let left = format!(
        "{} {} {} {bound}",
        condition.angle,
        degrees(condition.value),
        condition.relation
    );
    format!(
        "{:<13} {left:<66} {}",
        condition.label,
        if condition.holds { "yes" } else { "no" }
    )
}

/// The second opinion, window by window.
pub fn windows(told: &Explanation) -> String {
    let mut rows = table(
        &[
            "readings",
            "frames",
            "chi2 line",
            "chi2 point",
            "gate",
            "supports",
        ],
        0,
    );
    for window in &told.windows {
        rows.add_row([
            (2 * window.half_width + 1).to_string(),
            format!("{}-{}", window.first_frame, window.last_frame),
            chi2(window.chi2_line),
            chi2(window.chi2_point),
            chi2(window.gate),
            window.support.to_owned(),
        ]);
    }
    let mut text = render(&rows);
    if let Some(last) = told.windows.last() {
        let _ = writeln!(text, "  {}", end(told, last));
    }
    text
}

/// A chi2; infinite where the beams have no place for the model.
pub fn chi2(x: f64) -> String {
    if x.is_finite() {
        format!("{x:.2}")
    } else {
        "none".to_owned()
    }
}

fn end(told: &Explanation, last: &Window) -> String {
    let readings = 2 * last.half_width + 1;
    let lead = (last.chi2_line - last.chi2_point).abs();
    let decisive = told.decisive;
    match (told.windows_end, last.decides) {
        (_, Some(kind)) if lead.is_finite() => format!(
            "{readings} readings decide: a {kind}, ahead by {lead:.2} (opinion.decisive is {decisive})"
        ),
        (_, Some(kind)) => {
            format!("{readings} readings decide: a {kind}; the beams have no place for the other")
        }
        (Some("neither"), _) => {
            format!("{readings} readings fit neither a line nor a point: no wider window is asked")
        }
        (Some("max-half-width"), _) => format!(
            "undecided within opinion.max_half_width: a lead of {lead:.2}, {decisive} is needed"
        ),
        _ => format!(
            "undecided, and the sequence has no more readings: a lead of {lead:.2}, {decisive} is \
             needed"
        ),
    }
}

/// What would have given another label.
pub fn changes(told: &Explanation) -> String {
    told.changes.iter().fold(String::new(), |mut text, change| {
        let _ = writeln!(text, "  {:<13} {}", change.label, how(told, change));
        text
    })
}

fn how(told: &Explanation, change: &Change) -> String {
    if let Some(why) = change.impossible {
        return format!("not here: {why}");
    }
    // Windows may change their mind more than once; the rule's bounds and the sequence's do not.
    let by_windows = told.decided_by == "opinion" && is_triple(told);
    let needs: Vec<String> = change
        .needs
        .iter()
        .filter_map(|need| {
            let flag = need.flag()?;
            Some(match (by_windows, need.relation.is_upward()) {
                (true, _) => flag,
                (false, true) => format!("{flag} or more"),
                (false, false) => format!("{flag} or less"),
            })
        })
        .collect();
    format!("with {}", needs.join(" and "))
}
