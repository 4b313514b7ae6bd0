//! Arc-transversal median: Choset, Nagatani and Lazar, *The Arc-Transversal Median Algorithm: A Geometric
//! Approach to Increasing Ultrasonic Sensor Azimuth Accuracy*, IEEE Trans. Robotics and Automation 19(3), 2003.
//!
//! Of an arc only the crossings with others are taken that are *transversal*: at an angle above a bound, so that
//! noise moves them little. Their median along the arc is where its echo came from. Where medians of several arcs
//! agree is a point.
//!
//! Assumed: a bound of [`TRANSVERSAL`], a window of [`SCANS`] scans around the arc, and that points of a map are
//! places where [`AGREEING_ARCS`] medians agree (the original gives places of echoes, not features).
//!
//! It has no lines: an echo's place on a wall moves with the robot, and crossings of a wall's arcs lie behind
//! it, the farther the more transversal they are. Points beyond its window's baselines have no transversal crossing.

use super::rival::{Found, Rival, Scan};
use super::triangulation::{Crossing, Window, crossings, mean};
use crate::core::geometry::{Vec2, wrap_angle};
use crate::core::statistics::median;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Point, Shape};

/// Scans in the window.
const SCANS: usize = 21;
/// The least angle of a transversal crossing, radians.
const TRANSVERSAL: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Transversal crossings that an arc needs.
const CROSSINGS: usize = 3;
/// Medians this near to each other agree, metres.
const AGREEING: f64 = 0.05;
/// Arcs whose medians make a point.
const AGREEING_ARCS: usize = 5;

/// The window, and the medians of the scans in its first half.
#[derive(Debug)]
pub struct Atm {
    window: Window,
    medians: Vec<(Vec2, Arc)>,
}

impl Default for Atm {
    fn default() -> Self {
        Self {
            window: Window::new(SCANS),
            medians: Vec::new(),
        }
    }
}

impl Atm {
    /// The places of the echoes of a scan, and the points that come of them.
    fn settle(&mut self, scan: &[Arc]) -> Vec<Found> {
        let mut found = Vec::new();
        for arc in scan {
            let Some(place) = place_of(arc, &self.window) else {
                continue;
            };
            let near = |(other, _): &&(Vec2, Arc)| (other - place).norm() < AGREEING;
            let agreeing: Vec<&(Vec2, Arc)> = self.medians.iter().filter(near).collect();
            if agreeing.len() + 1 >= AGREEING_ARCS {
                let all = agreeing.iter().map(|(place, _)| *place);
                let mut arcs: Vec<Arc> = agreeing.iter().map(|(_, arc)| *arc).collect();
                let position = mean(all.chain([place]));
                arcs.push(*arc);
                found.push(Found {
                    shape: Shape::Point(Point::without_covariance(position)),
                    arcs,
                });
            }
            self.medians.push((place, *arc));
        }
        let last = scan.last().map_or(0, |arc| arc.id.frame);
        let oldest = last.saturating_sub(SCANS as u32);
        self.medians.retain(|(_, arc)| arc.id.frame >= oldest);
        found
    }
}

/// Where the echo of an arc came from: the median of its transversal crossings along it.
fn place_of(arc: &Arc, window: &Window) -> Option<Vec2> {
    let others = window.arcs().filter(|other| other.id != arc.id);
    let transversal = |crossing: &Crossing| crossing.angle >= TRANSVERSAL;
    let yaw = arc.world_from_sensor.yaw;
    let mut along: Vec<f64> = crossings(arc, others)
        .filter(transversal)
        .map(|crossing| wrap_angle(crossing.bearing - yaw))
        .collect();
    along.sort_by(f64::total_cmp);
    let middle = median(&along).filter(|_| along.len() >= CROSSINGS)?;
    Some(arc.point_at(yaw + middle))
}

impl Rival for Atm {
    fn take(&mut self, scan: &Scan) -> Vec<Found> {
        self.window.push(scan);
        if !self.window.is_full() {
            return Vec::new();
        }
        let middle = self.window.middle().to_vec();
        self.settle(&middle)
    }

    fn finish(&mut self) -> Vec<Found> {
        let mut found = Vec::new();
        while !self.window.is_empty() {
            self.window.shorten();
            let middle = self.window.middle().to_vec();
            found.extend(self.settle(&middle));
        }
        found
    }
}
