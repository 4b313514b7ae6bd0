//! The map as it grows: walls, points, pillars and how sure they are.

use std::collections::{BTreeMap, BTreeSet};

use rerun::Color;

use super::canvas::{Canvas, Dot, Mark, Moment, Shown, Strip};
use super::entity::Entity;
use super::style;
use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::feature::{Kind, MapFeature, Point, Segment, Shape, Status};
use crate::core::tmam::step::Step;
use crate::core::wording::counted;
use crate::observe::viewer::Error;

/// Features per page: ids `PAGE * n` and up are at `/world/map/<what>/<n>`.
///
/// A change rewrites the page around the changed feature, not the whole map: else the bytes of a long
/// run would grow with the square of its length.
const PAGE: u32 = 16;

/// The map so far.
#[derive(Default)]
pub struct DrawnMap {
    features: BTreeMap<u32, MapFeature>,
}

impl DrawnMap {
    /// Takes in what a step changed in the map, and draws the map after it.
    pub fn draw(&mut self, at: Moment, step: &Step, canvas: &mut Canvas<'_>) -> Result<(), Error> {
        // The kinds of feature that changed, by page.
        let mut touched = BTreeMap::<u32, BTreeSet<&str>>::new();
        let mut touch = |feature: &MapFeature| {
            let kinds = touched.entry(feature.id / PAGE).or_default();
            kinds.insert(feature.shape.kind().name());
        };
        for extraction in &step.extractions {
            let absorbed = extraction.absorbed.iter();
            let gone = absorbed.filter_map(|id| self.features.remove(id));
            gone.for_each(|gone| touch(&gone));
            if let Some(feature) = extraction.map_feature {
                touch(&feature);
                self.features.insert(feature.id, feature);
            }
        }
        let gone = step.absorbed.iter();
        let gone = gone.filter_map(|id| self.features.remove(id));
        gone.for_each(|gone| touch(&gone));
        for feature in &step.settled {
            touch(feature);
            // A point that turned out to be a circle is a point no longer.
            if let Some(before) = self.features.insert(feature.id, *feature) {
                touch(&before);
            }
        }
        for (page, kinds) in touched {
            self.draw_page(page, at, &kinds, canvas)?;
        }
        Ok(())
    }

    fn draw_page(
        &self,
        page: u32,
        at: Moment,
        kinds: &BTreeSet<&str>,
        canvas: &mut Canvas<'_>,
    ) -> Result<(), Error> {
        let (origin, first) = (canvas.origin, page * PAGE);
        let features = || {
            let page = self.features.range(first..=first.saturating_add(PAGE - 1));
            page.map(|(_, feature)| feature)
        };
        let of_lines = features().filter_map(|feature| match &feature.shape {
            Shape::Line(line) => {
                let ends = line.ends().map(|end| origin.xy(end)).to_vec();
                Some(mark(ends, feature, style::WALL))
            }
            Shape::Point(_) | Shape::Circle(_) => None,
        });
        let of_points = features().filter_map(|feature| match &feature.shape {
            Shape::Point(point) => Some(mark(origin.xy(point.position), feature, style::CORNER)),
            Shape::Line(_) | Shape::Circle(_) => None,
        });
        let of_circles = features().filter_map(|feature| match &feature.shape {
            Shape::Circle(circle) => {
                let outline = circle.outline().map(|at| origin.xy(at)).collect();
                Some(mark(outline, feature, style::PILLAR))
            }
            Shape::Line(_) | Shape::Point(_) => None,
        });
        if kinds.contains(Kind::Line.name()) {
            canvas.row(
                Entity::MapLines(page),
                at,
                Shown::Strips(of_lines.collect()),
            )?;
        }
        if kinds.contains(Kind::Point.name()) {
            canvas.row(
                Entity::MapPoints(page),
                at,
                Shown::Dots(of_points.collect()),
            )?;
        }
        if kinds.contains(Kind::Circle.name()) {
            let circles = Shown::Strips(of_circles.collect());
            canvas.row(Entity::MapCircles(page), at, circles)?;
        }
        let ids = features().filter(|feature| feature.status == Status::Confirmed);
        let ids = ids
            .map(|feature| Dot::named(origin.xy(feature.shape.middle()), feature.id.to_string()));
        canvas.row(Entity::MapIds(page), at, Shown::Dots(ids.collect()))?;
        let known = features().filter(|feature| feature.shape.covariance().is_some());
        let outlines = known.map(|feature| {
            let covariance = feature.shape.covariance().unwrap_or_default();
            let outline = match &feature.shape {
                Shape::Line(segment) => band(segment),
                Shape::Point(point) => ellipse(point),
                Shape::Circle(circle) => ellipse(&Point {
                    position: circle.center,
                    covariance,
                }),
            };
            let outline = outline.into_iter().map(|at| origin.xy(at));
            Strip::from(outline.collect::<Vec<_>>())
        });
        let outlines = Shown::Strips(outlines.collect());
        canvas.row(Entity::MapCovariance(page), at, outlines)
    }

