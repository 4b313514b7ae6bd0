//! The map as a prediction: which of its features should have echoed, and did.
//!
//! Three readings often cannot tell a wall from a corner, but a map that was made of all of them
//! can: it says where the wall ends, and a reading whose perpendicular meets the wall beyond its end
//! came from the corner.

mod wall;

pub use wall::Reach;

use super::arc::Arc;
use super::feature::{Kind, MapFeature, Point, Shape, Status};
use super::hypothesis::Support;
use crate::core::geometry::{Vec2, direction};
use crate::core::ties;
use wall::{Place, Wall};

/// Standard deviations within which a feature explains a reading, and within which a place counts
/// as the end of a wall.
const SIGMAS: f64 = 3.0;

/// The confirmed features of a map.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MapPrediction {
    walls: Vec<Wall>,
    points: Vec<(u32, Point)>,
}

/// What the map says of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Which kind of feature explains the reading. `Neither` where the map has none that does.
    pub support: Support,
    /// The feature that does.
    pub feature: Option<u32>,
}

/// How far a reading is from what a feature should have given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Range beyond the feature, metres.
    pub misfit: f64,
    /// Its variance, square metres: the reading's and the feature's.
    pub variance: f64,
}

impl Fit {
    /// The misfit in standard deviations, squared.
    pub fn chi2(&self) -> f64 {
        self.misfit * self.misfit / self.variance
    }
}

impl MapPrediction {
    /// From the features of a map; walls reach as far as the corners on them.
    pub fn new(features: &[MapFeature], reach: &Reach) -> Self {
        let confirmed = || features.iter().filter(|f| f.status == Status::Confirmed);
        let points: Vec<(u32, Point)> = confirmed()
            .filter_map(|f| match f.shape {
                Shape::Point(point) => Some((f.id, point)),
                Shape::Line(_) => None,
            })
            .collect();
        let walls = confirmed()
            .filter_map(|f| match f.shape {
                Shape::Line(segment) => Some(Wall::new(f.id, segment, &points, reach)),
                Shape::Point(_) => None,
            })
            .collect();
        Self { walls, points }
    }

    /// How many features it has.
    pub fn features(&self) -> usize {
        self.walls.len() + self.points.len()
    }

    /// How well the map fits an arc: by the feature that fits best of those that explain it.
    pub fn fit(&self, arc: &Arc) -> Option<Fit> {
        if self.predict(arc).support == Support::Neither {
            return None;
        }
        let walls = self.walls.iter().filter_map(|wall| {
            wall.explains(arc)?;
            Some(wall.fit(arc).0)
        });
        let points = self.points.iter().filter_map(|(_, point)| {
            misfit_of_point(point, arc)?;
            Some(fit_of_point(point, arc))
        });
        let fits = walls.chain(points).map(|fit| (fit.chi2(), fit));
        ties::first_least(fits, ties::of_chi2).map(|(_, fit)| fit)
    }

    /// What the map says of an arc.
    pub fn predict(&self, arc: &Arc) -> Prediction {
        let walls: Vec<(&Wall, Place)> = self
            .walls
            .iter()
            .filter_map(|wall| Some((wall, wall.explains(arc)?)))
            .collect();
        let point = self
            .points
            .iter()
            .filter_map(|(id, point)| Some((misfit_of_point(point, arc)?, *id)));
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
            (None, Some((_, id))) => Prediction::of(Kind::Point, id),
            (None, None) => Prediction {
                support: Support::Neither,
                feature: None,
            },
        }
    }
}

impl MapPrediction {
    /// Which features explain a reading, by their ids: every wall, and every point unless a wall
    /// should have echoed first.
    pub fn claims(&self, arc: &Arc) -> Association {
        let mut claims = Association::default();
        for wall in &self.walls {
            if let Some(place) = wall.explains(arc) {
                claims.any.push(wall.id);
                match place {
                    Place::On => claims.on_wall = true,
                    Place::AtEnd => claims.near_end = true,
                }
            }
        }
        if !claims.on_wall {
            let points = self.points.iter();
            let explaining = points.filter(|(_, point)| misfit_of_point(point, arc).is_some());
            claims.any.extend(explaining.map(|(id, _)| *id));
        }
        claims
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

/// Squared misfit of a point in standard deviations, where it explains the reading.
fn misfit_of_point(point: &Point, arc: &Arc) -> Option<f64> {
    let towards: Vec2 = point.position - arc.center();
    if towards.norm() < ties::LENGTH {
        return None;
    }
    let misfit = fit_of_point(point, arc).chi2();
    let held = arc.beam_nearly_holds(direction(towards), ties::ANGLE);
    (misfit < SIGMAS * SIGMAS && held).then_some(misfit)
}

/// How far the reading is from a point; the sensor must not stand on it.
fn fit_of_point(point: &Point, arc: &Arc) -> Fit {
    let towards: Vec2 = point.position - arc.center();
    let range = towards.norm();
    let ray = towards / range;
    Fit {
        misfit: arc.range - range,
        variance: arc.variance + ray.dot(&(point.covariance * ray)).max(0.0),
    }
}
