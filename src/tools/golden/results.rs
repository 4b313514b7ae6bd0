//! What is compared: the map, the extracted features, the label of every arc, the noise of the ranges, the
//! log and what a replay warns of.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

use serde::{Deserialize, Serialize};

use super::profile::LogInfo;
use super::quality::Quality;
use crate::core::config::Config;
use crate::core::geometry::{Vec2, angle_between, direction, unit, wrap_angle};
use crate::core::noise_estimate::VarianceFrom;
use crate::core::rounding::{fixed, micro};
use crate::core::tmam::label::Kind;
use crate::core::tmam::report::Margin;

/// The results of a replay, or of anything else that finds lines and points.
///
/// Numbers are rounded to a micrometre and a microradian, on both sides of a comparison alike.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Results {
    pub map: Vec<Feature>,
    /// Every extracted feature, those that were rejected included.
    pub extracted: Vec<Feature>,
    /// The label of every arc; `None` where labels are not known.
    pub labels: Option<Labels>,
    pub noise: RangeSigma,
    /// The log that they come from, part by part, where that is known.
    pub log: Option<LogInfo>,
    /// What a replay warns of, by the names that `tmam info` gives it; `None` where that is not known.
    pub findings: Option<BTreeMap<String, String>>,
    /// How good they are, where that is known.
    pub quality: Option<Quality>,
}

/// A line segment, a point or a circle; so it stands in golden files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Feature {
    /// Its number in the map or among the extracted features; 0 in golden files. Never compared.
    #[serde(default, skip_serializing)]
    pub id: u32,
    #[serde(flatten)]
    pub geometry: Geometry,
    /// Standard deviations: of (rho, theta) for a line, of (x, y) for a point, of the centre (along its worse axis)
    /// and the radius for a circle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<[f64; 2]>,
    /// How many readings stand behind it.
    pub readings: u32,
    /// First and last frame of its readings. Golden files hold none: they shift.
    #[serde(default, skip_serializing)]
    pub frames: Option<[u32; 2]>,
    /// When its first and last readings were, seconds after the first reading of the log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<[f64; 2]>,
    /// The sonar that an extracted feature comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<String>,
    /// What became of an extracted feature: `registered`, `merged`, or why it was rejected. Of a
    /// feature of the map: `confirmed` or `tentative`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fate: Option<String>,
}

/// Where a feature is, in the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a feature lacks one of `rho`, `theta`, `mid` and `half_length`, or one of `x` and `y`, as numbers"
)]
pub enum Geometry {
    Line(LineSegment),
    /// Metres. Before the point, as that would take it for one.
    Circle {
        x: f64,
        y: f64,
        radius: f64,
    },
    /// Metres.
    Point {
        x: f64,
        y: f64,
    },
    /// A run that no feature could be fitted to is nowhere.
    Unfitted {
        kind: Kind,
    },
}

/// A segment of the line `x cos(theta) + y sin(theta) = rho`; (rho, theta) and (-rho, theta + pi) are
/// the same line. Metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LineSegment {
    pub rho: f64,
    pub theta: f64,
    /// The middle of the segment.
    pub mid: [f64; 2],
    pub half_length: f64,
}

/// The labels of one replay.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    /// The arcs of each sonar, by its name, in stamp order.
    pub sonars: BTreeMap<String, Vec<LabelledArc>>,
    /// The stamp of every frame; empty where frames are not known.
    pub frame_stamps: Vec<i64>,
}

/// The label of one arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabelledArc {
    pub stamp_ns: i64,
    pub mark: Mark,
    /// Its frame, where that is known.
    pub frame: Option<u32>,
    /// How far it is from another label, where that is known.
    pub margin: Option<Margin>,
    /// Why it is unidentified, where that is known. Never compared.
    pub reason: Option<&'static str>,
}

/// A label without its reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// Belongs to a line.
    Contact,
    /// Belongs to a point.
    Intersection,
    /// Neither could be told.
    Unidentified,
    /// Belongs to a circle.
    Circle,
}

/// The noise of the ranges, and whether it was measured: all of the noise-aware rule hangs on it. In
/// files a number, `null`, or nothing at all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "`measured_sigma` is neither a number nor null")]
pub enum RangeSigma {
    /// It was not recorded.
    #[default]
    #[serde(skip)]
    Unknown,
    /// Messages or the configuration say it, or there is too little to measure it by.
    Given,
    /// The standard deviation of a range as the ranges themselves tell it, metres.
    Measured(f64),
}

