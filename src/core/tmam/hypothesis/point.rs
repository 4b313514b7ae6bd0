//! The point that explains readings best.

use std::cell::Cell;

use nalgebra::{Matrix2, RowVector2};

use super::minimum::{Bearings, PLACES, least};
use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::arc::{Arc, BEAM_SLACK};
use crate::core::tmam::gauss_newton::{Advance, Observation, chi2, iterate};
use crate::core::tmam::residual::point_range;

/// Newton steps along a bearing; the range is known well from the start.
const STEPS: u32 = 3;

/// The same while the bearing is only looked for.
const COARSE_STEPS: u32 = 2;

/// Steps of (10) from the point that the sums lead to.
const REFINEMENTS: u32 = 10;

/// A gain in chi2 below this, relative, is the end of them.
const GAIN: f64 = 1e-10;

/// Ranges below this weigh as if they were so long, metres.
const SHORTEST: f64 = 1e-3;

/// The least chi2 of a point that lies in all beams; infinite where there is none.
pub fn least_chi2(arcs: &[Arc]) -> f64 {
    let Some(middle) = arcs.get(arcs.len() / 2) else {
        return f64::INFINITY;
    };
    let moments = Moments::about(middle.center(), arcs);
    let edges = edges(arcs);
    let held = |point: Vec2| {
        arcs.iter().zip(&edges).all(|(arc, (axis, cosine))| {
            let towards = point - arc.center();
            axis.dot(&towards) >= cosine * towards.norm()
        })
    };
    let point_at = |along: Vec2| {
        let (way, chi2) = moments.best_on_ray(along, middle.range);
        (middle.center() + along * way, chi2)
    };
    let half = middle.beam_width / 2.0;
    let bearings = Bearings {
        axis: middle.world_from_sensor.yaw,
        low: -half,
        high: half,
    };
    let least_held = Cell::new(f64::INFINITY);
    let coarse = |all: &[Vec2; PLACES]| {
        let (ways, mut values) = moments.best_on_rays(all, middle.range);
        let points = || (all.iter().zip(ways)).map(|(along, way)| middle.center() + along * way);
        // The best one that the beams hold: which of the others they hold does not matter.
        while let Some((value, point)) =
            (values.iter_mut().zip(points())).min_by(|(a, _), (b, _)| a.total_cmp(b))
            && value.is_finite()
        {
            if held(point) {
                least_held.set(*value);
                break;
            }
            *value = f64::INFINITY;
        }
        values
    };
    let fine = |along| {
        let (point, chi2) = point_at(along);
        // What is no less than a point that the beams hold need not be looked for in them.
        if chi2 >= least_held.get() {
            return chi2;
        }
        if !held(point) {
            return f64::INFINITY;
        }
        least_held.set(chi2);
        chi2
    };
    let (along, value) = least(&bearings, coarse, |_| None, fine);
    if value.is_infinite() {
        return f64::INFINITY;
    }
    to_the_bottom(arcs, point_at(along).0, held)
}

/// Axis of each beam and cosine of half its width.
fn edges(arcs: &[Arc]) -> Vec<(Vec2, f64)> {
    let cosine = |arc: &Arc| libm::cos(arc.beam_width / 2.0 + BEAM_SLACK);
    // Arcs of one sonar have one width.
    let known = arcs.first().map(|arc| (arc.beam_width, cosine(arc)));
    arcs.iter()
        .map(|arc| {
            let known = known.filter(|(width, _)| *width == arc.beam_width);
            let cosine = known.map_or_else(|| cosine(arc), |(_, cosine)| cosine);
            (unit(arc.world_from_sensor.yaw), cosine)
        })
        .collect()
}

/// The sum of squared residuals, each divided by its variance, at the bottom of the valley that a
/// point lies in, as far as the beams go. The sums over the readings lead to a place near it: far off
/// where no point fits.
fn to_the_bottom(arcs: &[Arc], start: Vec2, held: impl Fn(Vec2) -> bool) -> f64 {
    let mut least = chi2(&PointRange, start, arcs);
    // Where the readings determine nothing more, the least so far is what there is.
    let _ = iterate(&PointRange, arcs, start, REFINEMENTS, |point, step| {
        // Shorter where the whole step leads out of the beams or up again.
        let better = [1.0, 0.25, 0.0625]
            .map(|share| point + step * share)
            .into_iter()
            .map(|to| (to, chi2(&PointRange, to, arcs)))
            .find(|(to, chi2)| *chi2 < least && held(*to));
        let Some((to, chi2)) = better else {
            return Advance::Stay;
        };
        let gain = least - chi2;
        least = chi2;
        if gain < GAIN * (1.0 + least) {
            Advance::Last(to)
        } else {
            Advance::To(to)
        }
    });
    least
}

/// The range to a point over its coordinates.
struct PointRange;

impl Observation for PointRange {
    fn predict(&self, point: Vec2, arc: &Arc) -> Option<(f64, RowVector2<f64>)> {
        point_range(point, arc.center())
    }
}

