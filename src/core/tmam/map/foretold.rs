//! Walls that their corners foretell.
//!
//! A wall that a single short run gave is tentative. Where two confirmed points lie at its two ends, and the
//! line through them is that wall within the covariances and explains its readings, three say the same.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix2, Vector2};

use super::fusion::{alike, mahalanobis_distance};
use super::refine::explains;
use crate::core::event::SonarId;
use crate::core::geometry::{Vec2, direction, unit};
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{MapFeature, Point, Segment, Shape, Status};
use crate::core::tmam::residual::RangeResidual;

/// Chi2 with two degrees of freedom up to which a wall is the foretold one: one in a thousand lies beyond.
const GATE: f64 = 13.82;
/// Points nearer to each other than this foretell no wall, metres.
const SHORTEST: f64 = 0.5;
/// Points that foretell the wall less well than this say nothing of it, metres: one standard deviation.
const FORETOLD: f64 = 0.05;
/// This near to its end a wall is not told from its corner, metres.
const MARGIN: f64 = 0.05;
/// The foot of the perpendicular lies beyond that for so many readings of the wall, at least.
const FEWEST: usize = 4;
/// A range that is longer than to the wall by this, and by three standard deviations, went through it:
/// metres.
const THROUGH: f64 = 0.05;
/// So many readings must fit the wall for each that went through it: outliers do.
const FITTING: usize = 5;

/// The tentative walls of `features` that two confirmed points foretell, confirmed. `lone` holds the
/// readings of features of a single run, `hardly` the sonars of which hardly a triple is explained.
pub fn confirm(
    features: &[MapFeature],
    lone: &BTreeMap<u32, Vec<Arc>>,
    arcs: &[Arc],
    hardly: &BTreeSet<SonarId>,
) -> Vec<MapFeature> {
    let confirmed: Vec<&MapFeature> = features
        .iter()
        .filter(|f| f.status == Status::Confirmed)
        .collect();
    let points: Vec<Point> = confirmed
        .iter()
        .filter_map(|feature| match feature.shape {
            Shape::Point(point) => Some(point),
            Shape::Line(_) | Shape::Circle(_) => None,
        })
        .collect();
    // Two points closer than a wall that is there already do not make it twice.
    let is_there = |feature: &MapFeature| confirmed.iter().any(|known| alike(known, feature, 0.0));
    let is_foretold = |feature: &&MapFeature| {
        let (Shape::Line(wall), Some(own)) = (feature.shape, lone.get(&feature.id)) else {
            return false;
        };
        let is_trusted = own.iter().all(|arc| !hardly.contains(&arc.id.sonar));
        is_trusted && !is_there(feature) && has_corners(&wall, &points, own, arcs)
    };
    features
        .iter()
        .filter(|f| f.status == Status::Tentative)
        .filter(is_foretold)
        .map(|feature| MapFeature {
            status: Status::Confirmed,
            ..*feature
        })
        .collect()
}

/// Whether two of the points lie at the ends of a wall and foretell it.
fn has_corners(wall: &Segment, points: &[Point], own: &[Arc], arcs: &[Arc]) -> bool {
    let along = wall.along();
    let near = points.iter().filter(|point| is_on_line(wall, point));
    let near: Vec<(f64, &Point)> = near.map(|p| (p.position.dot(&along), p)).collect();
    let [low, high] = wall.extent();
    let before = near.iter().filter(|(way, _)| *way < low + MARGIN);
    before.into_iter().any(|(_, first)| {
        let after = near.iter().filter(|(way, _)| *way > high - MARGIN);
        after
            .filter_map(|(_, last)| between(first, last))
            .any(|foretold| {
                let shape = Shape::Line(foretold);
                let off = mahalanobis_distance(&shape, &Shape::Line(*wall), 0.0);
                let feet = own.iter().filter(|arc| has_foot(&foretold, arc)).count();
                off.is_some_and(|off| off < GATE)
                    && feet >= FEWEST
                    && explains(&shape, own)
                    && is_closed(&foretold, arcs)
            })
    })
}

/// Whether a point lies on a wall's line as far as the covariances tell.
fn is_on_line(wall: &Segment, point: &Point) -> bool {
    let (local, covariance) = wall.about(point.position);
    let normal = unit(wall.theta);
    let variance = covariance.m11 + normal.dot(&(point.covariance * normal));
    local.x * local.x < GATE * variance
}

/// The wall from one point to another; `None` where they do not determine it.
fn between(first: &Point, last: &Point) -> Option<Segment> {
    let way = last.position - first.position;
    let length = way.norm();
    if ties::below(length, SHORTEST, ties::LENGTH) {
        return None;
    }
    let normal = Vec2::new(-way.y, way.x) / length;
    let [a, b] = [first, last].map(|point| normal.dot(&(point.covariance * normal)));
    if a.max(b) > FORETOLD * FORETOLD {
        return None;
    }
    // Seen from the middle: the distance is the mean of both ends' and the turn their difference.
    let across = (b - a) / (2.0 * length);
    let covariance = Matrix2::new((a + b) / 4.0, across, across, (a + b) / (length * length));
    let middle = (first.position + last.position) / 2.0;
    let line = Segment::of_line_about(middle, Vector2::new(0.0, direction(normal)), covariance);
    Some(
        line.reaching_over([first.position, last.position])
            .canonical(),
    )
}

