//! What a comparison found: one list of differences, section by section, in words and as JSON.

use std::fmt::Write as _;
use std::path::Path;

use serde::{Serialize, Serializer};
use serde_json::{Value as Json, json};

use super::results::{Feature, Geometry, Margin, Mark};
use super::tolerance::Tolerance;
use crate::core::legible::inert_line;
use crate::core::rounding::{optional, rounded};
use crate::core::tmam::label::Kind;
use crate::core::wording::counted;

/// The sections of a report, in its order; the last one fails only with `--strict`.
pub const SECTIONS: [&str; 7] = [
    "log",
    "range noise",
    "sonars",
    "map",
    "extracted features",
    "labels",
    "borderline labels",
];

/// How one set of results differs from another.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Comparison {
    /// In the order of [`SECTIONS`].
    pub differences: Vec<Difference>,
    /// How many arcs had and have each label; `None` where one side holds no labels.
    pub label_counts: Option<[[u64; 3]; 2]>,
    pub tolerance: Tolerance,
}

/// One thing that differs: a line in every report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Difference {
    /// The log does not hold the events that the golden file was made from: both digests.
    Log {
        golden: String,
        actual: String,
    },
    /// The noise of the ranges.
    Noise {
        changes: [Change; 1],
    },
    /// A sonar that is gone, new, mounted otherwise or measures otherwise.
    Sonar {
        sensor: String,
        changes: Vec<Change>,
    },
    /// A feature of the map.
    Map(Box<FeatureDifference>),
    /// An extracted feature.
    Extracted(Box<FeatureDifference>),
    Labels(LabelRun),
    /// Labels that flipped with less than the tolerances `borderline` and `borderline_chi2` to spare.
    #[serde(rename = "labels")]
    Borderline(LabelRun),
}

/// Whether something is on both sides or only on one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    Changed,
    /// It is on the golden side only.
    Missing,
    /// It is not on the golden side.
    New,
}

/// A feature that moved, went or came.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeatureDifference {
    pub state: State,
    feature: Kind,
    /// As it was; `None` for a new one.
    #[serde(rename = "golden_id", serialize_with = "id")]
    pub golden: Option<Feature>,
    /// As it is; `None` for a missing one.
    #[serde(rename = "actual_id", serialize_with = "id")]
    pub actual: Option<Feature>,
    sensor: Option<String>,
    /// Its frames: as they are where it is there, else as they were.
    pub frames: Option<[u32; 2]>,
    /// What moved beyond its tolerance; empty where one of the two is not there.
    pub changes: Vec<Change>,
}

/// One value that is out of tolerance.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    Number(NumberChange),
    Word {
        what: &'static str,
        golden: String,
        actual: String,
    },
}

/// A number that is out of tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberChange {
    /// The value's name: `rho`, `theta`, `readings`, ...
    pub what: &'static str,
    pub unit: ChangeUnit,
    pub golden: f64,
    pub actual: f64,
    /// Now minus then; of angles the short way round.
    pub delta: f64,
    pub tolerance: f64,
}

/// The unit of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum ChangeUnit {
    #[serde(rename = "m")]
    Metres,
    #[serde(rename = "rad")]
    Radians,
    /// `delta` and `tolerance` are fractions of the number, which is in metres or radians.
    #[serde(rename = "relative")]
    Relative,
    #[serde(rename = "count")]
    Count,
}

/// Consecutive arcs of one sonar whose labels changed in the same way.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelRun {
    pub state: State,
    /// The sonar's name.
    pub sensor: String,
    /// `None` where there was no arc of these stamps.
    pub golden: Option<Mark>,
    /// `None` where there is no arc of these stamps any more.
    pub actual: Option<Mark>,
    /// Why the arcs are unidentified now.
    pub reason: Option<&'static str>,
    /// First and last frame of the arcs.
    pub frames: Option<[u32; 2]>,
    /// In stamp order; never empty.
    pub arcs: Vec<StrayedArc>,
}

/// An arc whose label is not what it was.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StrayedArc {
    pub stamp_ns: i64,
    /// Its frame, or for an arc that is gone the one that it would be in.
    pub frame: Option<u32>,
    /// By how much its present label holds.
    #[serde(serialize_with = "optional")]
    pub margin: Option<f64>,
    pub margin_unit: Option<&'static str>,
}

impl State {
    pub fn of<T>(golden: &Option<T>, actual: &Option<T>) -> Self {
        match (golden, actual) {
            (Some(_), None) => Self::Missing,
            (None, _) => Self::New,
            _ => Self::Changed,
        }
    }
}

impl FeatureDifference {
    /// `None` where there is no feature on either side.
    pub fn new(
        golden: Option<&Feature>,
        actual: Option<&Feature>,
        changes: Vec<Change>,
    ) -> Option<Self> {
        let known = golden.or(actual)?;
        Some(Self {
            state: State::of(&golden, &actual),
            feature: known.kind(),
            sensor: known.sensor.clone(),
            frames: (actual.and_then(|feature| feature.frames))
                .or_else(|| golden.and_then(|feature| feature.frames)),
            golden: golden.cloned(),
            actual: actual.cloned(),
            changes,
        })
    }

    /// As it was where that is known, else as it is.
    pub fn feature(&self) -> Option<&Feature> {
        self.golden.as_ref().or(self.actual.as_ref())
    }

    /// Whether it is not where it was: it moved, or is there on one side only.
    pub fn is_elsewhere(&self) -> bool {
        let moved = |change: &Change| match change {
            Change::Number(number) => {
                matches!(number.unit, ChangeUnit::Metres | ChangeUnit::Radians)
            }
            Change::Word { .. } => false,
        };
        self.state != State::Changed || self.changes.iter().any(moved)
    }
}