/// Sums over the readings from which chi2 of any point follows at once.
///
/// With `delta_i` the sensor's place from the origin and `a_i = r_i^2 - |delta_i|^2`, a point at the
/// way `rho` along `u` leaves `(a_i - rho^2 + 2 rho u . delta_i) / 2 r_i` of a reading: the residual,
/// but for a factor that is 1 where the two ranges agree.
struct Moments {
    weight: f64,
    a: f64,
    aa: f64,
    delta: Vec2,
    a_delta: Vec2,
    delta_delta: Matrix2<f64>,
}

impl Moments {
    fn about(origin: Vec2, arcs: &[Arc]) -> Self {
        let mut sums = Self {
            weight: 0.0,
            a: 0.0,
            aa: 0.0,
            delta: Vec2::zeros(),
            a_delta: Vec2::zeros(),
            delta_delta: Matrix2::zeros(),
        };
        for arc in arcs {
            let delta = arc.center() - origin;
            let twice = 2.0 * arc.range.max(SHORTEST);
            let weight = 1.0 / (twice * twice * arc.variance);
            let a = arc.range * arc.range - delta.norm_squared();
            sums.weight += weight;
            sums.a += weight * a;
            sums.aa += weight * a * a;
            sums.delta += delta * weight;
            sums.a_delta += delta * (weight * a);
            sums.delta_delta += delta * delta.transpose() * weight;
        }
        sums
    }

    /// The best way along a ray from the origin, metres, and what chi2 is there.
    fn best_on_ray(&self, along: Vec2, start: f64) -> (f64, f64) {
        let ray = self.projected(along);
        let mut way = start;
        for _ in 0..STEPS {
            let (next, is_valley) = self.step(way, ray);
            if !is_valley {
                break;
            }
            way = next;
        }
        (way, self.chi2(way, ray))
    }

    /// The same along many rays, roughly, without a branch.
    fn best_on_rays(&self, all: &[Vec2; PLACES], start: f64) -> ([f64; PLACES], [f64; PLACES]) {
        let (mut ways, mut values) = ([start; PLACES], [0.0; PLACES]);
        for ((along, way), value) in all.iter().zip(&mut ways).zip(&mut values) {
            let ray = self.projected(*along);
            let mut is_in_valley = true;
            for _ in 0..COARSE_STEPS {
                let (next, is_valley) = self.step(*way, ray);
                is_in_valley &= is_valley;
                *way = if is_in_valley { next } else { *way };
            }
            *value = self.chi2(*way, ray);
        }
        (ways, values)
    }

    /// What `delta`, `a_delta` and `delta_delta` are along a ray.
    fn projected(&self, along: Vec2) -> [f64; 3] {
        let dd = along.dot(&(self.delta_delta * along));
        [along.dot(&self.delta), along.dot(&self.a_delta), dd]
    }

    /// Where Newton's method leads from a way along a ray, metres, and whether chi2, a quartic in the way, is
    /// curved upwards there.
    fn step(&self, way: f64, [d, ad, dd]: [f64; 3]) -> (f64, bool) {
        let (w, a) = (self.weight, self.a);
        let slope = 4.0 * (((w * way - 3.0 * d) * way + 2.0 * dd - a) * way + ad);
        let curvature = 4.0 * (3.0 * w * way * way - 6.0 * d * way + 2.0 * dd - a);
        ((way - slope / curvature).max(0.0), curvature > 0.0)
    }

    fn chi2(&self, way: f64, [d, ad, dd]: [f64; 3]) -> f64 {
        let square = way * way;
        let chi2 =
            self.aa + square * (self.weight * square + 4.0 * dd - 2.0 * self.a) + 4.0 * way * ad
                - 4.0 * square * way * d;
        chi2.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::tmam::fit::testing::arc;

    #[test]
    fn where_no_point_fits_chi2_is_still_the_least_there_is() {
        // Readings of a point, the middle one too long by far more than its noise.
        let corner = Vec2::new(0.3, 1.5);
        for off in [0.02, 0.1, 0.3, -0.1] {
            let arcs: Vec<Arc> = (0..5)
                .map(|k| {
                    let sensor = Vec2::new(0.12 * f64::from(k), 0.0);
                    let range = (corner - sensor).norm() + if k == 2 { off } else { 0.0 };
                    arc(k, sensor, 1.57, range)
                })
                .collect();
            let found = least_chi2(&arcs);
            let held = |p: &Vec2| {
                arcs.iter()
                    .all(|arc| arc.beam_holds(crate::core::geometry::direction(p - arc.center())))
            };
            let grid = (-300..300).flat_map(|x| (-300..300).map(move |y| (x, y)));
            let least = grid
                .map(|(x, y)| corner + Vec2::new(f64::from(x), f64::from(y)) * 0.001)
                .filter(held)
                .map(|p| chi2(&PointRange, p, &arcs))
                .fold(f64::INFINITY, f64::min);
            assert!(
                found <= least && found > 0.98 * least,
                "{off}: {found} {least}"
            );
        }
    }
}
