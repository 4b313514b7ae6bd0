//! What a comparison found.

use super::results::{Feature, Margin, Mark};

/// The outcome of a comparison.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Comparison {
    /// What differs: the log, the noise, the sonars, then the map, the extracted features, the labels.
    pub differences: Vec<Difference>,
    /// Labels that flipped with less than the tolerances `borderline` and `borderline_chi2` to spare.
    pub borderline: Vec<LabelRun>,
    /// Whether both sides have labels to compare.
    pub labels_compared: bool,
}

/// One thing that differs.
#[derive(Debug, Clone, PartialEq)]
pub enum Difference {
    /// The log does not hold the events that the golden file was made from.
    Log {
        /// Digest of the golden file's log.
        golden: String,
        /// Digest of the log at hand.
        actual: String,
    },
    /// The noise of the ranges, where they tell it themselves.
    Noise(Change),
    /// A sonar that is mounted or measures otherwise.
    Sonar(SonarDifference),
    /// A feature.
    Feature(Box<FeatureDifference>),
    /// Consecutive arcs of one sonar whose labels changed in the same way.
    Labels(LabelRun),
}

/// A sonar that is mounted or measures otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct SonarDifference {
    /// Its name.
    pub sensor: String,
    /// What is out of tolerance; never empty.
    pub changes: Vec<Change>,
}

/// A feature that moved, went or came.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureDifference {
    /// Where it belongs.
    pub set: Set,
    /// The feature of the golden file; `None` for a new one.
    pub golden: Option<Feature>,
    /// The feature found now; `None` for a missing one.
    pub actual: Option<Feature>,
    /// What moved beyond its tolerance; empty where one of the two is not there.
    pub changes: Vec<Change>,
}

/// Which features are compared with each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Set {
    /// The final map.
    Map,
    /// The extracted features.
    Extracted,
}

/// What became of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It is there and differs.
    Changed,
    /// It is in the golden file only.
    Missing,
    /// It is not in the golden file.
    New,
}

/// One value of a feature that is out of tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Its name: `rho`, `theta`, `readings`, ...
    pub what: &'static str,
    /// Both values.
    pub value: Value,
}

/// A pair of values, golden and actual.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Metres.
    Length {
        /// Then.
        golden: f64,
        /// Now.
        actual: f64,
        /// Now minus then.
        delta: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// Radians; `delta` takes the short way round.
    Angle {
        /// Then.
        golden: f64,
        /// Now.
        actual: f64,
        /// Now minus then.
        delta: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// A standard deviation, metres or radians; `delta` and `tolerance` are fractions of it.
    Deviation {
        /// Then.
        golden: f64,
        /// Now.
        actual: f64,
        /// Relative.
        delta: f64,
        /// Relative.
        tolerance: f64,
    },
    /// A number of things.
    Count {
        /// Then.
        golden: u32,
        /// Now.
        actual: u32,
        /// What was allowed.
        tolerance: u32,
    },
    /// A word.
    Word {
        /// Then.
        golden: String,
        /// Now.
        actual: String,
    },
}

/// Consecutive arcs of one sonar whose labels changed in the same way.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelRun {
    /// The sonar's name.
    pub sensor: String,
    /// What happened to them.
    pub change: LabelChange,
    /// The arcs, in stamp order; never empty.
    pub arcs: Vec<StrayedArc>,
}

/// What happened to the label of an arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LabelChange {
    /// Another label.
    Flipped {
        /// Then.
        golden: Mark,
        /// Now.
        actual: Mark,
        /// Why it is unidentified now.
        reason: Option<&'static str>,
    },
    /// There is no arc of that stamp any more.
    Gone(Mark),
    /// There was no arc of that stamp.
    New(Mark),
}

/// An arc whose label is not what it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrayedArc {
    /// When it was measured, nanoseconds.
    pub stamp_ns: i64,
    /// Its frame, or for an arc that is gone the one that it would be in.
    pub frame: Option<u32>,
    /// What its present label has to spare.
    pub margin: Option<Margin>,
}

impl FeatureDifference {
    /// What became of it.
    pub fn state(&self) -> State {
        match (&self.golden, &self.actual) {
            (Some(_), None) => State::Missing,
            (None, _) => State::New,
            _ => State::Changed,
        }
    }

    /// Whether it is not where it was: it moved, or is there on one side only.
    pub fn is_elsewhere(&self) -> bool {
        let moved =
            |change: &Change| matches!(change.value, Value::Length { .. } | Value::Angle { .. });
        self.state() != State::Changed || self.changes.iter().any(moved)
    }

    /// The feature: as it was where it is known, else as it is.
    pub fn feature(&self) -> Option<&Feature> {
        self.golden.as_ref().or(self.actual.as_ref())
    }

    /// Its frames: as they are where it is there, else as they were.
    pub fn frames(&self) -> Option<[u32; 2]> {
        let actual = self.actual.as_ref().and_then(|feature| feature.frames);
        actual.or_else(|| self.golden.as_ref().and_then(|feature| feature.frames))
    }
}

impl Difference {
    /// First and last frame that it is about, where it is about frames.
    pub fn frames(&self) -> Option<[u32; 2]> {
        match self {
            Self::Log { .. } | Self::Noise(_) | Self::Sonar(_) => None,
            Self::Feature(feature) => feature.frames(),
            Self::Labels(run) => run.frames(),
        }
    }
}

impl LabelRun {
    /// First and last frame of its arcs.
    pub fn frames(&self) -> Option<[u32; 2]> {
        let frames = || self.arcs.iter().filter_map(|arc| arc.frame);
        frames().min().zip(frames().max()).map(|(a, b)| [a, b])
    }
}

impl Comparison {
    /// Whether nothing differs; with `strict`, not even borderline labels.
    pub fn matches(&self, strict: bool) -> bool {
        self.differences.is_empty() && (self.borderline.is_empty() || !strict)
    }

    /// The first frame of a difference.
    pub fn first_frame(&self) -> Option<u32> {
        let frames = self.differences.iter().filter_map(Difference::frames);
        let borderline = self.borderline.iter().filter_map(LabelRun::frames);
        let first = frames.map(|[first, _]| first).min();
        first.or_else(|| borderline.map(|[first, _]| first).min())
    }

    /// The differences in one set of features.
    pub fn features(&self, set: Set) -> impl Iterator<Item = &FeatureDifference> {
        self.differences
            .iter()
            .filter_map(move |difference| match difference {
                Difference::Feature(feature) if feature.set == set => Some(feature.as_ref()),
                _ => None,
            })
    }

    /// The labels that differ.
    pub fn labels(&self) -> impl Iterator<Item = &LabelRun> {
        self.differences
            .iter()
            .filter_map(|difference| match difference {
                Difference::Labels(run) => Some(run),
                _ => None,
            })
    }
}
