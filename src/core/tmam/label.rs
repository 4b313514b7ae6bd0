//! What an arc belongs to, or why that cannot be told.

use serde::{Deserialize, Serialize, Serializer};

/// Line or point, where the shape itself may be unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A line segment.
    Line,
    /// A point.
    Point,
    /// A circle, with `noise_aware.circles`.
    Circle,
}

/// What an arc belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// A line.
    Contact,
    /// A point.
    Intersection,
    /// A circle.
    Circle,
    /// Neither could be told.
    Unidentified(Reason),
}

/// Why an arc is unidentified, in the order in which the reasons are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// No echo before or after it in the sonar's sequence.
    Missing,
    /// A neighbour too far in time or distance.
    Gap,
    /// The robot turned, or its path bent.
    Turning,
    /// No two points on a common side, neither contact nor intersection points.
    NoPoints,
    /// The smaller angle is not below gamma.
    Wide,
    /// The ratio of the angles lies between alpha and beta; under the noise-aware rule, both a line
    /// and a point explain all the readings that there are, or a line whose foot may lie beside the beam.
    Ambiguous,
    /// Under the noise-aware rule: the readings around it come from different targets.
    Neither,
    /// Under the noise-aware rule: they come from a rough wall that is seen at an angle.
    Oblique,
    /// By two measurements: their targets may have any radius from a small one to a large one.
    ArcFeature,
    /// By a method other than TMAM: no feature came of it.
    Unused,
}

impl Kind {
    /// `line`, `point` or `circle`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Point => "point",
            Self::Circle => "circle",
        }
    }

    /// The label of its arcs.
    pub fn label(self) -> Label {
        match self {
            Self::Line => Label::Contact,
            Self::Point => Label::Intersection,
            Self::Circle => Label::Circle,
        }
    }
}

impl Label {
    /// `contact`, `intersection`, `circle` or `unidentified`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Intersection => "intersection",
            Self::Circle => "circle",
            Self::Unidentified(_) => "unidentified",
        }
    }

    /// The kind of feature that the arc belongs to.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Contact => Some(Kind::Line),
            Self::Intersection => Some(Kind::Point),
            Self::Circle => Some(Kind::Circle),
            Self::Unidentified(_) => None,
        }
    }

    /// Why, for an unidentified arc.
    pub fn reason(self) -> Option<Reason> {
        match self {
            Self::Unidentified(reason) => Some(reason),
            Self::Contact | Self::Intersection | Self::Circle => None,
        }
    }
}

impl Serialize for Label {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Reason {
    /// Every reason, in the order in which they are tried.
    pub const ALL: [Self; 10] = [
        Self::Missing,
        Self::Gap,
        Self::Turning,
        Self::NoPoints,
        Self::Wide,
        Self::Ambiguous,
        Self::Neither,
        Self::Oblique,
        Self::ArcFeature,
        Self::Unused,
    ];

    /// The word in files: `missing`, `gap`, `turning`, `no-points`, `wide`, `ambiguous`, `neither`,
    /// `oblique`, `arc-feature` or `unused`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Gap => "gap",
            Self::Turning => "turning",
            Self::NoPoints => "no-points",
            Self::Wide => "wide",
            Self::Ambiguous => "ambiguous",
            Self::Neither => "neither",
            Self::Oblique => "oblique",
            Self::ArcFeature => "arc-feature",
            Self::Unused => "unused",
        }
    }
}
