//! Corners: where two walls meet in a point, each tells of the others.
//!
//! A wall is seen from where the robot passes it, which in a room ends a metre or so short of its corners;
//! so its direction is known no better than that piece is long. The corner's own echo is at its far end.

use std::collections::BTreeSet;

use nalgebra::{Matrix2, Vector2};

use crate::core::geometry::{Vec2, unit};
use crate::core::ties;
use crate::core::tmam::feature::{MapFeature, Point, Segment, Shape, Status};

/// Chi2 with two degrees of freedom up to which a point is where two walls meet: one true corner in a
/// thousand lies beyond.
const GATE: f64 = 13.82;
/// How far beyond the seen piece of a wall its corner may be: metres, and lengths of the piece.
const FARTHEST: f64 = 3.0;
const MOST_LENGTHS: f64 = 2.0;
/// Walls that foretell their corner less well than this say nothing of it, metres; else any point
/// would do.
const FORETOLD: f64 = 0.05;
/// Walls meet at 30 degrees or more: the sine of the angle between them.
const SHALLOWEST: f64 = 0.5;
/// Walls that are estimated together, at most; their covariances with each other are held.
const MOST_WALLS: usize = 256;

/// The confirmed walls and points of `features` that meet in corners, estimated together; those that
/// changed.
///
/// A Kalman filter over the walls, for which a point measures where two of them meet. A corner that does
/// not fit what the others made of its walls is left alone.
pub fn join(features: &[MapFeature]) -> Vec<MapFeature> {
    let mut walls = Walls::default();
    let mut joined = Vec::new();
    for corner in corners(features) {
        let Some([a, b]) = walls.places(&corner.walls) else {
            continue;
        };
        if walls.measure(a, b, &corner.point).is_some() {
            joined.push((corner.feature, a, b));
        }
    }
    let points = joined.iter().filter_map(|(feature, a, b)| {
        let (position, covariance) = walls.corner(*a, *b)?;
        let shape = Shape::Point(Point {
            position,
            covariance,
        });
        Some(MapFeature { shape, ..*feature })
    });
    let places: BTreeSet<usize> = joined.iter().flat_map(|(_, a, b)| [*a, *b]).collect();
    let lines = places.iter().filter_map(|place| walls.feature(*place));
    points.chain(lines).collect()
}

/// The confirmed points of `features` in which two confirmed walls meet, by their ids.
pub fn meetings(features: &[MapFeature]) -> Vec<(u32, [u32; 2])> {
    let corners = corners(features).into_iter();
    corners
        .filter(|corner| corner.foretold.symmetric_eigenvalues().max() < FORETOLD * FORETOLD)
        .map(|corner| (corner.feature.id, corner.walls.map(|wall| wall.id)))
        .collect()
}

/// A point and the two walls that may meet there.
struct Corner {
    feature: MapFeature,
    point: Point,
    walls: [MapFeature; 2],
    /// How well the two walls foretell where they meet.
    foretold: Matrix2<f64>,
    chi2: f64,
}

/// Each confirmed point with the two walls that foretell it best, the best ones first.
fn corners(features: &[MapFeature]) -> Vec<Corner> {
    let confirmed = || features.iter().filter(|f| f.status == Status::Confirmed);
    let mut corners: Vec<Corner> = confirmed()
        .filter_map(|feature| match feature.shape {
            Shape::Point(point) => best_pair(feature, point, confirmed()),
            Shape::Line(_) | Shape::Circle(_) => None,
        })
        .collect();
    corners.sort_by(|a, b| (a.chi2.total_cmp(&b.chi2)).then(a.feature.id.cmp(&b.feature.id)));
    corners
}

fn best_pair<'a>(
    feature: &MapFeature,
    point: Point,
    features: impl Iterator<Item = &'a MapFeature>,
) -> Option<Corner> {
    let near: Vec<(MapFeature, Wall)> = features
        .filter_map(|f| match f.shape {
            Shape::Line(segment) if reaches(&segment, &point) => Some((*f, Wall::of(segment))),
            _ => None,
        })
        .collect();
    let pairs = near.iter().enumerate().flat_map(|(place, first)| {
        let others = near.iter().skip(place + 1);
        others.map(move |second| (first, second))
    });
    let corners = pairs.filter_map(|((first, a), (second, b))| {
        let meeting = Meeting::of(a, b)?;
        let [at_a, at_b] = meeting.corner_from_walls;
        let covariance =
            at_a * a.covariance * at_a.transpose() + at_b * b.covariance * at_b.transpose();
        let off = point.position - meeting.corner;
        let inverse = (covariance + point.covariance).try_inverse()?;
        let chi2 = off.dot(&(inverse * off));
        let corner = Corner {
            feature: *feature,
            point,
            walls: [*first, *second],
            foretold: covariance,
            chi2,
        };
        (chi2 < GATE).then_some((chi2, corner))
    });
    ties::first_least(corners, ties::of_chi2).map(|(_, corner)| corner)
}

/// Whether a point lies on a wall's line as far as the covariances tell, and near enough to its seen piece.
fn reaches(segment: &Segment, point: &Point) -> bool {
    let (local, covariance) = segment.about(point.position);
    let normal = unit(segment.theta);
    let variance = covariance.m11 + normal.dot(&(point.covariance * normal));
    let way = (point.position - segment.mid).perp(&normal).abs();
    let beyond = FARTHEST.min(MOST_LENGTHS * 2.0 * segment.half_length);
    local.x * local.x < GATE * variance && way < segment.half_length + beyond
}

/// A wall as seen from the middle of its piece, where distance and theta are nearly independent.
#[derive(Debug, Clone, Copy)]
struct Wall {
    origin: Vec2,
    /// Distance from the origin along the normal, metres, and theta.
    local: Vector2<f64>,
    covariance: Matrix2<f64>,
}

