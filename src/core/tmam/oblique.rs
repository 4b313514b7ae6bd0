//! A rough wall seen at an angle: readings that fit neither the foot of a perpendicular nor a point, but
//! a wall through the near edge of the beam.
//!
//! A rough wall echoes from its nearest place in the beam. Where the foot of the perpendicular lies
//! beside the beam, that place is on the edge ray next to it: at yaw + half or yaw - half, half being half
//! the beam's width. With `n` the normal of the wall at the angle theta, a sensor at `s` measures along
//! the edge ray at the angle `e`
//!
//! ```text
//! r = (rho - n . s) / cos(e - theta)
//! ```
//!
//! which grows or falls faster while the sensor passes than any range to a foot in the beam.

use nalgebra::{RowVector2, Vector2};

use super::arc::Arc;
use super::feature::Segment;
use super::gauss_newton::{Advance, Observation, chi2, covariance, iterate};
use super::hypothesis::{Gate, HypothesisTest, Support};
use crate::core::geometry::{Vec2, unit, wrap_angle};

/// Fewer readings than this lie on a line by chance.
const FEWEST: usize = 4;
/// No more than so many are looked at: walls end.
const MOST: usize = 8;
/// A wall seen at a larger angle than this echoes next to nothing, radians.
pub const STEEPEST: f64 = 75.0 * std::f64::consts::PI / 180.0;
/// Steps after which the fit ends in any case; where the sensor does not turn, the first one is right.
const STEPS: u32 = 5;

/// A rough wall that explains readings at an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObliqueWall {
    /// How many readings it explains; two more than there are degrees of freedom.
    pub readings: usize,
    /// Weighted squares that remain of them.
    pub chi2: f64,
    /// The angle between the edge ray and the wall's normal, radians.
    pub incidence: f64,
}

impl ObliqueWall {
    /// The wall that explains most of the newest of some neighbouring arcs, at least `least` of them;
    /// `None` where there is none, or where a line or a point does nearly as well.
    pub fn behind(arcs: &[Arc], least: usize, gate: &Gate, decisive: f64) -> Option<Self> {
        let most = arcs.len().min(MOST);
        let newest = (least.max(FEWEST)..=most).rev().filter_map(|count| {
            let newest = arcs.get(arcs.len() - count..)?;
            let wall = Self::of(newest).filter(|wall| wall.chi2 < gate.at(count - 2))?;
            Some((newest, wall))
        });
        newest
            .map(|(arcs, wall)| (HypothesisTest::of(arcs, gate), wall))
            .find(|(test, wall)| {
                let other = test.chi2_line.min(test.chi2_point);
                test.support == Support::Neither && other - wall.chi2 >= decisive
            })
            .map(|(_, wall)| wall)
    }

    /// The wall that fits best through one edge of the beams, its foot beside that.
    fn of(arcs: &[Arc]) -> Option<Self> {
        Some(EdgeRange::best(arcs)?.1)
    }
}

/// The wall that explains all of some arcs at an angle through the edge of a beam of the half width `half`,
/// which is off by the standard deviation `off`, both in radians; it reaches from echo to echo. The half width
/// turns it, and its covariance says so.
pub fn line_through_edge(arcs: &[Arc], half: f64, off: f64, gate: &Gate) -> Option<Segment> {
    let with = |half: f64| -> Vec<Arc> {
        let beam_width = 2.0 * half;
        let arcs = arcs.iter().copied();
        arcs.map(|arc| Arc { beam_width, ..arc }).collect()
    };
    let nominal = with(half);
    let (edge, wall) = EdgeRange::best(&nominal)?;
    if wall.chi2 >= gate.at(arcs.len().saturating_sub(2)) {
        return None;
    }
    let line = edge.line(&nominal)?;
    let turned = (edge.line(&with(half + off))? - edge.line(&with(half - off))?) / 2.0;
    let covariance = covariance(&edge, line, &nominal)? + turned * turned.transpose();
    let echoes = nominal.iter().map(|arc| arc.point_at(edge.bearing(arc)));
    let segment = Segment::of_line_about(edge.origin, line, covariance);
    Some(segment.reaching_over(echoes).canonical())
}

/// The range along an edge ray over the wall's (distance from an origin, theta).
#[derive(Debug, Clone, Copy)]
struct EdgeRange {
    /// 1 for the left edge, -1 for the right one.
    side: f64,
    origin: Vec2,
}

