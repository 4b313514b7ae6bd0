//! An explanation for a person: degrees, millimetres and metres, within 100 columns.

mod decision;
mod geometry;
mod history;
mod suspects;

use std::fmt::Write as _;

use super::Explanation;
use super::doubts::Doubt;
use super::situation::{Between, Neighbour, Obstacle, Reading, Situation};
use super::suspects::command;
use crate::core::observer::Setting;
use crate::tools::tables::{render, table};
pub use suspects::suspects;

/// An arc that passes farther from a place than this is hardly the one that was meant, metres.
const FAR: f64 = 0.3;

/// The whole story of an arc. `log` is how the log was named on the command line.
pub fn text(setting: &Setting<'_>, log: &str, told: &Explanation) -> String {
    let mut text = head(setting, told);
    section(&mut text, "READINGS", &readings(told));
    if !told.pairs.is_empty() {
        let title = "PAIRS (bearings off the beam's axis, left is positive)";
        section(&mut text, title, &geometry::pairs(told));
    }
    if told.angles.is_some() {
        section(&mut text, decision::title(told), &decision::angles(told));
    }
    if !told.windows.is_empty() {
        section(
            &mut text,
            "SECOND OPINION (squares that remain of the best line and of the best point)",
            &decision::windows(told),
        );
    }
    if !told.changes.is_empty() {
        section(&mut text, "WHAT WOULD CHANGE IT", &decision::changes(told));
    }
    section(&mut text, "RUN AND FEATURE", &history::runs(told));
    if let Some(truth) = &told.truth {
        section(&mut text, "TRUTH", &history::truth(truth));
    }
    if !told.also_near.is_empty() {
        section(&mut text, "OTHER ARCS THAT PASS NEAR", &near(log, told));
    }
    text
}

/// Writing into a string cannot fail.
fn section(text: &mut String, title: &str, body: &str) {
    let _ = write!(text, "\n{title}\n{body}");
}

fn degrees(angle: f64) -> String {
    format!("{:.2} deg", angle.to_degrees())
}

fn place([x, y]: [f64; 2]) -> String {
    format!("({x:.3}, {y:.3})")
}

fn head(setting: &Setting<'_>, told: &Explanation) -> String {
    let arc = &told.arc;
    let what = match (told.label, told.reason) {
        ("contact", _) => "CONTACT: taken for part of a wall".to_owned(),
        ("intersection", _) => "INTERSECTION: taken for a point".to_owned(),
        (_, reason) => format!("UNIDENTIFIED: {}", why(reason.unwrap_or_default())),
    };
    let mut text = format!(
        "{}, frame {}, {:.3} s after the first reading of {}{}\n{what}\n",
        told.sensor,
        arc.frame,
        arc.seconds,
        setting.source.file,
        if setting.source.complete {
            ""
        } else {
            " (INCOMPLETE)"
        },
    );
    if let Some(distance) = told.distance {
        let millimetres = distance * 1e3;
        let _ = if distance > FAR {
            writeln!(
                text,
                "No arc passes near the place asked for: this one, the nearest, passes {millimetres:.1} mm from it."
            )
        } else {
            writeln!(
                text,
                "It passes {millimetres:.1} mm from the place asked for."
            )
        };
    }
    // What one types has three decimals at most.
    if let Some(late) = told.late.filter(|late| late.abs() > 1e-3) {
        let when = if late > 0.0 { "after" } else { "before" };
        let _ = writeln!(
            text,
            "It was measured {:.3} s {when} the time asked for: none of this sonar is nearer.",
            late.abs()
        );
    }
    for doubt in &told.doubts {
        let _ = writeln!(text, "SUSPECT: {}", contradiction(doubt));
    }
    if told.label != "unidentified" && !told.suspect {
        text.push_str("Not suspect: neither its readings nor the map contradict the label.\n");
    }
    if let Some(right) = told.truth.as_ref().and_then(|truth| truth.right) {
        let verdict = if right { "right" } else { "WRONG" };
        let _ = writeln!(text, "In truth the label is {verdict}.");
    }
    text
}

