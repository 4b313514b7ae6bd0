//! Features: line segments, points and circles with covariance.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use serde::Serialize;

pub use super::label::Kind;
use crate::core::geometry::{Vec2, direction, unit, wrap_angle};

/// The covariance of a feature whose method knows none: not numbers.
pub const UNKNOWN_COVARIANCE: Matrix2<f64> = Matrix2::new(f64::NAN, f64::NAN, f64::NAN, f64::NAN);

/// A wall: the line `x cos(theta) + y sin(theta) = rho` between two ends, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Distance of the line from the origin, metres, >= 0.
    pub rho: f64,
    /// Direction of its normal, radians in (-pi, pi].
    pub theta: f64,
    /// Covariance over (rho, theta); [`Shape::covariance`] says whether it is known.
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
    /// Covariance over (x, y); [`Shape::covariance`] says whether it is known.
    pub covariance: Matrix2<f64>,
}

/// A cylinder that stands upright, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Where its axis is.
    pub center: Vec2,
    /// Metres.
    pub radius: f64,
    /// Covariance over (x, y, radius).
    pub covariance: Matrix3<f64>,
}

/// What a run of arcs was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A run of contact arcs.
    Line(Segment),
    /// A run of intersection arcs.
    Point(Point),
    /// A run of circle arcs.
    Circle(Circle),
}

/// Why a fit was not registered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rejection {
    /// No two of its arcs give a point to start from.
    NoStart,
    /// The readings do not determine it.
    Singular,
    /// The iteration ran away.
    Diverged,
    /// It lies outside the beams it came from.
    OutsideBeams,
    /// Its readings do not all come from one feature.
    Misfit,
    /// Its mirror image at the robot's path fits as well.
    Mirrored,
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

impl Action {
    /// The word in files: `registered`, `merged` or `rejected`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Registered(_) => "registered",
            Self::Merged(_) => "merged",
            Self::Rejected(_) => "rejected",
        }
    }

    /// The map feature that it went into.
    pub fn map_id(self) -> Option<u32> {
        match self {
            Self::Registered(id) | Self::Merged(id) => Some(id),
            Self::Rejected(_) => None,
        }
    }

    /// Why it was not used.
    pub fn rejection(self) -> Option<Rejection> {
        match self {
            Self::Rejected(reason) => Some(reason),
            Self::Registered(_) | Self::Merged(_) => None,
        }
    }

    /// What became of it in a word: why it was rejected where it was.
    pub fn fate(self) -> &'static str {
        self.rejection().map_or(self.name(), Rejection::name)
    }
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
    /// How many runs gave it.
    pub runs: u32,
    /// Whether that is enough to believe in it.
    pub status: Status,
}

/// How sure it is that a feature of the map exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// More than one run, or enough readings, say so. Under the paper's rule always.
    Confirmed,
    /// A single short run says so.
    Tentative,
}

impl Status {
    /// The word in files: `confirmed` or `tentative`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Tentative => "tentative",
        }
    }
}

impl Shape {
    /// How far it is from a place in the world, metres.
    pub fn distance(&self, place: Vec2) -> f64 {
        match self {
            Self::Line(segment) => (segment.rho - place.dot(&unit(segment.theta))).abs(),
            Self::Point(point) => (point.position - place).norm(),
            Self::Circle(circle) => ((circle.center - place).norm() - circle.radius).abs(),
        }
    }

    /// The middle of a segment or circle, or the point.
    pub fn middle(&self) -> Vec2 {
        match self {
            Self::Line(segment) => segment.mid,
            Self::Point(point) => point.position,
            Self::Circle(circle) => circle.center,
        }
    }
}

impl Segment {
    /// The line seen from a place in the world: its distance from there along its normal (negative
    /// behind), its theta, and the covariance over the two.
    pub fn about(&self, origin: Vec2) -> (Vector2<f64>, Matrix2<f64>) {
        let normal = unit(self.theta);
        let along = Vec2::new(-normal.y, normal.x);
        let local = Vector2::new(self.rho - origin.dot(&normal), self.theta);
        let local_from_world = Matrix2::new(1.0, -origin.dot(&along), 0.0, 1.0);
        let covariance = local_from_world * self.covariance * local_from_world.transpose();
        (local, covariance)
    }

    /// The line that is seen from `origin` at (distance, theta), without an extent.
    pub fn of_line_about(origin: Vec2, local: Vector2<f64>, covariance: Matrix2<f64>) -> Self {
        let normal = unit(local.y);
        let along = Vec2::new(-normal.y, normal.x);
        // Turning the line about the origin moves its foot in the world.
        let world_from_local = Matrix2::new(1.0, origin.dot(&along), 0.0, 1.0);
        Self {
            rho: local.x + origin.dot(&normal),
            theta: local.y,
            covariance: world_from_local * covariance * world_from_local.transpose(), // (23)
            mid: origin + normal * local.x,
            half_length: 0.0,
        }
    }