impl EdgeRange {
    fn bearing(&self, arc: &Arc) -> f64 {
        arc.world_from_sensor.yaw + self.side * arc.beam_width / 2.0
    }

    /// The edge through which a wall fits best, and that wall.
    fn best(arcs: &[Arc]) -> Option<(Self, ObliqueWall)> {
        let origin = arcs.get(arcs.len() / 2)?.center();
        let edges = [1.0, -1.0].map(|side| Self { side, origin });
        let walls = edges.into_iter();
        let walls = walls.filter_map(|edge| Some((edge, edge.fit(arcs)?)));
        walls.min_by(|(_, a), (_, b)| a.chi2.total_cmp(&b.chi2))
    }

    /// The line that fits best, wherever its foot is.
    fn line(&self, arcs: &[Arc]) -> Option<Vector2<f64>> {
        let start = self.through_echoes(arcs)?;
        let step = |wall, step| Advance::To(wall + step);
        Some(iterate(self, arcs, start, STEPS, step).ok()?.parameters)
    }

    fn fit(&self, arcs: &[Arc]) -> Option<ObliqueWall> {
        let wall = self.line(arcs)?;
        // The foot lies beyond the edge of every beam, but not out of sight.
        let beyond = |arc: &Arc| self.side * wrap_angle(wall.y - self.bearing(arc));
        let seen = |arc: &Arc| beyond(arc) > 0.0 && beyond(arc) < STEEPEST;
        if !arcs.iter().all(seen) {
            return None;
        }
        Some(ObliqueWall {
            readings: arcs.len(),
            chi2: chi2(self, wall, arcs),
            incidence: beyond(arcs.get(arcs.len() / 2)?),
        })
    }

    /// The line through the echoes, each at the end of its edge ray: where the rays are parallel this is
    /// the wall that fits best.
    fn through_echoes(&self, arcs: &[Arc]) -> Option<Vector2<f64>> {
        let bearing = self.bearing(arcs.get(arcs.len() / 2)?);
        let along = unit(bearing);
        let across = Vec2::new(-along.y, along.x);
        let mut sums = [0.0; 5];
        for arc in arcs {
            let echo = arc.center() + arc.range * unit(self.bearing(arc)) - self.origin;
            let (x, y) = (echo.dot(&across), echo.dot(&along));
            for (sum, term) in sums.iter_mut().zip([1.0, x, y, x * x, x * y]) {
                *sum += term / arc.variance;
            }
        }
        let [weight, x, y, xx, xy] = sums;
        let slope = (weight * xy - x * y) / (weight * xx - x * x);
        let range = (y - slope * x) / weight;
        let beyond = -libm::atan(slope);
        slope
            .is_finite()
            .then(|| Vector2::new(range * libm::cos(beyond), bearing + beyond))
    }
}

