//! Differences in words: the headlines, then section by section; and as JSON.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value as Json;

use super::difference::{
    Change, ChangeUnit, Comparison, Difference, FeatureDifference, LabelRun, NumberChange,
    SECTIONS, State,
};
use super::quality::headline;
use super::results::{Feature, Mark};
use crate::core::legible::inert_line;
use crate::core::wording::counted;

/// More differences of a section than this are counted, not listed.
pub const SHOWN: usize = 5;

/// A section of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// One of [`SECTIONS`].
    pub name: &'static str,
    pub heading: String,
    /// A line per difference.
    pub lines: Vec<String>,
}

/// The sections in which something differs.
pub fn sections(found: &Comparison, strict: bool) -> Vec<Section> {
    let section = |name| {
        let differences = found.differences.iter().filter(|one| one.fails(true));
        let of_it = differences.filter(|one| one.section() == name);
        Section {
            name,
            heading: heading(name, found, strict),
            lines: of_it.map(describe).collect(),
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
                .filter(|((mark, then), now)| **mark != Mark::Circle || **then + **now > 0)
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

/// What a person reads first: better or worse, the worst place, which is to be looked at in `recording`, and
/// the cause.
pub fn headlines(found: &Comparison, recording: Option<&Path>) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some([then, now]) = &found.quality {
        lines.push(headline(then, now));
    }
    if let Some(worst) = found.worst() {
        let mut line = format!("worst place: {}", describe(&foremost(worst)));
        if let (Some(path), Some([frame, _])) = (recording, worst.frames()) {
            let _ = write!(line, "; look at frame {frame} of {}", path.display());
        }
        lines.push(inert_line(&line));
    }
    let words = std::iter::once("cause").chain(std::iter::repeat("also"));
    let causes = found.causes().zip(words);
    lines.extend(causes.map(|(cause, word)| inert_line(&format!("{word}: {}", cause.text))));
    lines
}

/// A difference with the gravest change alone.
fn foremost(difference: &Difference) -> Difference {
    let mut foremost = difference.clone();
    if let Difference::Map(one) | Difference::Extracted(one) = &mut foremost {
        // Where it is says more than how many readings say so.
        let elsewhere = one.is_elsewhere();
        let changes = std::mem::take(&mut one.changes).into_iter();
        let changes = changes.filter(|change| !elsewhere || change.is_of_place());
        one.changes = changes
            .max_by(|a, b| a.tolerances().total_cmp(&b.tolerances()))
            .into_iter()
            .collect();
    }
    foremost
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
            let _ = writeln!(
                text,
                "  and {more} more (--show N lists N of a kind, --json all)"
            );
        }
        text
    }
}

/// A difference in one line: what it was, what it is, by how much, in which frames. Names in it may
/// come from a log, and are made legible.
pub fn describe(difference: &Difference) -> String {
    let mut text = in_words(difference);
    if let Some(frames) = difference.frames() {
        let _ = write!(text, ", {}", in_frames(frames));
    }
    inert_line(&text)
}

