//! Triangulation-based fusion: Wijk and Christensen, *Triangulation-Based Fusion of Sonar Data with
//! Application in Robot Pose Tracking*, IEEE Trans. Robotics and Automation 16(6), 2000.
//!
//! Every new arc is crossed with all arcs in a window of ten scans of all sonars. Crossings that agree vote for
//! one hypothesis, whose place is their mean. With enough votes, and where a local grid of the window's
//! readings confirms it, it is a triangulation point. Lines come from the weaker hypotheses as well, by a
//! Hough transform at the end of the log.
//!
//! Assumed: the numbers below, and that a mean of all voters does what the original's recursive mean does.
//!
//! It looks for points. A wall's neighbouring arcs cross too, a little behind it, so lines are a by-product
//! without covariance, and walls that are seen from afar give points where crossings agree by chance.

use super::hough;
use super::rival::{Found, Rival, Scan};
use super::triangulation::{Crossing, Window, crossings, mean};
use crate::core::config::Config;
use crate::core::geometry::{Vec2, direction};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Point, Shape};

/// Scans in the window.
const SCANS: usize = 10;
/// Crossings this near to each other agree, metres.
const AGREEING: f64 = 0.05;
/// Votes that a triangulation point needs.
const POINT_VOTES: usize = 5;
/// Votes that a place needs for the Hough transform.
const LINE_VOTES: usize = 2;
/// Cells of the local grid are this wide, metres,
const CELL: f64 = 0.02;
/// and it has so many of them to either side.
const REACH: i32 = 3;

/// The window, and the places for lines.
#[derive(Debug)]
pub struct Tbf {
    window: Window,
    places: Vec<(Vec2, Arc)>,
    longest_gap: f64,
}

impl Tbf {
    pub fn new(config: &Config) -> Self {
        Self {
            window: Window::new(SCANS),
            places: Vec::new(),
            longest_gap: config.map.max_wall_gap,
        }
    }
}

/// The crossings that vote for the hypothesis with most votes: those near one of them, one of each arc.
fn voters(crossings: &[Crossing]) -> Vec<&Crossing> {
    let near = |hypothesis: &Crossing| {
        let mut voters: Vec<&Crossing> = (crossings.iter())
            .filter(|crossing| (crossing.place - hypothesis.place).norm() < AGREEING)
            .collect();
        voters.dedup_by_key(|crossing| crossing.arc.id);
        voters
    };
    let hypotheses = crossings.iter().map(near);
    hypotheses.fold(Vec::new(), |best, voters| {
        if voters.len() > best.len() {
            voters
        } else {
            best
        }
    })
}

/// Whether a cell of the local grid near a place is confirmed: more of the window's arcs pass through it
/// than see through it, and enough of them.
fn is_confirmed(place: Vec2, arcs: &[Arc]) -> bool {
    let cells = (-REACH..=REACH).flat_map(|x| (-REACH..=REACH).map(move |y| (x, y)));
    let mut cells = cells.map(|(x, y)| place + Vec2::new(f64::from(x), f64::from(y)) * CELL);
    cells.any(|cell| {
        let (mut on, mut through) = (0_usize, 0_usize);
        for arc in arcs {
            let off = cell - arc.center();
            let beyond = arc.range - off.norm();
            // Most arcs of the window are nowhere near.
            if beyond < -CELL || !arc.beam_holds(direction(off)) {
                continue;
            }
            if beyond > 2.0 * CELL + AGREEING {
                through += 1;
            } else if beyond <= CELL {
                on += 1;
            }
        }
        on >= POINT_VOTES && on > through
    })
}

impl Rival for Tbf {
    fn take(&mut self, scan: &Scan) -> Vec<Found> {
        let mut found = Vec::new();
        let arcs: Vec<Arc> = self.window.arcs().chain(&scan.arcs).copied().collect();
        for arc in &scan.arcs {
            let crossings: Vec<Crossing> = crossings(arc, self.window.arcs()).collect();
            let voters = voters(&crossings);
            let place = mean(voters.iter().map(|crossing| crossing.place));
            if voters.len() >= LINE_VOTES {
                self.places.push((place, *arc));
            }
            if voters.len() >= POINT_VOTES && is_confirmed(place, &arcs) {
                let mut used: Vec<Arc> = voters.iter().map(|crossing| crossing.arc).collect();
                used.push(*arc);
                found.push(Found {
                    shape: Shape::Point(Point::without_covariance(place)),
                    arcs: used,
                });
            }
        }
        self.window.push(scan);
        found
    }

    fn finish(&mut self) -> Vec<Found> {
        hough::lines(&std::mem::take(&mut self.places), self.longest_gap)
    }
}