impl Observation for EdgeRange {
    fn predict(&self, wall: Vector2<f64>, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        let normal = unit(wall.y);
        let place = arc.center() - self.origin;
        let distance = wall.x - normal.dot(&place);
        let (sin, cos) = libm::sincos(self.bearing(arc) - wall.y);
        // The derivative of the distance by theta is (21).
        let turned = -normal.perp(&place);
        let by_theta = turned / cos - distance * sin / (cos * cos);
        (cos > 0.0).then(|| (distance / cos, RowVector2::new(1.0 / cos, by_theta)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};

    const GATE: f64 = 6.63;
    const DECISIVE: f64 = 13.0;
    /// Half the width of the test arcs' beams.
    const HALF: f64 = 0.25;

    /// Noisy arcs on the way along x of a sensor that looks along `yaw` and turns by `turn` a step.
    fn passing(count: u32, yaw: f64, turn: f64, range: impl Fn(Vec2, f64) -> f64) -> Vec<Arc> {
        let mut noise = Gauss::new(5);
        let at = |k: u32| {
            (
                Vec2::new(0.12 * f64::from(k), 0.0),
                yaw + turn * f64::from(k),
            )
        };
        let places = (0..count).map(at);
        let mut arcs = Vec::new();
        for ((sensor, yaw), k) in places.zip(0..) {
            let noise = SIGMA * noise.sample();
            arcs.push(arc(k, sensor, yaw, range(sensor, yaw) + noise));
        }
        arcs
    }

    /// The range along the edge on the side of the foot of a wall with its normal at `theta`.
    fn along_edge(theta: f64, rho: f64, sensor: Vec2, yaw: f64) -> f64 {
        let edge = yaw + HALF.copysign(wrap_angle(theta - yaw));
        (rho - unit(theta).dot(&sensor)) / libm::cos(edge - theta)
    }

    fn behind(arcs: &[Arc]) -> Option<ObliqueWall> {
        ObliqueWall::behind(arcs, 3, &Gate::new(GATE), DECISIVE)
    }

    proptest! {
        #[test]
        fn a_rough_wall_is_known_by_its_edge(
            yaw in 0.3..1.2f64, beyond in 0.35..0.9f64, turn in -0.01..0.01f64, side in any::<bool>()
        ) {
            let side = if side { 1.0 } else { -1.0 };
            let theta = yaw + side * (HALF + beyond);
            let arcs = passing(7, yaw, turn, |sensor, yaw| along_edge(theta, 4.0, sensor, yaw));
            // A line of ranges fits the left edge of one wall and the right edge of another: it need not be
            // this wall that is found, but one that is at least as likely.
            if let Some(found) = behind(&arcs) {
                let newest = &arcs[arcs.len() - found.readings..];
                let origin = newest[newest.len() / 2].center();
                let edge = EdgeRange { side, origin };
                let this = Vector2::new(4.0 - unit(theta).dot(&origin), theta);
                prop_assert!(found.chi2 < Gate::new(GATE).at(found.readings - 2));
                let likely = chi2(&edge, this, newest);
                prop_assert!(found.chi2 <= likely + 1e-3, "{found:?} {likely}");
            }
        }

        #[test]
        fn derivatives_equal_differences(theta in 0.8..1.6f64, rho in 1.0..4.0f64, x in -0.5..0.5f64) {
            let edge = EdgeRange { side: 1.0, origin: Vec2::new(0.1, 0.2) };
            let arc = arc(0, Vec2::new(x, 0.1), 0.5, 0.0);
            let at = |d: f64, t: f64| edge.predict(Vector2::new(rho + d, theta + t), &arc).unwrap();
            let h = 1e-6;
            let slopes = at(0.0, 0.0).1;
            let by = |up: f64, down: f64| (up - down) / (2.0 * h);
            prop_assert!((by(at(h, 0.0).0, at(-h, 0.0).0) - slopes.x).abs() < 1e-6);
            prop_assert!((by(at(0.0, h).0, at(0.0, -h).0) - slopes.y).abs() < 1e-4);
        }
    }

    #[test]
    fn it_is_found_ahead_and_at_the_side() {
        for (yaw, theta) in [
            (0.0, 0.7),
            (0.0, -0.9),
            (0.8, 1.6),
            (1.57, 1.0),
            (1.57, 2.2),
        ] {
            let rough = |sensor: Vec2, yaw: f64| along_edge(theta, 4.0, sensor, yaw);
            let found = behind(&passing(6, yaw, 0.0, rough));
            let beyond = wrap_angle(theta - yaw).abs() - HALF;
            let found = found.unwrap_or_else(|| panic!("nothing at {yaw} {theta}"));
            assert_eq!(found.readings, 6);
            assert!((found.incidence - beyond).abs() < 0.1, "{found:?} {beyond}");
        }
    }

    #[test]
    fn what_walls_and_points_explain_is_none() {
        let wall = |s: Vec2, _: f64| 2.0 - unit(1.5).dot(&s);
        let corner = |s: Vec2, _: f64| (Vec2::new(0.3, 2.0) - s).norm();
        let change = |s: Vec2, _: f64| if s.x < 0.3 { 2.0 } else { 2.6 };
        assert_eq!(behind(&passing(6, 1.5, 0.0, wall)), None);
        assert_eq!(behind(&passing(6, 1.57, 0.0, corner)), None);
        assert_eq!(behind(&passing(6, 1.57, 0.0, change)), None);
        // Three readings lie on a line by chance too often.
        let rough = |sensor: Vec2, yaw: f64| along_edge(1.6, 4.0, sensor, yaw);
        assert_eq!(behind(&passing(3, 0.8, 0.0, rough)), None);
        assert!(behind(&passing(4, 0.8, 0.0, rough)).is_some());
        assert_eq!(behind(&[]), None);
    }
}
