//! The map as a witness: which of its features should have echoed, and did.
//!
//! Three readings often cannot tell a wall from a corner, but a map that was made of all of them
//! can: it says where the wall ends, and a reading whose perpendicular meets the wall beyond its end
//! came from the corner.

use std::f64::consts::FRAC_PI_2;

use super::arc::Arc;
use super::feature::{Kind, MapFeature, Point, Segment, Shape, Status};
use super::opinion::Support;
use crate::geometry::{Vec2, direction, unit, wrap_angle};

/// Standard deviations within which a feature explains a reading, and within which a place counts
/// as the end of a wall.
const SIGMAS: f64 = 3.0;

/// A point this near to a wall is its end, or stands in it, metres; beyond what the covariances say.
const CORNER: f64 = 0.02;

/// The confirmed features of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Witness {
    walls: Vec<Wall>,
    points: Vec<(u32, Point)>,
}

/// What the map says of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Testimony {
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

/// How far from the end of a wall, as it was seen, a point on it is taken for its end: metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Beyond the end.
    pub beyond: f64,
    /// Before it; and what the point's covariance says.
    pub before: f64,
    /// Off the wall's line; and what the point's covariance says.
    pub off: f64,
}

impl Reach {
    /// Of walls that end at their corners: `max_wall_gap` metres beyond what was seen of them.
    pub fn of(max_wall_gap: f64) -> Self {
        Self {
            beyond: max_wall_gap,
            before: CORNER,
            off: CORNER,
        }
    }
}

/// A wall from end to end, in coordinates along it.
#[derive(Debug, Clone, PartialEq)]
struct Wall {
    id: u32,
    segment: Segment,
    normal: Vec2,
    along: Vec2,
    low: f64,
    high: f64,
    /// Standard deviation of the two ends.
    blur: f64,
}

impl Witness {
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
        if self.testify(arc).support == Support::Neither {
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
        walls
            .chain(points)
            .min_by(|a, b| a.chi2().total_cmp(&b.chi2()))
    }

    /// What the map says of an arc.
    pub fn testify(&self, arc: &Arc) -> Testimony {
        let walls: Vec<(&Wall, Place)> = self
            .walls
            .iter()
            .filter_map(|wall| Some((wall, wall.explains(arc)?)))
            .collect();
        let point = self
            .points
            .iter()
            .filter_map(|(id, point)| Some((misfit_of_point(point, arc)?, *id)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let on = walls.iter().find(|(_, place)| *place == Place::On);
        let near_end = walls.iter().any(|(_, place)| *place == Place::AtEnd);
        match (on, point) {
            // The foot of the perpendicular is always nearer than the wall's end.
            (Some((wall, _)), _) => Testimony::of(Kind::Line, wall.id),
            (None, Some(_)) if near_end => Testimony {
                support: Support::Ambiguous,
                feature: None,
            },
            (None, Some((_, id))) => Testimony::of(Kind::Point, id),
            (None, None) => Testimony {
                support: Support::Neither,
                feature: None,
            },
        }
    }
}

impl Witness {
    /// Which features explain a reading, by their ids: every wall, and every point unless a wall
    /// should have echoed first.
    pub fn claims(&self, arc: &Arc) -> Claims {
        let mut claims = Claims::default();
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

impl Claims {
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

impl Testimony {
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
pub struct Claims {
    any: Vec<u32>,
    on_wall: bool,
    near_end: bool,
}

/// Where the perpendicular from a sensor meets a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    On,
    AtEnd,
}

impl Wall {
    fn new(id: u32, segment: Segment, points: &[(u32, Point)], reach: &Reach) -> Self {
        let (normal, along) = (unit(segment.theta), unit(segment.theta + FRAC_PI_2));
        let middle = segment.mid.dot(&along);
        let (low, high) = (middle - segment.half_length, middle + segment.half_length);
        let deviation =
            |point: &Point, axis: &Vec2| axis.dot(&(point.covariance * axis)).max(0.0).sqrt();
        // Places along the wall with their standard deviations.
        let on_line: Vec<(f64, f64)> = points
            .iter()
            .map(|(_, point)| point)
            .filter(|point| {
                let off = (point.position.dot(&normal) - segment.rho).abs();
                off <= reach.off + SIGMAS * deviation(point, &normal)
            })
            .map(|point| (point.position.dot(&along), deviation(point, &along)))
            .collect();
        // The one nearest to an end, `sign` times the way beyond it.
        let nearest = |end: f64, sign: f64| {
            on_line
                .iter()
                .filter(|(way, blur)| {
                    let beyond = sign * (way - end);
                    sign * (way - middle) > 0.0
                        && beyond > -(reach.before + SIGMAS * blur)
                        && beyond < reach.beyond
                })
                .min_by(|(a, _), (b, _)| (a - end).abs().total_cmp(&(b - end).abs()))
                .copied()
        };
        let (low, blur_low) = nearest(low, -1.0).unwrap_or((low, 0.0));
        let (high, blur_high) = nearest(high, 1.0).unwrap_or((high, 0.0));
        Self {
            id,
            segment,
            normal,
            along,
            low,
            high,
            blur: blur_low.max(blur_high),
        }
    }

    /// Where the wall would have echoed the reading, if it did within the noise.
    fn explains(&self, arc: &Arc) -> Option<Place> {
        let (fit, bearing) = self.fit(arc);
        let Fit { misfit, variance } = fit;
        if misfit * misfit > SIGMAS * SIGMAS * variance || !arc.beam_holds(bearing) {
            return None;
        }
        let way = arc.center().dot(&self.along);
        let slack = SIGMAS * self.blur;
        if way > self.low + slack && way < self.high - slack {
            Some(Place::On)
        } else if way > self.low - slack && way < self.high + slack {
            Some(Place::AtEnd)
        } else {
            None
        }
    }

    /// How far the reading is from the wall's line, and the bearing of its perpendicular.
    fn fit(&self, arc: &Arc) -> (Fit, f64) {
        let center = arc.center();
        let (away, way) = (
            self.segment.rho - center.dot(&self.normal),
            center.dot(&self.along),
        );
        let (away, bearing) = if away < 0.0 {
            (-away, wrap_angle(self.segment.theta + std::f64::consts::PI))
        } else {
            (away, self.segment.theta)
        };
        let c = &self.segment.covariance;
        let variance = c.m11 + way * (way * c.m22 - c.m12 - c.m21);
        let fit = Fit {
            misfit: arc.range - away,
            variance: arc.variance + variance.max(0.0),
        };
        (fit, bearing)
    }
}

/// Squared misfit of a point in standard deviations, where it explains the reading.
fn misfit_of_point(point: &Point, arc: &Arc) -> Option<f64> {
    let towards: Vec2 = point.position - arc.center();
    if towards.norm_squared() <= 0.0 {
        return None;
    }
    let misfit = fit_of_point(point, arc).chi2();
    (misfit < SIGMAS * SIGMAS && arc.beam_holds(direction(towards))).then_some(misfit)
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