fn id<S: Serializer>(feature: &Option<Feature>, serializer: S) -> Result<S::Ok, S::Error> {
    feature
        .as_ref()
        .map(|feature| feature.id)
        .serialize(serializer)
}

impl Serialize for Change {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let json = match self {
            Self::Word {
                what,
                golden,
                actual,
            } => json!({
                "what": what, "unit": "word", "golden": golden, "actual": actual,
                "delta": null, "tolerance": null,
            }),
            Self::Number(change) => {
                let number = |number: f64| match change.unit {
                    ChangeUnit::Count => json!(number as i64),
                    _ => json!(number),
                };
                let [golden, actual, delta] =
                    [change.golden, change.actual, change.delta].map(|x| number(rounded(x)));
                json!({
                    "what": change.what, "unit": change.unit, "golden": golden, "actual": actual,
                    "delta": delta, "tolerance": number(change.tolerance),
                })
            }
        };
        json.serialize(serializer)
    }
}

impl LabelRun {
    pub fn push(&mut self, arc: StrayedArc) {
        if let Some(frame) = arc.frame {
            let [first, last] = self.frames.unwrap_or([frame; 2]);
            self.frames = Some([first.min(frame), last.max(frame)]);
        }
        self.arcs.push(arc);
    }
}

impl StrayedArc {
    pub fn new(stamp_ns: i64, frame: Option<u32>, margin: Option<Margin>) -> Self {
        let (margin, margin_unit) = match margin {
            Some(Margin::Angle(radians)) => (Some(radians), Some("rad")),
            Some(Margin::Chi2(chi2)) => (Some(chi2), Some("chi2")),
            None => (None, None),
        };
        Self {
            stamp_ns,
            frame,
            margin,
            margin_unit,
        }
    }
}

impl Difference {
    /// One of [`SECTIONS`].
    pub fn section(&self) -> &'static str {
        let [log, noise, sonars, map, extracted, labels, borderline] = SECTIONS;
        match self {
            Self::Log { .. } => log,
            Self::Noise { .. } => noise,
            Self::Sonar { .. } => sonars,
            Self::Map(_) => map,
            Self::Extracted(_) => extracted,
            Self::Labels(_) => labels,
            Self::Borderline(_) => borderline,
        }
    }

    /// First and last frame that it is about, where it is about frames.
    pub fn frames(&self) -> Option<[u32; 2]> {
        match self {
            Self::Log { .. } | Self::Noise { .. } | Self::Sonar { .. } => None,
            Self::Map(feature) | Self::Extracted(feature) => feature.frames,
            Self::Labels(run) | Self::Borderline(run) => run.frames,
        }
    }

    pub fn is_borderline(&self) -> bool {
        matches!(self, Self::Borderline(_))
    }

    /// The labels that it is about.
    pub fn labels(&self) -> Option<&LabelRun> {
        match self {
            Self::Labels(run) | Self::Borderline(run) => Some(run),
            _ => None,
        }
    }
}

impl Comparison {
    /// Whether nothing differs; with `strict`, not even borderline labels.
    pub fn matches(&self, strict: bool) -> bool {
        self.differences
            .iter()
            .all(|one| one.is_borderline() && !strict)
    }

    /// The first frame of a difference; of borderline ones only where there are no others.
    pub fn first_frame(&self) -> Option<u32> {
        let first = |borderline| {
            let of = |one: &&Difference| one.is_borderline() == borderline;
            let frames = self
                .differences
                .iter()
                .filter(of)
                .filter_map(Difference::frames);
            frames.map(|[first, _]| first).min()
        };
        first(false).or_else(|| first(true))
    }

    /// The features of the map that are not where they were.
    pub fn elsewhere(&self) -> impl Iterator<Item = &FeatureDifference> {
        self.differences.iter().filter_map(|one| match one {
            Difference::Map(feature) if feature.is_elsewhere() => Some(feature.as_ref()),
            _ => None,
        })
    }
}

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
        ChangeUnit::Metres => {
            let tolerance = decimals(tolerance);
            let n = digits(delta, &tolerance, 4);
            format!("{what} {golden:.n$} -> {actual:.n$} m ({delta:+.n$}, tolerance {tolerance})")
        }
        ChangeUnit::Radians => {
            let tolerance = decimals(tolerance.to_degrees());
            let [golden, actual, delta] = [golden, actual, delta].map(f64::to_degrees);
            let n = digits(delta, &tolerance, 2);
            format!("{what} {golden:.n$} -> {actual:.n$} deg ({delta:+.n$}, tolerance {tolerance})")
        }
        ChangeUnit::Relative => {
            let tolerance = ((tolerance * 1e4).round() / 100.0).to_string();
            let percent = delta * 100.0;
            let n = digits(percent, &tolerance, 0);
            format!("{what} {golden:.6} -> {actual:.6} ({percent:+.n$} %, tolerance {tolerance} %)")
        }
        ChangeUnit::Count => {
            format!("{what} {golden} -> {actual} ({delta:+}, tolerance {tolerance})")
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
            number("rho", ChangeUnit::Metres, 0.0071, -0.00294),
            "rho 0.00710 -> -0.00294 m (-0.01004, tolerance 0.010)"
        );
        assert_eq!(
            number("rho", ChangeUnit::Metres, 1.2043, 1.2391),
            "rho 1.2043 -> 1.2391 m (+0.0348, tolerance 0.010)"
        );
        assert_eq!(
            number("theta", ChangeUnit::Radians, 0.0, 0.0100873),
            "theta 0.00 -> 0.58 deg (+0.58, tolerance 0.573)"
        );
        assert_eq!(
            number("readings", ChangeUnit::Count, 12.0, 9.0),
            "readings 12 -> 9 (-3, tolerance 0.01)"
        );
    }
}