impl Wall {
    fn of(segment: Segment) -> Self {
        let (local, covariance) = segment.about(segment.mid);
        Self {
            origin: segment.mid,
            local,
            covariance,
        }
    }
}

/// Where two walls meet.
struct Meeting {
    corner: Vec2,
    /// How it moves with each wall's (distance, theta).
    corner_from_walls: [Matrix2<f64>; 2],
}

impl Meeting {
    /// `None` where they are nearly parallel.
    fn of(a: &Wall, b: &Wall) -> Option<Self> {
        let (normal_a, normal_b) = (unit(a.local.y), unit(b.local.y));
        if normal_a.perp(&normal_b).abs() < SHALLOWEST {
            return None;
        }
        let normals = Matrix2::new(normal_a.x, normal_a.y, normal_b.x, normal_b.y);
        let world_from_distances = normals.try_inverse()?;
        let distances = Vector2::new(
            a.local.x + normal_a.dot(&a.origin),
            b.local.x + normal_b.dot(&b.origin),
        );
        let corner = world_from_distances * distances;
        // normal . corner = distance, differentiated; a turn moves the normal along the wall.
        let [way_a, way_b] =
            [(a, normal_a), (b, normal_b)].map(|(w, n)| n.perp(&(corner - w.origin)));
        Some(Self {
            corner,
            corner_from_walls: [
                world_from_distances * Matrix2::new(1.0, -way_a, 0.0, 0.0),
                world_from_distances * Matrix2::new(0.0, 0.0, 1.0, -way_b),
            ],
        })
    }
}

/// Walls with their joint covariance, in blocks of two by two: (distance, theta) of each.
#[derive(Default)]
struct Walls {
    features: Vec<MapFeature>,
    walls: Vec<Wall>,
    covariance: Vec<Vec<Matrix2<f64>>>,
}

impl Walls {
    /// Where the two are held; `None` where there is no more room.
    fn places(&mut self, pair: &[MapFeature; 2]) -> Option<[usize; 2]> {
        let [a, b] = pair;
        Some([self.place(a)?, self.place(b)?])
    }

    fn place(&mut self, feature: &MapFeature) -> Option<usize> {
        if let Some(place) = self.features.iter().position(|f| f.id == feature.id) {
            return Some(place);
        }
        let Shape::Line(segment) = feature.shape else {
            return None;
        };
        if self.features.len() >= MOST_WALLS {
            return None;
        }
        let wall = Wall::of(segment);
        for row in &mut self.covariance {
            row.push(Matrix2::zeros());
        }
        let mut row = vec![Matrix2::zeros(); self.walls.len()];
        row.push(wall.covariance);
        self.covariance.push(row);
        self.features.push(*feature);
        self.walls.push(wall);
        Some(self.walls.len() - 1)
    }

    /// Where walls `a` and `b` meet, and the covariance of that.
    fn corner(&self, a: usize, b: usize) -> Option<(Vec2, Matrix2<f64>)> {
        let meeting = Meeting::of(self.walls.get(a)?, self.walls.get(b)?)?;
        let [at_a, at_b] = meeting.corner_from_walls;
        let with_walls = self.with_corner(a, b, &meeting);
        let covariance = at_a * with_walls.get(a)? + at_b * with_walls.get(b)?;
        Some((meeting.corner, (covariance + covariance.transpose()) / 2.0))
    }

    /// The covariance of each wall with the corner of two of them.
    fn with_corner(&self, a: usize, b: usize, meeting: &Meeting) -> Vec<Matrix2<f64>> {
        let [at_a, at_b] = meeting.corner_from_walls;
        let none = Matrix2::zeros();
        let rows = self.covariance.iter();
        rows.map(|row| {
            let (with_a, with_b) = (row.get(a).unwrap_or(&none), row.get(b).unwrap_or(&none));
            with_a * at_a.transpose() + with_b * at_b.transpose()
        })
        .collect()
    }

    /// Takes a point as a measurement of where walls `a` and `b` meet; `None` where it can be none.
    fn measure(&mut self, a: usize, b: usize, point: &Point) -> Option<()> {
        let meeting = Meeting::of(self.walls.get(a)?, self.walls.get(b)?)?;
        let (corner, foretold) = self.corner(a, b)?;
        let off = point.position - corner;
        let inverse = (foretold + point.covariance).try_inverse()?;
        let foretells = foretold.symmetric_eigenvalues().max() < FORETOLD * FORETOLD;
        if !foretells || off.dot(&(inverse * off)) >= GATE {
            return None;
        }
        let with_corner = self.with_corner(a, b, &meeting);
        for ((wall, row), with) in self
            .walls
            .iter_mut()
            .zip(&mut self.covariance)
            .zip(&with_corner)
        {
            let gain = with * inverse;
            wall.local += gain * off;
            for (block, other) in row.iter_mut().zip(&with_corner) {
                *block -= gain * other.transpose();
            }
        }
        Some(())
    }

    /// A wall as it is now.
    fn feature(&self, place: usize) -> Option<MapFeature> {
        let (feature, wall) = (self.features.get(place)?, self.walls.get(place)?);
        let Shape::Line(segment) = feature.shape else {
            return None;
        };
        let covariance = *self.covariance.get(place)?.get(place)?;
        let covariance = (covariance + covariance.transpose()) / 2.0;
        let line = segment.with_line_about(wall.origin, wall.local, covariance);
        let shape = Shape::Line(line.reaching_over(segment.ends()).canonical());
        Some(MapFeature { shape, ..*feature })
    }
}

#[cfg(test)]
mod tests;
