//! A wall of the map: where it ends, and whether it explains a reading.

use crate::core::geometry::{Vec2, unit};
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Point, Segment};
use crate::core::tmam::residual::RangeResidual;

/// Standard deviations within which a feature explains a reading, and within which a place counts
/// as the end of a wall.
pub const SIGMAS: f64 = 3.0;

/// A point this near to a wall is its end, or stands in it, metres; beyond what the covariances say.
const CORNER: f64 = 0.02;

/// How far from the end of a wall, as it was seen, a point on it is taken for its end: metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Beyond the end.
    pub beyond: f64,
    /// Before it; and what the point's covariance says.
    pub before: f64,
    /// Off the wall's line; and what the point's covariance says.
    pub off: f64,
    /// This near to its end the foot of the perpendicular does not tell a wall from its corner, metres.
    pub margin: f64,
}

impl Reach {
    /// Of walls that end at their corners: `max_wall_gap` metres beyond what was seen of them.
    pub fn of(max_wall_gap: f64) -> Self {
        Self {
            beyond: max_wall_gap,
            before: CORNER,
            off: CORNER,
            margin: 0.0,
        }
    }
}

/// A wall from end to end, in coordinates along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// The map feature.
    pub id: u32,
    segment: Segment,
    normal: Vec2,
    along: Vec2,
    low: f64,
    high: f64,
    /// This near to an end it does not tell whether the wall or its corner echoed.
    slack: f64,
}

/// Where the perpendicular from a sensor meets a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Between its ends.
    On,
    /// Within three standard deviations of an end.
    AtEnd,
}

impl Wall {
    /// From a feature of the map and the points that may end it.
    pub fn new(id: u32, segment: Segment, points: &[(u32, Point)], reach: &Reach) -> Self {
        let (normal, along) = (unit(segment.theta), segment.along());
        let middle = segment.mid.dot(&along);
        let [low, high] = segment.extent();
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
            let near = on_line.iter().filter(|(way, blur)| {
                let beyond = sign * (way - end);
                ties::above(sign * way, sign * middle, ties::LENGTH)
                    && beyond > -(reach.before + SIGMAS * blur)
                    && beyond < reach.beyond
            });
            let near = near.map(|place| ((place.0 - end).abs(), *place));
            ties::first_least(near, |_, _| ties::LENGTH).map(|(_, place)| place)
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
            slack: (SIGMAS * blur_low.max(blur_high)).max(reach.margin),
        }
    }

    /// Where the wall would have echoed the reading, if it did within the noise, and how far the
    /// reading is from its line.
    pub fn explains(&self, arc: &Arc) -> Option<(Place, RangeResidual)> {
        let way = arc.center().dot(&self.along);
        let slack = self.slack;
        // Where no corner ends the wall, its outermost readings do: they are on it.
        let within = |low, high| {
            ties::at_least(way, low, ties::LENGTH) && ties::at_most(way, high, ties::LENGTH)
        };
        let place = if within(self.low + slack, self.high - slack) {
            Place::On
        } else if within(self.low - slack, self.high + slack) {
            Place::AtEnd
        } else {
            return None;
        };
        // Most walls of a large map are out of the question, without a sine: (6), and its variance.
        let off = arc.range - (self.segment.rho - arc.center().dot(&self.normal)).abs();
        let by_line = Vec2::new(1.0, -way);
        let variance = by_line.dot(&(self.segment.covariance * by_line)).max(0.0);
        if off * off > 1.01 * SIGMAS * SIGMAS * (arc.variance + variance) {
            return None;
        }
        let residual = RangeResidual::of_line(&self.segment, arc);
        let explained = residual.chi2() <= SIGMAS * SIGMAS && residual.is_in_beam(arc);
        explained.then_some((place, residual))
    }
}
