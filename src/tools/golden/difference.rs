//! What a comparison found: one list of differences, section by section.

use serde::{Serialize, Serializer};
use serde_json::json;

use super::results::{Feature, Margin, Mark};
use super::tolerance::Tolerance;
use crate::core::rounding::{optional, rounded};
use crate::core::tmam::label::Kind;

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
    pub unit: Unit,
    pub golden: f64,
    pub actual: f64,
    /// Now minus then; of angles the short way round.
    pub delta: f64,
    pub tolerance: f64,
}

/// The unit of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Unit {
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
            Change::Number(number) => matches!(number.unit, Unit::Metres | Unit::Radians),
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
                    Unit::Count => json!(number as i64),
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
