//! Crossings of an arc with others in a sliding window of scans.

use std::collections::VecDeque;

use super::rival::Scan;
use crate::core::geometry::{Vec2, angle_between};
use crate::core::tmam::arc::Arc;
use crate::core::tmam::pair::Points;

/// Arcs that cross at a smaller angle nearly touch, and noise moves their crossing far: before a wall that the
/// robot drives at straight on, all arcs do, radians.
const SMALLEST_ANGLE: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// The last scans.
#[derive(Debug)]
pub struct Window {
    scans: VecDeque<Vec<Arc>>,
    longest: usize,
}

impl Window {
    /// Of at most so many scans.
    pub fn new(longest: usize) -> Self {
        Self {
            scans: VecDeque::new(),
            longest,
        }
    }

    /// Takes a scan; the oldest one goes where there are more than the window holds.
    pub fn push(&mut self, scan: &Scan) {
        self.scans.push_back(scan.arcs.clone());
        if self.scans.len() > self.longest {
            self.scans.pop_front();
        }
    }

    pub fn is_full(&self) -> bool {
        self.scans.len() == self.longest
    }

    pub fn is_empty(&self) -> bool {
        self.scans.is_empty()
    }

    /// The scan in its middle.
    pub fn middle(&self) -> &[Arc] {
        let middle = self.scans.get(self.scans.len() / 2);
        middle.map_or(&[], Vec::as_slice)
    }

    /// Every arc in it, the oldest scan first.
    pub fn arcs(&self) -> impl Iterator<Item = &Arc> {
        self.scans.iter().flatten()
    }

    /// Forgets the oldest scan.
    pub fn shorten(&mut self) {
        self.scans.pop_front();
    }
}

/// Where an arc crosses another one.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    pub place: Vec2,
    /// From the arc's own sensor, radians in the world.
    pub bearing: f64,
    /// At which the two arcs cross, radians.
    pub angle: f64,
    /// The other one.
    pub arc: Arc,
}

/// Where an arc crosses others, in both beams.
pub fn crossings<'a>(
    arc: &'a Arc,
    others: impl Iterator<Item = &'a Arc>,
) -> impl Iterator<Item = Crossing> {
    let all = others.flat_map(|other| {
        let points = Points::of(arc, other).intersection.into_iter().flatten();
        points.map(|point| Crossing {
            place: point.on_a,
            bearing: point.bearing_a,
            angle: angle_between(point.bearing_a, point.bearing_b),
            arc: *other,
        })
    });
    all.filter(|crossing| crossing.angle >= SMALLEST_ANGLE)
}

/// The mean of places.
pub fn mean(places: impl Iterator<Item = Vec2>) -> Vec2 {
    let (sum, count) = places.fold((Vec2::zeros(), 0.0), |(sum, count), place| {
        (sum + place, count + 1.0)
    });
    sum / f64::max(count, 1.0)
}
