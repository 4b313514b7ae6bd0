//! Differences as reports tell them: in words, section by section, and as JSON.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value as Json;

use super::difference::{
    Change, Comparison, Difference, FeatureDifference, LabelRun, NumberChange, SECTIONS, State,
    Unit,
};
use super::results::{Feature, Geometry, Mark};
use crate::core::legible::inert_line;
use crate::core::wording::counted;

/// More differences of a section than this are counted, not listed.
pub const SHOWN: usize = 20;

/// A section of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// One of [`SECTIONS`].
    pub name: &'static str,
    pub heading: String,
    /// A line per difference.
    pub lines: Vec<String>,
}

/// The sections in which something differs; `recording` is where it can be looked at.
pub fn sections(found: &Comparison, recording: Option<&Path>, strict: bool) -> Vec<Section> {
    let section = |name| {
        let of_it = found.differences.iter().filter(|one| one.section() == name);
        Section {
            name,
            heading: heading(name, found, strict),
            lines: of_it.map(|one| look(one, recording)).collect(),
        }
    };
    let all = SECTIONS.into_iter().map(section);
    all.filter(|section| !section.lines.is_empty()).collect()
}

fn heading(name: &str, found: &Comparison, strict: bool) -> String {
    match (name, &found.label_counts) {
        ("labels", Some([golden, actual])) => {
            let counts = Mark::ALL
                .iter()
                .zip(golden)
                .zip(actual)
                .map(|((mark, then), now)| match then == now {
                    true => format!("{} {now}", mark.name()),
                    false => format!("{} {then} -> {now}", mark.name()),
                });
            format!("labels: {}", counts.collect::<Vec<_>>().join(", "))
        }
        ("borderline labels", _) => format!(
            "borderline labels (less than {} deg or chi2 {} to spare){}",
            (found.tolerance.borderline.to_degrees() * 1e4).round() / 1e4,
            found.tolerance.borderline_chi2,
            if strict {
                ""
            } else {
                ", which fail only with --strict"
            }
        ),
        _ => name.to_owned(),
    }
}

impl Section {
    /// The heading and its lines, as far as they are shown.
    pub fn listed(&self, shown: usize) -> String {
        let mut text = format!("{}\n", self.heading);
        for line in self.lines.iter().take(shown) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  {line}");
        }
        let more = self.lines.len().saturating_sub(shown);
        if more > 0 {
            let _ = writeln!(text, "  ... and {more} more (--show N, --json)");
        }
        text
    }
}

/// A difference in one line: what it was, what it is, by how much, in which frames. Names in it may
/// come from a log, and are made legible.
pub fn describe(difference: &Difference) -> String {
    look(difference, None)
}

fn look(difference: &Difference, recording: Option<&Path>) -> String {
    let mut text = in_words(difference);
    if let Some([first, last]) = difference.frames() {
        let span = in_frames([first, last]);
        let _ = write!(text, ", {span}");
        if let Some(path) = recording {
            let _ = write!(text, ", rerun {} at frame {first}", path.display());
        }
    }
    inert_line(&text)
}

fn in_words(difference: &Difference) -> String {
    match difference {
        Difference::Log { golden, actual } => {
            let [golden, actual] =
                [golden, actual].map(|digest| digest.get(..12).unwrap_or(digest));
            format!(
                "the log does not hold the events that were blessed: sha256 {golden} -> {actual}"
            )
        }
        Difference::Noise { changes } => format!("range noise: {}", joined(changes)),
        Difference::Sonar { sensor, changes } => format!("{sensor}: {}", joined(changes)),
        Difference::Map(feature) | Difference::Extracted(feature) => {
            feature_text(feature, matches!(difference, Difference::Extracted(_)))
        }
        Difference::Labels(run) | Difference::Borderline(run) => run_text(run),
    }
}

/// `frame 118` or `frames 118-164`.
fn in_frames([first, last]: [u32; 2]) -> String {
    if first == last {
        format!("frame {first}")
    } else {
        format!("frames {first}-{last}")
    }
}

fn joined(changes: &[Change]) -> String {
    changes.iter().map(change).collect::<Vec<_>>().join("; ")
}

fn feature_text(difference: &FeatureDifference, extracted: bool) -> String {
    let Some(feature) = difference.feature() else {
        return "a feature".to_owned();
    };
    let mut name = format!("{} {}", feature.kind().name(), feature.id);
    if extracted {
        name = format!("extracted {name}");
        if let Some(sensor) = &feature.sensor {
            let _ = write!(name, " of {sensor}");
        }
    }
    match difference.state {
        State::Missing => format!("{name} is missing{}", place(feature)),
        State::New => format!("{name} is new{}", place(feature)),
        State::Changed => format!("{name}: {}", joined(&difference.changes)),
    }
}

fn place(feature: &Feature) -> String {
    let place = match &feature.geometry {
        Geometry::Line(line) => {
            let ends = feature.geometry.ends().unwrap_or_default();
            let [from, to] = ends.map(|at| format!("({:.3}, {:.3})", at.x + 0.0, at.y + 0.0));
            let (rho, theta) = (line.rho, line.theta.to_degrees());
            format!(": rho {rho:.4} m, theta {theta:.2} deg, {from} to {to}")
        }
        Geometry::Point { x, y } => format!(": x {x:.4}, y {y:.4} m"),
        Geometry::Unfitted { .. } => {
            (feature.fate.as_ref()).map_or_else(String::new, |fate| format!(": {fate}"))
        }
    };
    match feature.readings {
        0 => place,
        n => format!("{place}, {}", counted(n.into(), "reading")),
    }
}

