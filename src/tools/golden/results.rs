//! What is compared: the map, the extracted features, and the label of every arc.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use super::range_noise::RangeNoise;
use crate::core::geometry::{Vec2, direction, unit, wrap_angle};
use crate::core::tmam::feature::Kind;

/// What a replay, or anything else that finds lines and points, came to.
///
/// Numbers are rounded to a micrometre and a microradian, on both sides of a comparison alike.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Results {
    /// The final map.
    pub map: Vec<Feature>,
    /// Every extracted feature, those that were rejected included.
    pub extracted: Vec<Feature>,
    /// The label of every arc; `None` where labels are not known.
    pub labels: Option<Labels>,
    /// The noise of the ranges.
    pub noise: RangeNoise,
}

/// A line segment or a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// What the difference texts call it. Never compared.
    pub id: u32,
    /// Line or point.
    pub kind: Kind,
    /// Where it is; `None` for a run that no feature could be fitted to.
    pub geometry: Option<Geometry>,
    /// Standard deviations: of (rho, theta) for a line, of (x, y) for a point.
    pub sigma: Option<[f64; 2]>,
    /// Readings that stand behind it.
    pub readings: u32,
    /// First and last frame of its readings.
    pub frames: Option<[u32; 2]>,
    /// The sonar that an extracted feature comes from.
    pub sensor: Option<String>,
    /// What became of an extracted feature: `registered`, `merged`, or why it was rejected. Of a
    /// feature of the map: `confirmed` or `tentative`.
    pub fate: Option<String>,
}

/// Where a feature is, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Geometry {
    /// A segment of the line `x cos(theta) + y sin(theta) = rho`.
    Line {
        /// Metres; (rho, theta) and (-rho, theta + pi) are the same line.
        rho: f64,
        /// Radians.
        theta: f64,
        /// Middle of the segment, metres.
        mid: [f64; 2],
        /// Half its length, metres.
        half_length: f64,
    },
    /// A point, metres.
    Point {
        /// See the variant.
        x: f64,
        /// See the variant.
        y: f64,
    },
}

/// The labels of one replay.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    /// The arcs of each sonar, by its name, in stamp order.
    pub sonars: BTreeMap<String, Vec<LabelledArc>>,
    /// The stamp of every frame; empty where frames are not known.
    pub frame_stamps: Vec<i64>,
    /// Where each sonar measured from and what, by its name; empty where that is not known.
    pub measured: BTreeMap<String, Measured>,
}

/// What one sonar's arcs have in common: so that a sonar that is mounted otherwise, or measures
/// otherwise, is named even where no label changes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// The sonar in the robot's frame: x, y in metres and yaw in radians.
    pub mount: [f64; 3],
    /// The mean range of its arcs, metres.
    pub mean_range: f64,
}

/// The label of one arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabelledArc {
    /// When it was measured, nanoseconds.
    pub stamp_ns: i64,
    /// What it was taken for.
    pub mark: Mark,
    /// Its frame, where that is known.
    pub frame: Option<u32>,
    /// How far it is from another label, where that is known.
    pub margin: Option<Margin>,
    /// Why it is unidentified, where that is known. Never compared.
    pub reason: Option<&'static str>,
}

/// What a label has to spare, or lacks to become another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Margin {
    /// Radians: angles decide, under the paper's rule.
    Angle(f64),
    /// Weighted squares of residuals: readings decide, under the noise-aware rule.
    Chi2(f64),
}

impl Margin {
    /// Its number, to order margins of a kind.
    pub fn value(self) -> f64 {
        match self {
            Self::Angle(value) | Self::Chi2(value) => value,
        }
    }
}

/// A label without its reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    /// Belongs to a line.
    Contact,
    /// Belongs to a point.
    Intersection,
    /// Neither could be told.
    Unidentified,
}

impl Mark {
    /// Every label.
    pub const ALL: [Self; 3] = [Self::Contact, Self::Intersection, Self::Unidentified];