/// Whether the foot of the perpendicular from a reading's sensor lies on a wall, away from its ends.
fn has_foot(wall: &Segment, arc: &Arc) -> bool {
    let [low, high] = wall.extent();
    let way = arc.center().dot(&wall.along());
    way > low + MARGIN && way < high - MARGIN
}

/// Whether the readings that should have met a wall did.
fn is_closed(wall: &Segment, arcs: &[Arc]) -> bool {
    let meeting = arcs.iter().filter(|arc| has_foot(wall, arc));
    let (mut fitting, mut through) = (0, 0);
    for arc in meeting {
        let residual = RangeResidual::of_line(wall, arc);
        if !residual.is_in_beam(arc) {
            continue;
        }
        if residual.chi2() < 9.0 {
            fitting += 1;
        } else if residual.residual > THROUGH {
            through += 1;
        }
    }
    fitting >= FITTING * through
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::tmam::fit::refit;
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};

    /// Readings on the way along x of a sensor that looks up at a wall along y = 2.
    fn readings(from: f64, count: u32, range: f64) -> Vec<Arc> {
        let mut noise = Gauss::new(3);
        let at = |k: u32| Vec2::new(from + 0.11 * f64::from(k), 0.0);
        let up = std::f64::consts::FRAC_PI_2;
        let mut one = |k| arc(k, at(k), up, range + SIGMA * noise.sample());
        (0..count).map(&mut one).collect()
    }

    fn feature(id: u32, shape: Shape, status: Status) -> MapFeature {
        MapFeature {
            id,
            shape,
            readings: 6,
            runs: 1,
            status,
        }
    }

    fn post(id: u32, x: f64, y: f64) -> MapFeature {
        let point = Point {
            position: Vec2::new(x, y),
            covariance: Matrix2::identity() * 4e-6,
        };
        feature(id, Shape::Point(point), Status::Confirmed)
    }

    /// The wall that so many readings give, tentative.
    fn wall(own: &[Arc]) -> MapFeature {
        let start = Segment {
            rho: 2.0,
            theta: std::f64::consts::FRAC_PI_2,
            covariance: Matrix2::identity(),
            mid: Vec2::new(0.0, 2.0),
            half_length: 1.0,
        };
        let Some(Shape::Line(line)) = refit(&Shape::Line(start), own).map(|fit| fit.shape) else {
            panic!("no wall");
        };
        let feet = own.iter().map(|arc| arc.center() + Vec2::new(0.0, 2.0));
        feature(0, Shape::Line(line.reaching_over(feet)), Status::Tentative)
    }

    fn confirms(own: &[Arc], posts: &[MapFeature], arcs: &[Arc]) -> bool {
        let features = [&[wall(own)], posts].concat();
        let lone = BTreeMap::from([(0, own.to_vec())]);
        let arcs = [own, arcs].concat();
        !confirm(&features, &lone, &arcs, &BTreeSet::new()).is_empty()
    }

    #[test]
    fn two_corners_confirm_the_wall_between_them() {
        let own = readings(0.0, 6, 2.0);
        assert!(confirms(
            &own,
            &[post(1, -1.0, 2.0), post(2, 1.5, 2.0)],
            &[]
        ));
        // One corner, two at one end, one off the line by more than it can be, or none.
        for posts in [
            vec![post(1, -1.0, 2.0)],
            vec![post(1, -1.0, 2.0), post(2, -0.4, 2.0)],
            vec![post(1, -1.0, 2.0), post(2, 1.5, 2.4)],
            vec![],
        ] {
            assert!(!confirms(&own, &posts, &[]), "{posts:?}");
        }
    }

    #[test]
    fn what_others_looked_through_is_no_wall() {
        let own = readings(0.0, 6, 2.0);
        let posts = [post(1, -1.0, 2.0), post(2, 1.5, 2.0)];
        assert!(confirms(&own, &posts, &readings(0.1, 1, 3.0)), "an outlier");
        assert!(!confirms(&own, &posts, &readings(0.1, 3, 3.0)));
        // Nearer things hide it, and readings beside it say nothing.
        assert!(confirms(&own, &posts, &readings(0.1, 3, 1.0)));
        assert!(confirms(&own, &posts, &readings(2.0, 3, 3.0)));
    }

    #[test]
    fn a_sonar_that_is_hardly_explained_gives_no_such_wall() {
        let own = readings(0.0, 6, 2.0);
        let features = [wall(&own), post(1, -1.0, 2.0), post(2, 1.5, 2.0)];
        let lone = BTreeMap::from([(0, own.clone())]);
        let hardly = BTreeSet::from([SonarId(0)]);
        assert!(confirm(&features, &lone, &own, &hardly).is_empty());
    }
}