    /// How many confirmed lines, confirmed points, confirmed circles and tentative features the map has.
    pub fn counts(&self) -> [usize; 4] {
        let mut counts = [0; 4];
        let [lines, points, circles, tentative] = &mut counts;
        for feature in self.features.values() {
            match (feature.status, feature.shape.kind()) {
                (Status::Confirmed, Kind::Line) => *lines += 1,
                (Status::Confirmed, Kind::Point) => *points += 1,
                (Status::Confirmed, Kind::Circle) => *circles += 1,
                (Status::Tentative, _) => *tentative += 1,
            }
        }
        counts
    }
}

fn mark<P>(at: P, feature: &MapFeature, confirmed: Color) -> Mark<P> {
    let color = match feature.status {
        Status::Confirmed => confirmed,
        Status::Tentative => style::TENTATIVE,
    };
    let name = format!(
        "{} {}, {} ({}, {})",
        feature.shape.kind().name(),
        feature.id,
        feature.status.name(),
        counted(feature.readings.into(), "reading"),
        counted(feature.runs.into(), "run")
    );
    Mark {
        color: Some(color),
        ..Mark::named(at, name)
    }
}

/// How many standard deviations the outlines of uncertainty lie out.
const SIGMAS: f64 = 3.0;

/// Where the line may run: [`SIGMAS`] of its distance to either side, all along the segment.
///
/// A point of the line at `s` from the foot of the origin's perpendicular moves by
/// `d rho - s d theta` along the normal.
fn band(segment: &Segment) -> Vec<Vec2> {
    const STEPS: u32 = 4;
    let normal = unit(segment.theta);
    let tangent = Vec2::new(-normal.y, normal.x);
    let covariance = &segment.covariance;
    let (rr, rt, tt) = (covariance.m11, covariance.m12, covariance.m22);
    let offset = |at: Vec2| {
        let s = at.dot(&tangent);
        SIGMAS * (rr - 2.0 * s * rt + s * s * tt).max(0.0).sqrt()
    };
    let shares = (0..=STEPS).map(|i| f64::from(i) / f64::from(STEPS) * 2.0 - 1.0);
    let stations = shares.map(|t| segment.mid + tangent * (t * segment.half_length));
    let stations: Vec<Vec2> = stations.collect();
    let near = stations.iter().map(|at| at + normal * offset(*at));
    let far = stations.iter().rev().map(|at| at - normal * offset(*at));
    let mut outline: Vec<Vec2> = near.chain(far).collect();
    outline.extend(outline.first().copied());
    outline
}

/// The ellipse at [`SIGMAS`] around a point, closed.
pub fn ellipse(point: &Point) -> Vec<Vec2> {
    const STEPS: u32 = 24;
    let covariance = &point.covariance;
    let (a, b, d) = (covariance.m11, covariance.m12, covariance.m22);
    // The lower triangular root of the covariance takes the unit circle to the ellipse.
    let l11 = a.max(0.0).sqrt();
    let l21 = if l11 > 0.0 { b / l11 } else { 0.0 };
    let l22 = (d - l21 * l21).max(0.0).sqrt();
    (0..=STEPS)
        .map(|i| std::f64::consts::TAU * f64::from(i % STEPS) / f64::from(STEPS))
        .map(unit)
        .map(|c| point.position + Vec2::new(l11 * c.x, l21 * c.x + l22 * c.y) * SIGMAS)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix2;

    #[test]
    fn the_ellipse_lies_three_sigmas_out_in_every_direction() {
        let covariance = Matrix2::new(0.04, 0.01, 0.01, 0.02);
        let point = Point {
            position: Vec2::new(1.0, -2.0),
            covariance,
        };
        let inverse = covariance.try_inverse().unwrap();
        let outline = ellipse(&point);
        for corner in &outline {
            let off = corner - point.position;
            let mahalanobis = off.dot(&(inverse * off));
            assert!((mahalanobis - SIGMAS * SIGMAS).abs() < 1e-9);
        }
        assert_eq!(outline.first(), outline.last());
    }

    #[test]
    fn the_band_of_a_sure_line_is_the_line() {
        let segment = Segment {
            rho: 2.0,
            theta: std::f64::consts::FRAC_PI_2,
            covariance: Matrix2::zeros(),
            mid: Vec2::new(3.0, 2.0),
            half_length: 1.5,
        };
        for at in band(&segment) {
            assert!((at.y - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn an_uncertain_angle_opens_the_band_away_from_the_foot() {
        let mut covariance = Matrix2::zeros();
        covariance.m22 = 0.01;
        let segment = Segment {
            rho: 2.0,
            theta: 0.0,
            covariance,
            mid: Vec2::new(2.0, 5.0),
            half_length: 1.0,
        };
        let widest = band(&segment).iter().map(|at| at.x).fold(0.0, f64::max);
        assert!((widest - (2.0 + 3.0 * 0.1 * 6.0)).abs() < 1e-9);
    }
}