    /// `contact`, `intersection` or `unidentified`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Intersection => "intersection",
            Self::Unidentified => "unidentified",
        }
    }

    /// The letter in golden files.
    pub(super) fn letter(self) -> char {
        match self {
            Self::Contact => 'C',
            Self::Intersection => 'I',
            Self::Unidentified => 'u',
        }
    }
}

impl Labels {
    /// How many arcs have each label.
    pub fn counts(&self) -> BTreeMap<Mark, u64> {
        let mut counts: BTreeMap<Mark, u64> = Mark::ALL.map(|mark| (mark, 0)).into();
        for arc in self.sonars.values().flatten() {
            *counts.entry(arc.mark).or_default() += 1;
        }
        counts
    }

    /// How many arcs there are.
    pub fn len(&self) -> usize {
        self.sonars.values().map(Vec::len).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The frame at a stamp.
    pub(super) fn frame_at(&self, stamp_ns: i64) -> Option<u32> {
        let after = self.frame_stamps.partition_point(|at| *at <= stamp_ns);
        u32::try_from(after.saturating_sub(1))
            .ok()
            .filter(|_| !self.frame_stamps.is_empty())
    }
}

impl Results {
    /// A map and nothing else, its features numbered in the order given.
    pub fn of_map(features: impl IntoIterator<Item = Feature>) -> Self {
        let map = features
            .into_iter()
            .zip(0..)
            .map(|(feature, id)| Feature { id, ..feature })
            .collect();
        Self {
            map,
            ..Self::default()
        }
    }

    /// Whether there is no feature in the map that is somewhere: nothing worth holding anything to.
    pub fn is_empty(&self) -> bool {
        self.map.iter().all(|feature| feature.geometry.is_none())
    }
}

impl Feature {
    /// A line segment from end to end, metres.
    pub fn wall(from: [f64; 2], to: [f64; 2]) -> Self {
        let (a, b) = (Vec2::from(from), Vec2::from(to));
        let mid = (a + b) / 2.0;
        let theta = direction(b - a) + std::f64::consts::FRAC_PI_2;
        Self::line(
            unit(theta).dot(&mid),
            theta,
            mid.into(),
            (b - a).norm() / 2.0,
        )
    }

    /// A segment of the line `x cos(theta) + y sin(theta) = rho`: metres and radians.
    pub fn line(rho: f64, theta: f64, mid: [f64; 2], half_length: f64) -> Self {
        let (rho, theta) = if rho < 0.0 {
            (-rho, theta + std::f64::consts::PI)
        } else {
            (rho, theta)
        };
        let geometry = Geometry::Line {
            rho: micro(rho),
            theta: micro(wrap_angle(micro(wrap_angle(theta)))),
            mid: mid.map(micro),
            half_length: micro(half_length),
        };
        Self::new(Kind::Line, geometry.finite())
    }

    /// A point, metres.
    pub fn point(x: f64, y: f64) -> Self {
        let geometry = Geometry::Point {
            x: micro(x),
            y: micro(y),
        };
        Self::new(Kind::Point, geometry.finite())
    }

    pub(super) fn new(kind: Kind, geometry: Option<Geometry>) -> Self {
        Self {
            id: 0,
            kind,
            geometry,
            sigma: None,
            readings: 0,
            frames: None,
            sensor: None,
            fate: None,
        }
    }
}

impl Geometry {
    /// What is no number cannot be compared, or written into a file.
    fn finite(self) -> Option<Self> {
        let finite = match self {
            Self::Line {
                rho,
                theta,
                mid: [x, y],
                half_length,
            } => [rho, theta, x, y, half_length]
                .iter()
                .all(|value| value.is_finite()),
            Self::Point { x, y } => x.is_finite() && y.is_finite(),
        };
        finite.then_some(self)
    }
}

/// `x` to six decimals; zero has no sign.
pub(super) fn micro(x: f64) -> f64 {
    let scaled = x * 1e6;
    if scaled.abs() < 9e15 {
        libm::rint(scaled) / 1e6 + 0.0
    } else {
        x
    }
}
