//! What a comparison found: one list of differences, section by section.

use std::cmp::Ordering;

use serde::{Serialize, Serializer};
use serde_json::json;

use super::cause::Cause;
use super::quality::Quality;
use super::results::{Feature, Mark};
use super::tolerance::Tolerance;
use crate::core::rounding::{optional, rounded};
use crate::core::tmam::label::Kind;
use crate::core::tmam::report::Margin;

/// The sections of a report, in its order; the last one fails only with `--strict`.
pub const SECTIONS: [&str; 8] = [
    "requirements",
    "cause",
    "range noise",
    "findings",
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
    pub label_counts: Option<[[u64; 4]; 2]>,
    /// How good the results were and are; `None` where that is not known of both.
    pub quality: Option<[Quality; 2]>,
    pub tolerance: Tolerance,
}

/// One thing that differs: a line in every report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Difference {
    /// What somebody asked of the result, and it does not meet.
    Requirement {
        text: String,
    },
    /// What is otherwise about the log or the configuration.
    Cause(Cause),
    /// The noise of the ranges.
    Noise {
        changes: [Change; 1],
    },
    Finding(FindingDifference),
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

/// What a replay warns of on one side only.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FindingDifference {
    pub state: State,
    /// Its name.
    pub code: String,
    #[serde(rename = "finding")]
    pub text: String,
}