impl Mark {
    pub const ALL: [Self; 4] = [
        Self::Contact,
        Self::Intersection,
        Self::Unidentified,
        Self::Circle,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Intersection => "intersection",
            Self::Unidentified => "unidentified",
            Self::Circle => "circle",
        }
    }
}

impl RangeSigma {
    /// Of a replay with `config`, measured parameters included.
    pub fn of(variance: VarianceFrom, config: &Config) -> Self {
        match config.noise.sigma_abs {
            Some(sigma) if variance == VarianceFrom::Ranges => Self::Measured(sigma),
            _ => Self::Given,
        }
    }

    pub fn is_unknown(&self) -> bool {
        *self == Self::Unknown
    }
}

impl Labels {
    /// How many arcs have each label, in the order of [`Mark::ALL`].
    pub fn counts(&self) -> [u64; 4] {
        let arcs = || self.sonars.values().flatten();
        Mark::ALL.map(|mark| arcs().filter(|arc| arc.mark == mark).count() as u64)
    }

    /// How many arcs there are.
    pub fn len(&self) -> usize {
        self.sonars.values().map(Vec::len).sum()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The frame at a stamp.
    pub fn frame_at(&self, stamp_ns: i64) -> Option<u32> {
        let after = self.frame_stamps.partition_point(|at| *at <= stamp_ns);
        u32::try_from(after.saturating_sub(1))
            .ok()
            .filter(|_| !self.frame_stamps.is_empty())
    }
}

impl Results {
    /// A map and nothing else, its features numbered in the order given.
    pub fn of_map(features: impl IntoIterator<Item = Feature>) -> Self {
        let numbered = features.into_iter().zip(0..);
        Self {
            map: numbered
                .map(|(feature, id)| Feature { id, ..feature })
                .collect(),
            ..Self::default()
        }
    }

    /// The confirmed features of the map and where they are, and nothing else: what two drives through the
    /// same rooms have in common.
    pub fn map_alone(&self) -> Self {
        let confirmed = self.map.iter().filter(|one| one.is_confirmed());
        let place = |feature: &Feature| Feature {
            id: feature.id,
            frames: feature.frames,
            ..Feature::new(feature.geometry)
        };
        Self {
            map: confirmed.map(place).collect(),
            quality: self.quality,
            ..Self::default()
        }
    }

    /// The frame at a time, seconds after the first reading of the log.
    pub fn frame_at(&self, seconds: f64) -> Option<u32> {
        let origin = self.log.as_ref()?.origin_ns()?;
        let labels = self.labels.as_ref()?;
        // Golden files count milliseconds.
        labels.frame_at(origin.saturating_add(((seconds + 5e-4) * 1e9) as i64))
    }

    /// Whether there is no feature in the map that is somewhere: nothing worth holding anything to.
    pub fn is_empty(&self) -> bool {
        self.map.iter().all(|feature| feature.is_unfitted())
    }
}

impl Feature {
    /// A line segment from end to end, metres.
    pub fn wall(from: [f64; 2], to: [f64; 2]) -> Self {
        let (a, b) = (Vec2::from(from), Vec2::from(to));
        let mid = (a + b) / 2.0;
        let theta = direction(b - a) + FRAC_PI_2;
        let rho = unit(theta).dot(&mid);
        Self::line(rho, theta, mid.into(), (b - a).norm() / 2.0)
    }

    /// A segment of the line `x cos(theta) + y sin(theta) = rho`: metres and radians.
    pub fn line(rho: f64, theta: f64, mid: [f64; 2], half_length: f64) -> Self {
        Self::new(Geometry::Line(LineSegment {
            rho,
            theta,
            mid,
            half_length,
        }))
    }

    /// A circle, metres.
    pub fn circle(x: f64, y: f64, radius: f64) -> Self {
        Self::new(Geometry::Circle { x, y, radius })
    }

    /// A point, metres.
    pub fn point(x: f64, y: f64) -> Self {
        Self::new(Geometry::Point { x, y })
    }

    pub fn new(geometry: Geometry) -> Self {
        Self {
            id: 0,
            geometry: geometry.rounded(),
            sigma: None,
            readings: 0,
            frames: None,
            seconds: None,
            sensor: None,
            fate: None,
        }
    }