/// What a doubt says, in words.
fn contradiction(doubt: &Doubt) -> String {
    let says = match doubt.says {
        "line" => "only a line explains",
        "point" => "only a point explains",
        _ => "neither a line nor a point explains",
    };
    match (doubt.by, doubt.readings) {
        ("triple", _) => format!("{says} its three readings"),
        ("window", Some(n)) => format!("{says} the {n} readings around it"),
        ("run", Some(n)) => format!("{says} all {n} readings of its run"),
        _ => format!(
            "in the map of all readings it is a {} that explains it",
            doubt.says
        ),
    }
}

/// Why an arc is unidentified, in words.
fn why(reason: &str) -> &'static str {
    match reason {
        "missing" => "no echo before or after it, so no triple",
        "gap" => "a neighbour is too far in time or distance, so no triple",
        "turning" => "the sensor turned, or its path bent, so no triple",
        "no-points" => "neither contact nor intersection points on a common side",
        "wide" => "the smaller angle is not below gamma",
        "ambiguous" => "a line and a point explain it too nearly equally well",
        "neither" => "its readings come from neither one line nor one point",
        _ => "no reason is known",
    }
}

fn readings(told: &Explanation) -> String {
    let mut rows = table(
        &[
            "", "frame", "time s", "x m", "y m", "yaw deg", "range m", "sigma mm", "beam deg",
        ],
        1,
    );
    let mut row = |name: &str, reading: &Reading| {
        rows.add_row([
            name.to_owned(),
            reading.frame.to_string(),
            format!("{:.3}", reading.seconds),
            format!("{:.4}", reading.x),
            format!("{:.4}", reading.y),
            format!("{:.2}", reading.yaw.to_degrees()),
            format!("{:.4}", reading.range),
            format!("{:.2}", reading.sigma * 1e3),
            format!("{:.1}", reading.beam_width.to_degrees()),
        ]);
    };
    let situation = &told.situation;
    if let Neighbour::Echo(reading) = &situation.before {
        row("before", reading);
    }
    row("this arc", &told.arc);
    if let Neighbour::Echo(reading) = &situation.after {
        row("after", reading);
    }
    let mut text = render(&rows);
    for (neighbour, side) in [(&situation.before, "before"), (&situation.after, "after")] {
        match neighbour {
            Neighbour::Echo(_) => {}
            Neighbour::NoEcho { frame } => {
                let _ = writeln!(
                    text,
                    "  The sonar's reading {side} it, in frame {frame}, had no echo."
                );
            }
            Neighbour::End => {
                let _ = writeln!(text, "  The sonar has no reading {side} it.");
            }
        }
    }
    for obstacle in &situation.obstacles {
        let _ = writeln!(text, "  Not a triple: {}.", broken(obstacle, situation));
    }
    text
}

fn broken(obstacle: &Obstacle, situation: &Situation) -> String {
    let from = match (obstacle.between, &situation.before, &situation.after) {
        (Between::Before, Neighbour::Echo(other), _) => {
            format!("from the reading before (frame {})", other.frame)
        }
        (Between::After, _, Neighbour::Echo(other)) => {
            format!("to the reading after (frame {})", other.frame)
        }
        _ => "between the way to it and the way on".to_owned(),
    };
    let (found, allowed) = (obstacle.found, obstacle.allowed);
    let key = obstacle.key;
    match key {
        "sequence.max_gap" => format!("{found:.3} s {from}; {key} is {allowed:.3}"),
        "sequence.max_baseline" => format!("{found:.3} m {from}; {key} is {allowed:.3}"),
        "triple.turn_tolerance" => format!(
            "the beam turned by {} {from}; {key} is {:.2}",
            degrees(found),
            allowed.to_degrees()
        ),
        _ => format!(
            "the path bends by {} {from}; {key} is {:.2}",
            degrees(found),
            allowed.to_degrees()
        ),
    }
}

fn near(log: &str, told: &Explanation) -> String {
    told.also_near.iter().fold(String::new(), |mut text, near| {
        let _ = writeln!(
            text,
            "  {:8.1} mm  tmam explain {log} {}",
            near.distance.unwrap_or_default() * 1e3,
            command(&near.sensor, near.frame)
        );
        text
    })
}