/// A feature that moved, went or came.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeatureDifference {
    pub state: State,
    feature: Kind,
    /// As it was; `None` for a new one.
    #[serde(rename = "place", serialize_with = "place")]
    pub golden: Option<Feature>,
    /// As it is; `None` for a missing one.
    #[serde(rename = "id", serialize_with = "id")]
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
    /// When the first of the arcs is, seconds after the first reading of the log.
    #[serde(rename = "seconds", serialize_with = "optional")]
    pub at: Option<f64>,
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
        frame_at: impl Fn(f64) -> Option<u32>,
    ) -> Option<Self> {
        let known = golden.or(actual)?;
        let by_time = |feature: &Feature| {
            let [first, last] = feature.seconds?;
            Some([frame_at(first)?, frame_at(last)?])
        };
        Some(Self {
            state: State::of(&golden, &actual),
            feature: known.kind(),
            sensor: known.sensor.clone(),
            frames: (actual.and_then(|feature| feature.frames))
                .or_else(|| golden.and_then(by_time))
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

    /// Puts what is further from where it was first; then what changed most in other ways.
    pub fn graver_first(&self, other: &Self) -> Ordering {
        let (place, amount) = self.gravity();
        let (other_place, other_amount) = other.gravity();
        other_place
            .cmp(&place)
            .then(other_amount.total_cmp(&amount))
    }

    /// Whether it is elsewhere, and how many tolerances it is off at most.
    fn gravity(&self) -> (bool, f64) {
        /// What is there on one side only is off by as many tolerances as part two features.
        const GONE: f64 = 30.0;
        let of_known = self.feature().map_or(0.0, |feature| {
            let is_weak = !matches!(
                feature.fate.as_deref(),
                None | Some("confirmed" | "registered" | "merged")
            );
            let part = if is_weak { 0.0 } else { GONE };
            part + f64::from(feature.readings) * 1e-3
        });
        match self.state {
            State::Changed => {
                let elsewhere = self.is_elsewhere();
                let of_it = self.changes.iter();
                let of_it = of_it.filter(|change| !elsewhere || change.is_of_place());
                (elsewhere, of_it.map(Change::tolerances).fold(0.0, f64::max))
            }
            _ => (
                self.feature().is_some_and(|known| !known.is_unfitted()),
                of_known,
            ),
        }
    }

    /// Whether it is not where it was: it moved, or is there on one side only.
    pub fn is_elsewhere(&self) -> bool {
        self.state != State::Changed || self.changes.iter().any(Change::is_of_place)
    }
}

fn place<S: Serializer>(feature: &Option<Feature>, serializer: S) -> Result<S::Ok, S::Error> {
    feature.as_ref().map(Feature::place).serialize(serializer)
}

fn id<S: Serializer>(feature: &Option<Feature>, serializer: S) -> Result<S::Ok, S::Error> {
    feature
        .as_ref()
        .map(|feature| feature.id)
        .serialize(serializer)
}

impl Change {
    /// Whether it says that something is elsewhere.
    pub fn is_of_place(&self) -> bool {
        let Self::Number(number) = self else {
            return false;
        };
        matches!(number.unit, ChangeUnit::Metres | ChangeUnit::Radians)
    }

    /// How many tolerances it is; of a word, one.
    pub fn tolerances(&self) -> f64 {
        match self {
            Self::Number(number) => number.tolerances(),
            Self::Word { .. } => 1.0,
        }
    }
}

impl NumberChange {
    /// How many tolerances it is.
    pub fn tolerances(&self) -> f64 {
        /// Of a tolerance of nothing.
        const MANY: f64 = 1e6;
        (self.delta / self.tolerance).abs().min(MANY)
    }
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
    /// Puts a contact that became an intersection, or the other way round, before what was or is unidentified;
    /// then the longer run.
    pub fn graver_first(&self, other: &Self) -> Ordering {
        let is_contrary = |run: &Self| {
            let is_given = |mark: Option<Mark>| mark.is_some_and(|mark| mark != Mark::Unidentified);
            is_given(run.golden) && is_given(run.actual)
        };
        let by_kind = is_contrary(other).cmp(&is_contrary(self));
        by_kind.then(other.arcs.len().cmp(&self.arcs.len()))
    }

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
        let [
            requirements,
            cause,
            noise,
            findings,
            map,
            extracted,
            labels,
            borderline,
        ] = SECTIONS;
        match self {
            Self::Requirement { .. } => requirements,
            Self::Cause(_) => cause,
            Self::Noise { .. } => noise,
            Self::Finding(_) => findings,
            Self::Map(_) => map,
            Self::Extracted(_) => extracted,
            Self::Labels(_) => labels,
            Self::Borderline(_) => borderline,
        }
    }

    /// First and last frame that it is about, where it is about frames.
    pub fn frames(&self) -> Option<[u32; 2]> {
        match self {
            Self::Requirement { .. } | Self::Cause(_) | Self::Noise { .. } | Self::Finding(_) => {
                None
            }
            Self::Map(feature) | Self::Extracted(feature) => feature.frames,
            Self::Labels(run) | Self::Borderline(run) => run.frames,
        }
    }

    pub fn is_borderline(&self) -> bool {
        matches!(self, Self::Borderline(_))
    }

    /// Whether results differ where it does; with `strict`, where it is borderline, too.
    pub fn fails(&self, strict: bool) -> bool {
        match self {
            Self::Cause(cause) => cause.fails,
            Self::Borderline(_) => strict,
            _ => true,
        }
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
        !self.differences.iter().any(|one| one.fails(strict))
    }

    /// Whether results differ, borderline labels and numbers of quality included; a cause is no result.
    pub fn differs(&self) -> bool {
        let is_result = |one: &Difference| !matches!(one, Difference::Cause(_));
        self.differences.iter().any(is_result)
            || self.quality.is_some_and(|[then, now]| then != now)
    }

    /// What is otherwise about log and configuration, what brings about the rest first.
    pub fn causes(&self) -> impl Iterator<Item = &Cause> {
        self.differences.iter().filter_map(|one| match one {
            Difference::Cause(cause) => Some(cause),
            _ => None,
        })
    }

    /// Names what else can be the cause: what changed in the configuration, which `fails` by itself or not; else,
    /// where the log is what it was, the program, `by` which was found what was blessed.
    pub fn blame(&mut self, configuration: &[String], fails: bool, by: Option<&str>) {
        let cause = |code, text, fails| Difference::Cause(Cause { code, text, fails });
        if !configuration.is_empty() {
            let text = format!("configuration: {}", configuration.join("; "));
            self.differences
                .insert(0, cause("configuration", text, fails));
            return;
        }
        if self.matches(true) || self.causes().next().is_some() {
            return;
        }
        let found = self.differences.iter().find_map(|one| match one {
            Difference::Finding(finding) => Some(finding.text.clone()),
            _ => None,
        });
        if let Some(text) = found {
            let text =
                format!("findings: of what the log says besides its readings and poses, {text}");
            self.differences.insert(0, cause("findings", text, false));
        } else if let Some(by) = by {
            let now = env!("CARGO_PKG_VERSION");
            let text = format!(
                "program: log and configuration are what they were, so tmam decides otherwise (then {by}, now {now})"
            );
            self.differences.insert(0, cause("program", text, false));
        }
    }

    /// The place where they differ most.
    pub fn worst(&self) -> Option<&Difference> {
        let mut of_places = self.differences.iter().filter(|one| {
            matches!(
                one,
                Difference::Map(_) | Difference::Extracted(_) | Difference::Labels(_)
            )
        });
        of_places.next()
    }

    /// The first frame of the worst place, or else of any difference; of borderline ones only where there are no
    /// others.
    pub fn first_frame(&self) -> Option<u32> {
        if let Some([first, _]) = self.worst().and_then(Difference::frames) {
            return Some(first);
        }
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
