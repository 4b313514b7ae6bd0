//! The map as it grows: walls, points and how sure they are.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::Write;

use rerun::{AsComponents, LineStrips2D, Points2D, SerializationResult, SerializedComponentColumn};

use super::Error;
use super::arcs::xy;
use super::encode::RrdWriter;
use super::style::{self, order, ui};
use super::table::{Instance, Moment, Table, Timelines, put_static};
use crate::geometry::{Vec2, unit};
use crate::tmam::feature::{Kind, MapFeature, Point, Segment, Shape};

/// How many standard deviations the outlines of uncertainty lie out.
pub const SIGMAS: f64 = 3.0;

struct Wall {
    ends: [[f32; 2]; 2],
    label: String,
}

impl Instance for Wall {
    fn columns(
        walls: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let (ends, labels): (Vec<_>, Vec<_>) = walls
            .into_iter()
            .map(|wall| (wall.ends, wall.label))
            .unzip();
        Ok(LineStrips2D::update_fields()
            .with_strips(ends)
            .with_labels(labels)
            .columns(lengths.iter().copied())?
            .collect())
    }
}

struct Corner {
    position: [f32; 2],
    label: String,
}

impl Instance for Corner {
    fn columns(
        corners: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let (positions, labels): (Vec<_>, Vec<_>) = corners
            .into_iter()
            .map(|corner| (corner.position, corner.label))
            .unzip();
        Ok(Points2D::update_fields()
            .with_positions(positions)
            .with_labels(labels)
            .columns(lengths.iter().copied())?
            .collect())
    }
}

struct Outline(Vec<[f32; 2]>);

impl Instance for Outline {
    fn columns(
        outlines: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        Ok(LineStrips2D::update_fields()
            .with_strips(outlines.into_iter().map(|outline| outline.0))
            .columns(lengths.iter().copied())?
            .collect())
    }
}

/// The map so far and its rows.
///
/// A change rewrites the [`PAGE`] features around the changed one, not the whole map: else the
/// bytes of a long run would grow with the square of its length.
pub struct MapTables {
    features: BTreeMap<u32, MapFeature>,
    lines: Pages<Wall>,
    points: Pages<Corner>,
    covariance: Pages<Outline>,
}

/// Features per page: ids `PAGE * n` and up are at `/world/map/<what>/<n>`.
const PAGE: u32 = 16;

struct Pages<T> {
    path: &'static str,
    tables: BTreeMap<u32, Table<T>>,
}

impl<T: Instance> Pages<T> {
    fn new(path: &'static str) -> Self {
        Self {
            path,
            tables: BTreeMap::new(),
        }
    }

    fn push<W: Write>(
        &mut self,
        page: u32,
        at: Moment,
        row: Vec<T>,
        look: &dyn AsComponents,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let table = match self.tables.entry(page) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let path = format!("{}/{page}", self.path);
                put_static(path.as_str(), look, out)?;
                entry.insert(Table::new(path.as_str()))
            }
        };
        table.push(at, row, lines, out)
    }

    fn flush<W: Write>(&mut self, lines: Timelines, out: &mut RrdWriter<W>) -> Result<(), Error> {
        for table in self.tables.values_mut() {
            table.flush(lines, out)?;
        }
        Ok(())
    }
}

impl MapTables {
    /// An empty map.
    pub fn new() -> Self {
        Self {
            features: BTreeMap::new(),
            lines: Pages::new("/world/map/lines"),
            points: Pages::new("/world/map/points"),
            covariance: Pages::new("/world/map/covariance"),
        }
    }

    /// Takes in features that are new or were updated, and logs the map after them.
    pub fn update<W: Write>(
        &mut self,
        at: Moment,
        changed: impl IntoIterator<Item = MapFeature>,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        let mut touched = BTreeMap::<u32, [bool; 2]>::new();
        for feature in changed {
            let [walls, corners] = touched.entry(feature.id / PAGE).or_default();
            match feature.shape.kind() {
                Kind::Line => *walls = true,
                Kind::Point => *corners = true,
            }
            self.features.insert(feature.id, feature);
        }
        for (page, [walls, corners]) in touched {
            if walls {
                let row = self.page(page).filter_map(wall).collect();
                self.lines.push(page, at, row, &wall_look(), lines, out)?;
            }
            if corners {
                let row = self.page(page).filter_map(corner).collect();
                self.points
                    .push(page, at, row, &corner_look(), lines, out)?;
            }
            let row = self.page(page).map(outline).collect();
            self.covariance
                .push(page, at, row, &outline_look(), lines, out)?;
        }
        Ok(())
    }