    pub fn kind(&self) -> Kind {
        match self.geometry {
            Geometry::Line(_) => Kind::Line,
            Geometry::Point { .. } => Kind::Point,
            Geometry::Circle { .. } => Kind::Circle,
            Geometry::Unfitted { kind } => kind,
        }
    }

    /// What it is and where: `line (0.00, 5.00) to (4.00, 5.00) m`.
    pub fn place(&self) -> String {
        let at = |at: Vec2| format!("({}, {})", fixed(at.x, 2), fixed(at.y, 2));
        let kind = self.kind().name();
        match (&self.geometry, self.geometry.ends()) {
            (Geometry::Line(_), Some([one, other])) => {
                // From the left, so that it is named alike whichever way it was seen.
                let centimetres = |at: Vec2| libm::rint(at.x * 100.0);
                let is_left = (centimetres(one), one.y) <= (centimetres(other), other.y);
                let [from, to] = if is_left { [one, other] } else { [other, one] };
                format!("{kind} {} to {} m", at(from), at(to))
            }
            (Geometry::Circle { radius, .. }, Some([place, _])) => {
                format!("{kind} {} of {} m", at(place), fixed(*radius, 2))
            }
            (_, Some([place, _])) => format!("{kind} {} m", at(place)),
            _ => format!("{kind} without a fit"),
        }
    }

    /// Whether enough stands behind it; of a feature of the map.
    pub fn is_confirmed(&self) -> bool {
        self.fate.as_deref() != Some("tentative")
    }

    pub fn is_unfitted(&self) -> bool {
        matches!(self.geometry, Geometry::Unfitted { .. })
    }
}

impl Geometry {
    /// To the micrometre and microradian, with a positive rho. What is no number cannot be compared, or
    /// written into a file, and is nowhere.
    pub fn rounded(self) -> Self {
        let finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
        match self {
            Self::Line(line) => {
                let turn = if line.rho < 0.0 { PI } else { 0.0 };
                let theta = wrap_angle(micro(wrap_angle(line.theta + turn)));
                let [x, y] = line.mid;
                let numbers = [line.rho.abs(), theta, x, y, line.half_length].map(micro);
                let [rho, theta, x, y, half_length] = numbers;
                let mid = [x, y];
                match finite(&numbers) {
                    true => Self::Line(LineSegment {
                        rho,
                        theta,
                        mid,
                        half_length,
                    }),
                    false => Self::Unfitted { kind: Kind::Line },
                }
            }
            Self::Point { x, y } => match finite(&[x, y]) {
                true => Self::Point {
                    x: micro(x),
                    y: micro(y),
                },
                false => Self::Unfitted { kind: Kind::Point },
            },
            Self::Circle { x, y, radius } => match finite(&[x, y, radius]) {
                true => Self::Circle {
                    x: micro(x),
                    y: micro(y),
                    radius: micro(radius),
                },
                false => Self::Unfitted { kind: Kind::Circle },
            },
            Self::Unfitted { .. } => self,
        }
    }

    /// Both ends of a segment; twice the place of a point, or of the centre of a circle.
    pub fn ends(&self) -> Option<[Vec2; 2]> {
        match *self {
            Self::Line(line) => {
                let along = unit(line.theta + FRAC_PI_2) * line.half_length;
                Some([Vec2::from(line.mid) - along, Vec2::from(line.mid) + along])
            }
            Self::Point { x, y } | Self::Circle { x, y, .. } => Some([Vec2::new(x, y); 2]),
            Self::Unfitted { .. } => None,
        }
    }
}

impl LineSegment {
    /// Its (rho, theta) under the sign that is nearer to a normal.
    pub fn signed_like(&self, normal: f64) -> (f64, f64) {
        if angle_between(self.theta, normal) > FRAC_PI_2 {
            (-self.rho, wrap_angle(self.theta + PI))
        } else {
            (self.rho, self.theta)
        }
    }
}

/// The standard deviations behind two variances; `None` where one is not finite.
pub fn sigma_of(variances: [f64; 2]) -> Option<[f64; 2]> {
    let sigma = variances.map(|variance| micro(variance.max(0.0).sqrt()));
    sigma.iter().all(|s| s.is_finite()).then_some(sigma)
}
