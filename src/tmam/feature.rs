//! Features: line segments and points with covariance.

use nalgebra::Matrix2;

use super::arc::ArcId;
use crate::geometry::{Vec2, direction, unit, wrap_angle};

/// A wall: the line `x cos(theta) + y sin(theta) = rho` between two ends, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Distance of the line from the origin, metres, >= 0.
    pub rho: f64,
    /// Direction of its normal, radians in (-pi, pi].
    pub theta: f64,
    /// Covariance over (rho, theta).
    pub covariance: Matrix2<f64>,
    /// Middle of the segment.
    pub mid: Vec2,
    /// Half its length, metres.
    pub half_length: f64,
}

/// A corner or an edge, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Where it is.
    pub position: Vec2,
    /// Covariance over (x, y).
    pub covariance: Matrix2<f64>,
}

/// What a run of arcs was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A run of contact arcs.
    Line(Segment),
    /// A run of intersection arcs.
    Point(Point),
}

/// Line or point, where the shape itself may be unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A line segment.
    Line,
    /// A point.
    Point,
}

/// Why a fit was not registered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rejection {
    /// No two of its arcs give a point to start from.
    NoStart,
    /// The readings do not determine it.
    Singular,
    /// The iteration ran away.
    Diverged,
    /// It lies outside the beams it came from.
    OutsideBeams,
}

/// What became of an extracted feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// New in the map under this id.
    Registered(u32),
    /// Fused into the map feature with this id.
    Merged(u32),
    /// Not used.
    Rejected(Rejection),
}

/// One closed run of equally labelled arcs, and what it gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Extraction {
    /// Counts from 0 in the order of extraction.
    pub id: u32,
    /// What the run's label says.
    pub kind: Kind,
    /// The run: its labelled arcs, in order.
    pub labelled: Vec<ArcId>,
    /// The associated arcs: the run and its neighbour on either side.
    pub associated: Vec<ArcId>,
    /// The estimate; `None` where there was none to speak of.
    pub shape: Option<Shape>,
    /// Root mean square of range minus prediction, metres; 0 without an estimate.
    pub residual_rms: f64,
    /// Iterations of (10) that were made.
    pub iterations: u32,
    /// Whether the stopping rule was met.
    pub converged: bool,
    /// What became of it.
    pub action: Action,
    /// The map feature after this extraction; `None` where it was rejected.
    pub map_feature: Option<MapFeature>,
}

/// A registered feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFeature {
    /// Kept from registration on; unique over lines and points.
    pub id: u32,
    /// Where it is.
    pub shape: Shape,
    /// How many associated readings stand behind it: the n of (24)-(27).
    pub readings: u32,
}

impl Segment {
    /// The two ends.
    pub fn ends(&self) -> [Vec2; 2] {
        let along = unit(self.theta + std::f64::consts::FRAC_PI_2) * self.half_length;
        [self.mid - along, self.mid + along]
    }

    /// The same segment with `rho >= 0` and theta in (-pi, pi]: (rho, theta) and
    /// (-rho, theta + pi) are one line.
    pub fn canonical(self) -> Self {
        if self.rho < 0.0 {
            self.flipped()
        } else {
            Self {
                theta: wrap_angle(self.theta),
                ..self
            }
        }
    }

    /// The same segment under the other sign of (rho, theta).
    pub fn flipped(self) -> Self {
        let [c12, c21] = [-self.covariance.m12, -self.covariance.m21];
        Self {
            rho: -self.rho,
            theta: wrap_angle(self.theta + std::f64::consts::PI),
            covariance: Matrix2::new(self.covariance.m11, c12, c21, self.covariance.m22),
            ..self
        }
    }
}

impl Point {
    /// Polar coordinates (rho, alpha) of (7), metres and radians.
    pub fn polar(&self) -> (f64, f64) {
        (self.position.norm(), direction(self.position))
    }

    /// Covariance over (rho, alpha), (22); `None` where the point lies so near the origin that
    /// polar coordinates are singular: closer than its own standard deviation.
    pub fn polar_covariance(&self) -> Option<Matrix2<f64>> {
        let (rho, alpha) = self.polar();
        if rho * rho <= self.covariance.trace() {
            return None;
        }
        let n = unit(alpha);
        let polar_from_xy = Matrix2::new(n.x, n.y, -n.y / rho, n.x / rho);
        Some(polar_from_xy * self.covariance * polar_from_xy.transpose())
    }
}

impl Shape {
    /// Line or point.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Line(_) => Kind::Line,
            Self::Point(_) => Kind::Point,
        }
    }
}

impl Kind {
    /// `line` or `point`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Point => "point",
        }
    }
}

impl Rejection {
    /// The word in files: `no-start`, `singular`, `diverged` or `outside-beams`.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoStart => "no-start",
            Self::Singular => "singular",
            Self::Diverged => "diverged",
            Self::OutsideBeams => "outside-beams",
        }
    }
}