    /// The same segment with the line that is seen from `origin` at (distance, theta).
    pub fn with_line_about(
        self,
        origin: Vec2,
        local: Vector2<f64>,
        covariance: Matrix2<f64>,
    ) -> Self {
        Self {
            mid: self.mid,
            half_length: self.half_length,
            ..Self::of_line_about(origin, local, covariance)
        }
    }

    /// The direction of its line: its normal turned to the left.
    pub fn along(&self) -> Vec2 {
        unit(self.theta + FRAC_PI_2)
    }

    /// Where it begins and ends along its line, metres.
    pub fn extent(&self) -> [f64; 2] {
        let middle = self.mid.dot(&self.along());
        [middle - self.half_length, middle + self.half_length]
    }

    /// The same line from `low` to `high` along it.
    pub fn with_extent(self, [low, high]: [f64; 2]) -> Self {
        Self {
            mid: unit(self.theta) * self.rho + self.along() * ((low + high) / 2.0),
            half_length: (high - low) / 2.0,
            ..self
        }
    }

    /// The same line from the first to the last of some places, projected on it.
    pub fn reaching_over(self, places: impl IntoIterator<Item = Vec2>) -> Self {
        let along = self.along();
        let ways = places.into_iter().map(|place| place.dot(&along));
        let extent = ways.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], way| {
            [low.min(way), high.max(way)]
        });
        self.with_extent(extent)
    }

    /// The two ends.
    pub fn ends(&self) -> [Vec2; 2] {
        let along = self.along() * self.half_length;
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
            theta: wrap_angle(self.theta + PI),
            covariance: Matrix2::new(self.covariance.m11, c12, c21, self.covariance.m22),
            ..self
        }
    }
}

impl Point {
    /// Of a method that knows no covariance.
    pub fn without_covariance(position: Vec2) -> Self {
        Self {
            position,
            covariance: UNKNOWN_COVARIANCE,
        }
    }

    /// Polar coordinates (rho, alpha) of (7), metres and radians.
    pub fn polar(&self) -> (f64, f64) {
        (self.position.norm(), direction(self.position))
    }

    /// Covariance over (rho, alpha), (22); `None` where the point lies so near the origin that
    /// polar coordinates are singular: closer than its own standard deviation.
    pub fn polar_covariance(&self) -> Option<Matrix2<f64>> {
        let (rho, alpha) = self.polar();
        // Not where no covariance is known.
        let is_known = rho * rho > self.covariance.trace();
        if !is_known {
            return None;
        }
        let n = unit(alpha);
        let polar_from_xy = Matrix2::new(n.x, n.y, -n.y / rho, n.x / rho);
        Some(polar_from_xy * self.covariance * polar_from_xy.transpose())
    }
}

impl Circle {
    /// Over (x, y, radius), metres.
    pub fn parameters(&self) -> Vector3<f64> {
        self.center.push(self.radius)
    }

    /// From (x, y, radius) and the covariance over them.
    pub fn of(parameters: Vector3<f64>, covariance: Matrix3<f64>) -> Self {
        Self {
            center: parameters.xy(),
            radius: parameters.z,
            covariance,
        }
    }

    /// Places on it, the first one once more at the end.
    pub fn outline(&self) -> impl Iterator<Item = Vec2> {
        const STEPS: u32 = 32;
        let Self { center, radius, .. } = *self;
        let turn = |k: u32| 2.0 * PI * f64::from(k % STEPS) / f64::from(STEPS);
        (0..=STEPS).map(move |k| center + unit(turn(k)) * radius)
    }
}

impl Shape {
    /// Its covariance, where the method knows one; of a circle that of its centre.
    pub fn covariance(&self) -> Option<Matrix2<f64>> {
        let covariance = match self {
            Self::Line(segment) => segment.covariance,
            Self::Point(point) => point.covariance,
            Self::Circle(circle) => circle.covariance.fixed_view::<2, 2>(0, 0).into_owned(),
        };
        covariance
            .iter()
            .all(|x| x.is_finite())
            .then_some(covariance)
    }

    /// Line, point or circle.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Line(_) => Kind::Line,
            Self::Point(_) => Kind::Point,
            Self::Circle(_) => Kind::Circle,
        }
    }
}

impl Rejection {
    /// The word in files: `no-start`, `singular`, `diverged`, `outside-beams`, `misfit` or
    /// `mirrored`.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoStart => "no-start",
            Self::Singular => "singular",
            Self::Diverged => "diverged",
            Self::OutsideBeams => "outside-beams",
            Self::Misfit => "misfit",
            Self::Mirrored => "mirrored",
        }
    }
}
