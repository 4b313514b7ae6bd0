//! A wall of the map: where it ends, and whether it explains a reading.

use std::f64::consts::FRAC_PI_2;

use super::{Fit, SIGMAS};
use crate::core::geometry::{Vec2, unit, wrap_angle};
use crate::core::ties;
use crate::core::tmam::arc::Arc;
use crate::core::tmam::feature::{Point, Segment};

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
pub struct Wall {
    /// The map feature.
    pub id: u32,
    segment: Segment,
    normal: Vec2,
    along: Vec2,
    low: f64,
    high: f64,
    /// Standard deviation of the two ends.
    blur: f64,
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
            blur: blur_low.max(blur_high),
        }
    }

    /// Where the wall would have echoed the reading, if it did within the noise.
    pub fn explains(&self, arc: &Arc) -> Option<Place> {
        let (fit, bearing) = self.fit(arc);
        let Fit { misfit, variance } = fit;
        if misfit * misfit > SIGMAS * SIGMAS * variance
            || !arc.beam_nearly_holds(bearing, ties::ANGLE)
        {
            return None;
        }
        let way = arc.center().dot(&self.along);
        let slack = SIGMAS * self.blur;
        // Where no corner ends the wall, its outermost readings do: they are on it.
        let within = |low, high| {
            ties::at_least(way, low, ties::LENGTH) && ties::at_most(way, high, ties::LENGTH)
        };
        if within(self.low + slack, self.high - slack) {
            Some(Place::On)
        } else if within(self.low - slack, self.high + slack) {
            Some(Place::AtEnd)
        } else {
            None
        }
    }

    /// How far the reading is from the wall's line, and the bearing of its perpendicular.
    pub fn fit(&self, arc: &Arc) -> (Fit, f64) {
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