    fn page(&self, page: u32) -> impl Iterator<Item = &MapFeature> {
        let first = page * PAGE;
        self.features
            .range(first..=first.saturating_add(PAGE - 1))
            .map(|(_, feature)| feature)
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.lines.flush(lines, out)?;
        self.points.flush(lines, out)?;
        self.covariance.flush(lines, out)
    }
}

fn wall(feature: &MapFeature) -> Option<Wall> {
    match &feature.shape {
        Shape::Line(segment) => Some(Wall {
            ends: segment.ends().map(xy),
            label: format!("line {} ({} readings)", feature.id, feature.readings),
        }),
        Shape::Point(_) => None,
    }
}

fn corner(feature: &MapFeature) -> Option<Corner> {
    match &feature.shape {
        Shape::Point(point) => Some(Corner {
            position: xy(point.position),
            label: format!("point {} ({} readings)", feature.id, feature.readings),
        }),
        Shape::Line(_) => None,
    }
}

fn outline(feature: &MapFeature) -> Outline {
    let around = match &feature.shape {
        Shape::Line(segment) => band(segment),
        Shape::Point(point) => ellipse(point),
    };
    Outline(around.into_iter().map(xy).collect())
}

fn tangent(segment: &Segment) -> Vec2 {
    let normal = unit(segment.theta);
    Vec2::new(-normal.y, normal.x)
}

/// Where the line may run: [`SIGMAS`] of its distance to either side, all along the segment.
///
/// A point of the line at `s` from the foot of the origin's perpendicular moves by
/// `d rho - s d theta` along the normal.
fn band(segment: &Segment) -> Vec<Vec2> {
    const STEPS: u32 = 4;
    let (normal, tangent) = (unit(segment.theta), tangent(segment));
    let (rr, rt, tt) = (
        segment.covariance.m11,
        segment.covariance.m12,
        segment.covariance.m22,
    );
    let offset = |at: Vec2| {
        let s = at.dot(&tangent);
        SIGMAS * (rr - 2.0 * s * rt + s * s * tt).max(0.0).sqrt()
    };
    let stations: Vec<Vec2> = (0..=STEPS)
        .map(|i| f64::from(i) / f64::from(STEPS) * 2.0 - 1.0)
        .map(|t| segment.mid + tangent * (t * segment.half_length))
        .collect();
    let near = stations.iter().map(|at| at + normal * offset(*at));
    let far = stations.iter().rev().map(|at| at - normal * offset(*at));
    let mut outline: Vec<Vec2> = near.chain(far).collect();
    outline.extend(outline.first().copied());
    outline
}

/// The ellipse at [`SIGMAS`] around a point, closed.
fn ellipse(point: &Point) -> Vec<Vec2> {
    const STEPS: u32 = 24;
    let (a, b, d) = (
        point.covariance.m11,
        point.covariance.m12,
        point.covariance.m22,
    );
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

fn wall_look() -> LineStrips2D {
    LineStrips2D::update_fields()
        .with_radii([ui(2.5)])
        .with_colors([style::WALL])
        .with_show_labels(false)
        .with_draw_order(order::WALL)
}

fn corner_look() -> Points2D {
    Points2D::update_fields()
        .with_radii([ui(4.5)])
        .with_colors([style::CORNER])
        .with_show_labels(false)
        .with_draw_order(order::CORNER)
}

fn outline_look() -> LineStrips2D {
    LineStrips2D::update_fields()
        .with_radii([ui(0.5)])
        .with_colors([style::COVARIANCE])
        .with_draw_order(order::COVARIANCE)
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