/// `rho 1.2043 -> 1.2391 m (+0.0348, tolerance 0.010)`.
fn change(change: &Change) -> String {
    let number = match change {
        Change::Number(number) => number,
        Change::Word {
            what,
            golden,
            actual,
        } => return format!("{what} {golden} -> {actual}"),
    };
    let NumberChange {
        what,
        unit,
        golden,
        actual,
        delta,
        tolerance,
    } = *number;
    match unit {
        Unit::Metres => {
            let tolerance = decimals(tolerance);
            let n = digits(delta, &tolerance, 4);
            format!("{what} {golden:.n$} -> {actual:.n$} m ({delta:+.n$}, tolerance {tolerance})")
        }
        Unit::Radians => {
            let tolerance = decimals(tolerance.to_degrees());
            let [golden, actual, delta] = [golden, actual, delta].map(f64::to_degrees);
            let n = digits(delta, &tolerance, 2);
            format!("{what} {golden:.n$} -> {actual:.n$} deg ({delta:+.n$}, tolerance {tolerance})")
        }
        Unit::Relative => {
            let tolerance = ((tolerance * 1e4).round() / 100.0).to_string();
            let percent = delta * 100.0;
            let n = digits(percent, &tolerance, 0);
            format!("{what} {golden:.6} -> {actual:.6} ({percent:+.n$} %, tolerance {tolerance} %)")
        }
        Unit::Count => format!("{what} {golden} -> {actual} ({delta:+}, tolerance {tolerance})"),
    }
}

/// How many decimals show that `delta` is more than the tolerance as it is written: `least`, where that
/// is enough.
fn digits(delta: f64, tolerance: &str, least: usize) -> usize {
    const MOST: usize = 7;
    let allowed: f64 = tolerance.parse().unwrap_or_default();
    let shown = |n: usize| format!("{:.n$}", delta.abs()).parse().unwrap_or(f64::NAN);
    (least..MOST).find(|n| shown(*n) > allowed).unwrap_or(MOST)
}

/// Three decimals, or as many as show what there is.
fn decimals(x: f64) -> String {
    if x == 0.0 || x >= 0.0005 {
        format!("{x:.3}")
    } else {
        format!("{x}")
    }
}

fn run_text(run: &LabelRun) -> String {
    let (sensor, arcs) = (&run.sensor, counted(run.arcs.len() as u64, "arc"));
    let at = run.arcs.first().map_or(0, |arc| arc.stamp_ns);
    match (run.golden, run.actual) {
        (Some(then), Some(now)) => {
            let why = run
                .reason
                .map_or_else(String::new, |reason| format!(" ({reason})"));
            format!(
                "{sensor}: {arcs} {} -> {}{why}{}",
                then.name(),
                now.name(),
                margins(run)
            )
        }
        (Some(then), None) => format!(
            "{sensor}: {arcs} gone, {} before, stamp {at} ns",
            then.name()
        ),
        (None, now) => {
            let now = now.map_or("none", Mark::name);
            format!("{sensor}: {arcs} new, {now}, stamp {at} ns")
        }
    }
}

fn margins(run: &LabelRun) -> String {
    let margins = || {
        run.arcs
            .iter()
            .filter_map(|arc| Some((arc.margin?, arc.margin_unit?)))
    };
    let least = margins().min_by(|a, b| a.0.total_cmp(&b.0));
    let most = margins().max_by(|a, b| a.0.total_cmp(&b.0));
    let (Some((least, unit)), Some((most, _))) = (least, most) else {
        return String::new();
    };
    let number = |margin: f64| match unit {
        "rad" => format!("{:.3}", margin.to_degrees()),
        _ => format!("{margin:.2}"),
    };
    let unit = if unit == "rad" { "deg" } else { unit };
    match (number(least), number(most)) {
        (least, most) if least == most => format!(", margin {least} {unit}"),
        (least, most) => format!(", margins {least} to {most} {unit}"),
    }
}

/// The differences as JSON, in SI units and radians: those that matter, and the borderline labels.
pub fn differences_in_json(found: &Comparison) -> [Vec<Json>; 2] {
    let mut lists = [Vec::new(), Vec::new()];
    let [clear, borderline] = &mut lists;
    for one in &found.differences {
        // Neither names nor numbers can fail to be JSON.
        let mut json = serde_json::to_value(one).unwrap_or_default();
        if one.is_borderline() {
            borderline.push(json);
            continue;
        }
        if let Some(fields) = json.as_object_mut() {
            fields.insert("text".to_owned(), describe(one).into());
        }
        clear.push(json);
    }
    lists
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_just_out_of_tolerance_does_not_read_as_within() {
        let number = |what, unit, golden: f64, actual: f64| {
            change(&Change::Number(NumberChange {
                what,
                unit,
                golden,
                actual,
                delta: actual - golden,
                tolerance: 0.01,
            }))
        };
        assert_eq!(
            number("rho", Unit::Metres, 0.0071, -0.00294),
            "rho 0.00710 -> -0.00294 m (-0.01004, tolerance 0.010)"
        );
        assert_eq!(
            number("rho", Unit::Metres, 1.2043, 1.2391),
            "rho 1.2043 -> 1.2391 m (+0.0348, tolerance 0.010)"
        );
        assert_eq!(
            number("theta", Unit::Radians, 0.0, 0.0100873),
            "theta 0.00 -> 0.58 deg (+0.58, tolerance 0.573)"
        );
        assert_eq!(
            number("readings", Unit::Count, 12.0, 9.0),
            "readings 12 -> 9 (-3, tolerance 0.01)"
        );
    }
}
