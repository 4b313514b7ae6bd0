//! The map as a prediction: which of its features should have echoed, and did.
//!
//! Three readings often cannot tell a wall from a corner, but a map that was made of all of them
//! can: it says where the wall ends, and a reading whose perpendicular meets the wall beyond its end
//! came from the corner.

mod wall;

pub use wall::{Reach, SIGMAS};

use serde::Serialize;

use super::arc::Arc;
use super::feature::{Circle, Kind, MapFeature, Point, Shape, Status};
use super::hypothesis::Support;
use super::residual::RangeResidual;
use crate::core::ties;
use wall::{Place, Wall};

/// A wall may go on past what was seen of it by this, metres.
const UNSEEN: f64 = 0.15;

/// The confirmed features of a map.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MapPrediction {
    walls: Vec<Wall>,
    points: Vec<(u32, Point)>,
    circles: Vec<(u32, Circle)>,
}

/// What the map says of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Prediction {
    /// Which kind of feature explains the reading. `Neither` where the map has none that does.
    #[serde(rename = "says")]
    pub support: Support,
    /// The feature that does.
    pub feature: Option<u32>,
}

impl MapPrediction {
    /// From the features of a map; walls reach as far as the corners on them.
    pub fn new(features: &[MapFeature], reach: &Reach) -> Self {
        let confirmed = || features.iter().filter(|f| f.status == Status::Confirmed);
        let points: Vec<(u32, Point)> = confirmed()
            .filter_map(|f| match f.shape {
                Shape::Point(point) => Some((f.id, point)),
                Shape::Line(_) | Shape::Circle(_) => None,
            })
            .collect();
        let circles = confirmed().filter_map(|f| match f.shape {
            Shape::Circle(circle) => Some((f.id, circle)),
            Shape::Line(_) | Shape::Point(_) => None,
        });
        let circles = circles.collect();
        let walls = confirmed()
            .filter_map(|f| match f.shape {
                Shape::Line(segment) => Some(Wall::new(f.id, segment, &points, reach)),
                Shape::Point(_) | Shape::Circle(_) => None,
            })
            .collect();
        Self {
            walls,
            points,
            circles,
        }
    }

    /// How many features it has.
    pub fn features(&self) -> usize {
        self.walls.len() + self.points.len() + self.circles.len()
    }

    /// How well the map fits an arc: by the feature that fits best. Where a wall ends is known only to about
    /// the way from reading to reading: sonars that look straight at its end while the robot drives towards it
    /// all meet it in one place, just past what the others saw.
    pub fn residual(&self, arc: &Arc) -> Option<RangeResidual> {
        let walls = self.walls.iter();
        let walls = walls.filter_map(|wall| wall.fits(arc, UNSEEN));
        let points = self.points.iter();
        let points = points.filter_map(|(_, point)| explained_by(point, arc));
        let circles = self.circles.iter();
        let circles = circles.filter_map(|(_, circle)| explained_by_circle(circle, arc));
        let residuals = walls.chain(points).chain(circles).map(|r| (r.chi2(), r));
        ties::first_least(residuals, ties::of_chi2).map(|(_, residual)| residual)
    }

    /// What the map says of an arc.
    pub fn predict(&self, arc: &Arc) -> Prediction {
        let walls: Vec<(&Wall, Place)> = self
            .walls
            .iter()
            .filter_map(|wall| Some((wall, wall.explains(arc)?.0)))
            .collect();
        let point = self
            .points
            .iter()
            .filter_map(|(id, point)| Some((explained_by(point, arc)?.chi2(), (Kind::Point, *id))));
        let circle = self.circles.iter().filter_map(|(id, circle)| {
            Some((
                explained_by_circle(circle, arc)?.chi2(),
                (Kind::Circle, *id),
            ))
        });
        let point = point.chain(circle);
        let point = ties::first_least(point, ties::of_chi2);
        let on = walls.iter().find(|(_, place)| *place == Place::On);
        let near_end = walls.iter().any(|(_, place)| *place == Place::AtEnd);
        match (on, point) {
            // The foot of the perpendicular is always nearer than the wall's end.
            (Some((wall, _)), _) => Prediction::of(Kind::Line, wall.id),
            (None, Some(_)) if near_end => Prediction {
                support: Support::Ambiguous,
                feature: None,
            },
            (None, Some((_, (kind, id)))) => Prediction::of(kind, id),
            (None, None) => Prediction {
                support: Support::Neither,
                feature: None,
            },
        }
    }
}

impl MapPrediction {
    /// Which features explain a reading, by their ids: every wall, and every point and circle unless a wall
    /// should have echoed first.
    pub fn associate(&self, arc: &Arc) -> Association {
        let mut found = Association::default();
        for wall in &self.walls {
            if let Some((place, _)) = wall.explains(arc) {
                found.any.push(wall.id);
                match place {
                    Place::On => found.on_wall = true,
                    Place::AtEnd => found.near_end = true,
                }
            }
        }
        if !found.on_wall {
            let points = self.points.iter();
            let explaining = points.filter(|(_, point)| explained_by(point, arc).is_some());
            found.any.extend(explaining.map(|(id, _)| *id));
            let circles = self.circles.iter();
            let explaining =
                circles.filter(|(_, circle)| explained_by_circle(circle, arc).is_some());
            found.any.extend(explaining.map(|(id, _)| *id));
        }
        found
    }
}

impl Association {
    /// The one feature that should have echoed, and did within the noise; `None` where none did, or
    /// where the pose does not tell which.
    pub fn owner(&self) -> Option<u32> {
        match self.any.as_slice() {
            [id] if !self.near_end => Some(*id),
            _ => None,
        }
    }

    /// Whether it may have come from the end of a wall as well as from its corner.
    pub fn is_near_end(&self) -> bool {
        self.near_end
    }

    /// Every feature that explains the reading.
    pub fn all(&self) -> &[u32] {
        &self.any
    }
}

impl Prediction {
    fn of(kind: Kind, feature: u32) -> Self {
        Self {
            support: match kind {
                Kind::Line => Support::Line,
                Kind::Point => Support::Point,
                Kind::Circle => Support::Circle,
            },
            feature: Some(feature),
        }
    }
}

/// Which features explain a reading.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Association {
    any: Vec<u32>,
    on_wall: bool,
    near_end: bool,
}

/// How far the reading is from a circle, where that explains it.
fn explained_by_circle(circle: &Circle, arc: &Arc) -> Option<RangeResidual> {
    let residual = RangeResidual::of_circle(circle, arc)?;
    (residual.chi2() < SIGMAS * SIGMAS && residual.is_in_beam(arc)).then_some(residual)
}

/// How far the reading is from a point, where that explains it.
fn explained_by(point: &Point, arc: &Arc) -> Option<RangeResidual> {
    // Most points of a large map are out of the question: no ray has more variance than this.
    let off = (point.position - arc.center()).norm() - arc.range;
    if off * off > SIGMAS * SIGMAS * (arc.variance + point.covariance.trace().max(0.0)) {
        return None;
    }
    let residual = RangeResidual::of_point(point, arc)?;
    (residual.chi2() < SIGMAS * SIGMAS && residual.is_in_beam(arc)).then_some(residual)
}
