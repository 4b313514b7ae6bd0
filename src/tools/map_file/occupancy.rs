//! The map as an occupancy grid, as nav2's map_server and its like read it: an image in PGM, and YAML that says
//! where it lies.
//!
//! Occupied is what the confirmed walls and points cover. Free is what the robot drove over, and what lies before
//! the echo in a beam whose reading the map explains, up to the first wall: sound that found no foot of a
//! perpendicular in its beam says nothing of a wall that it passed along. All else is unknown.

use std::io::{self, Write};

use crate::core::geometry::{Vec2, unit};
use crate::core::replay::Outcome;
use crate::core::rounding::fixed;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Segment, Shape, Status};
use crate::core::tmam::hypothesis::Support;

/// The side of a cell, metres; doubled for a map of more cells than [`MOST`].
const RESOLUTION: f64 = 0.05;
/// Cells along a side, at most.
const MOST: f64 = 4096.0;
/// Room round all that is drawn, metres.
const ROOM: f64 = 0.5;

/// Grey as map_server has it: the darker the more likely to be occupied.
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

/// A grid of cells.
pub struct Occupancy {
    /// The lower left corner of the lowest cell to the left, metres.
    origin: Vec2,
    /// Metres a cell.
    resolution: f64,
    width: usize,
    height: usize,
    /// Row by row from the top.
    cells: Vec<u8>,
}

impl Occupancy {
    /// Of a replay along a path.
    pub fn of(outcome: &Outcome, path: &[Vec2]) -> Self {
        let confirmed = || outcome.map.iter().filter(|f| f.status == Status::Confirmed);
        let walls: Vec<Segment> = confirmed()
            .filter_map(|feature| match feature.shape {
                Shape::Line(line) => Some(line),
                Shape::Point(_) | Shape::Circle(_) => None,
            })
            .collect();
        let points = confirmed().flat_map(|feature| match feature.shape {
            Shape::Point(point) => vec![point.position],
            Shape::Circle(circle) => circle.outline().collect(),
            Shape::Line(_) => Vec::new(),
        });
        let points: Vec<Vec2> = points.collect();
        let ends = walls.iter().flat_map(|wall| wall.ends());
        let mut grid = Self::around(path.iter().copied().chain(ends).chain(points.clone()));
        let is_explained = |says| matches!(says, Support::Line | Support::Point | Support::Circle);
        let explained = outcome
            .reports
            .iter()
            .filter(|report| report.map.is_some_and(|map| is_explained(map.support)));
        for report in explained {
            grid.clear(&report.arc, &walls);
        }
        for (from, to) in path.iter().zip(path.iter().skip(1)) {
            grid.line(*from, *to, FREE);
        }
        for wall in &walls {
            let [from, to] = wall.ends();
            grid.line(from, to, OCCUPIED);
        }
        for point in points {
            grid.set(point, OCCUPIED);
        }
        grid
    }

    /// A grid round all these places of which nothing is known.
    fn around(places: impl Iterator<Item = Vec2>) -> Self {
        let finite = places.filter(|place| place.iter().all(|x| x.is_finite()));
        let bounds = finite.map(|place| (place, place));
        let bounds = bounds.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
        let (min, max) = bounds.unwrap_or((Vec2::zeros(), Vec2::zeros()));
        let (min, max) = (min.add_scalar(-ROOM), max.add_scalar(ROOM));
        let mut resolution = RESOLUTION;
        while (max - min).amax() / resolution >= MOST {
            resolution *= 2.0;
        }
        let origin = (min / resolution).map(f64::floor) * resolution;
        let size = ((max - origin) / resolution).map(f64::ceil);
        let (width, height) = (size.x as usize, size.y as usize);
        Self {
            origin,
            resolution,
            width,
            height,
            cells: vec![UNKNOWN; width * height],
        }
    }