fn in_words(difference: &Difference) -> String {
    match difference {
        Difference::Requirement { text } => text.clone(),
        Difference::Cause(cause) => cause.text.clone(),
        Difference::Noise { changes } => format!("range noise: {}", joined(changes)),
        Difference::Finding(finding) => match finding.state {
            State::Missing => format!("no longer found: {}", finding.text),
            _ => format!("found: {}", finding.text),
        },
        Difference::Map(feature) | Difference::Extracted(feature) => feature_text(feature),
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

fn feature_text(difference: &FeatureDifference) -> String {
    let Some(feature) = difference.feature() else {
        return "a feature".to_owned();
    };
    let mut name = feature.place();
    if let Some(sensor) = &feature.sensor {
        name = format!("{sensor}, {name}");
    }
    // What is in neither recording nor features.json has no number there, nor has what comes from a golden file.
    let is_numbered = |now: &&Feature| now.frames.is_some() || now.seconds.is_none();
    let now = difference.actual.as_ref().filter(is_numbered);
    if let (Some(now), None) = (now, &feature.sensor) {
        let _ = write!(name, ", now {} {}", now.kind().name(), now.id);
    }
    match difference.state {
        State::Missing => format!("{name} is missing{}", support(feature)),
        State::New => format!("{name} is new{}", support(feature)),
        State::Changed => format!("{name}: {}", joined(&difference.changes)),
    }
}

fn support(feature: &Feature) -> String {
    let fate = feature.fate.as_ref().filter(|_| feature.is_unfitted());
    let fate = fate.map_or_else(String::new, |fate| format!(": {fate}"));
    match feature.readings {
        0 => fate,
        n => format!("{fate}, {}", counted(n.into(), "reading")),
    }
}

/// `rho 1.2043 -> 1.2391 m (+0.0348, 3.5 x tolerance 0.010 m)`.
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
    let times = match number.tolerances() {
        times if times >= 100.0 => "more than 100".to_owned(),
        times => format!("{times:.1}"),
    };
    match unit {
        ChangeUnit::Metres => {
            let tolerance = decimals(tolerance);
            let n = digits(delta, &tolerance, 4);
            format!(
                "{what} {golden:.n$} -> {actual:.n$} m ({delta:+.n$}, {times} x tolerance {tolerance} m)"
            )
        }
        ChangeUnit::Radians => {
            let tolerance = decimals(tolerance.to_degrees());
            let [golden, actual, delta] = [golden, actual, delta].map(f64::to_degrees);
            let n = digits(delta, &tolerance, 2);
            format!(
                "{what} {golden:.n$} -> {actual:.n$} deg ({delta:+.n$}, {times} x tolerance {tolerance} deg)"
            )
        }
        ChangeUnit::Relative => {
            let tolerance = ((tolerance * 1e4).round() / 100.0).to_string();
            let percent = delta * 100.0;
            let n = digits(percent, &tolerance, 0);
            let (factor, unit) = match what {
                "sigma theta" => (1_f64.to_degrees(), "deg"),
                _ => (1e3, "mm"),
            };
            let [golden, actual] = [golden, actual].map(|sigma| sigma * factor);
            format!(
                "{what} {golden:.3} -> {actual:.3} {unit} ({percent:+.n$} %, {times} x tolerance {tolerance} %)"
            )
        }
        ChangeUnit::Count => {
            format!("{what} {golden} -> {actual} ({delta:+}, {times} x tolerance {tolerance})")
        }
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
    let stamp = run.arcs.first().map_or(0, |arc| arc.stamp_ns);
    let at = match run.at {
        Some(at) => format!("at {at:.3} s"),
        None => format!("stamp {stamp} ns"),
    };
    match (run.golden, run.actual) {
        (Some(then), Some(now)) => {
            let why = run
                .reason
                .map_or_else(String::new, |reason| format!(" ({reason})"));
            format!(
                "{sensor}: {arcs} {} -> {}{why}{}, {at}",
                then.name(),
                now.name(),
                margins(run)
            )
        }
        (Some(then), None) => format!("{sensor}: {arcs} gone, {} before, {at}", then.name()),
        (None, now) => {
            let now = now.map_or("none", Mark::name);
            format!("{sensor}: {arcs} new, {now}, {at}")
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
    for one in found.differences.iter().filter(|one| one.fails(true)) {
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
            number("rho", ChangeUnit::Metres, 0.0071, -0.00294),
            "rho 0.00710 -> -0.00294 m (-0.01004, 1.0 x tolerance 0.010 m)"
        );
        assert_eq!(
            number("rho", ChangeUnit::Metres, 1.2043, 1.2391),
            "rho 1.2043 -> 1.2391 m (+0.0348, 3.5 x tolerance 0.010 m)"
        );
        assert_eq!(
            number("theta", ChangeUnit::Radians, 0.0, 0.0100873),
            "theta 0.00 -> 0.58 deg (+0.58, 1.0 x tolerance 0.573 deg)"
        );
        assert_eq!(
            number("readings", ChangeUnit::Count, 12.0, 9.0),
            "readings 12 -> 9 (-3, more than 100 x tolerance 0.01)"
        );
    }
}