    /// What lies in the beam of an arc before its echo, up to the first wall, is free.
    fn clear(&mut self, arc: &Arc, walls: &[Segment]) {
        let rays = (arc.range * arc.beam_width / self.resolution)
            .ceil()
            .max(1.0);
        let right = arc.world_from_sensor.yaw - arc.beam_width / 2.0;
        for ray in 0..=rays as u32 {
            let ahead = unit(right + arc.beam_width * f64::from(ray) / rays);
            let free = walls
                .iter()
                .filter_map(|wall| crossing(wall, arc.center(), ahead));
            let free = free.fold(arc.range, f64::min);
            // The cell of what echoed is not free.
            let free = free - self.resolution;
            if free > 0.0 {
                self.line(arc.center(), arc.center() + ahead * free, FREE);
            }
        }
    }

    /// Sets the cells from one place to another.
    fn line(&mut self, from: Vec2, to: Vec2, value: u8) {
        let steps = ((to - from).norm() / self.resolution * 2.0).ceil().max(1.0);
        for step in 0..=steps as u32 {
            self.set(from + (to - from) * (f64::from(step) / steps), value);
        }
    }

    fn set(&mut self, place: Vec2, value: u8) {
        let cell = (place - self.origin) / self.resolution;
        if !(cell.x >= 0.0 && cell.y >= 0.0) {
            return;
        }
        let (column, row) = (cell.x as usize, cell.y as usize);
        let above = self.height.checked_sub(row + 1);
        if let Some(above) = above.filter(|_| column < self.width)
            && let Some(cell) = self.cells.get_mut(above * self.width + column)
        {
            *cell = value;
        }
    }

    /// Writes the image: PGM, binary, with grey from 0 to 255.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        write!(out, "P5\n{} {}\n255\n", self.width, self.height)?;
        out.write_all(&self.cells)
    }

    /// What the image means, in YAML: text as JSON has it is YAML, too.
    pub fn meaning(&self, image: &str) -> String {
        format!(
            "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, 0.0]\nnegate: 0\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n",
            serde_json::Value::from(image),
            self.resolution,
            fixed(self.origin.x, 3),
            fixed(self.origin.y, 3),
        )
    }
}

/// How far ahead of a place a wall is met.
fn crossing(wall: &Segment, from: Vec2, ahead: Vec2) -> Option<f64> {
    let normal = unit(wall.theta);
    let way = (wall.rho - normal.dot(&from)) / normal.dot(&ahead);
    let met = from + ahead * way;
    let is_met = way > 0.0 && (met - wall.mid).norm() <= wall.half_length;
    is_met.then_some(way)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::event::SonarId;
    use crate::core::geometry::Pose2;
    use crate::core::tmam::arc::ArcId;

    #[test]
    fn a_beam_clears_what_lies_before_its_echo_and_no_wall() {
        let mut grid = Occupancy::around([Vec2::zeros(), Vec2::new(4.0, 2.0)].into_iter());
        let wall = Segment {
            rho: 3.0,
            theta: 0.0,
            covariance: nalgebra::Matrix2::identity(),
            mid: Vec2::new(3.0, 0.0),
            half_length: 1.0,
        };
        let id = ArcId {
            frame: 0,
            sonar: SonarId(0),
        };
        let arc = Arc {
            id,
            stamp_ns: 0,
            world_from_sensor: Pose2::new(0.0, 0.0, 0.0),
            range: 3.8,
            beam_width: 0.4,
            variance: 1e-6,
        };
        grid.clear(&arc, &[wall]);
        let at = |x: f64, y: f64| {
            let cell = (Vec2::new(x, y) - grid.origin) / grid.resolution;
            let above = grid.height - 1 - cell.y as usize;
            grid.cells[above * grid.width + cell.x as usize]
        };
        assert_eq!([at(1.0, 0.0), at(2.9, 0.0), at(2.0, 0.3)], [FREE; 3]);
        assert_eq!([at(3.2, 0.0), at(1.0, 0.5), at(3.7, 0.0)], [UNKNOWN; 3]);
    }

    #[test]
    fn a_map_of_any_size_has_a_grid() {
        let far = Vec2::new(1e9, -1e9);
        for places in [vec![], vec![Vec2::zeros()], vec![Vec2::zeros(), far]] {
            let grid = Occupancy::around(places.into_iter());
            assert!(grid.width <= 4097 && grid.height <= 4097 && !grid.cells.is_empty());
            assert_eq!(grid.cells.len(), grid.width * grid.height);
        }
    }
}
