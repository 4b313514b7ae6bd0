//! The second opinion on a triple: which of a line and a point explains its readings within their
//! noise.
//!
//! The paper compares two angles; it does not ask whether the readings are precise enough to tell.
//! Here a line and a point are fitted to the three readings, inside the beams, and the weighted
//! squares of what remains (one degree of freedom each) say what the readings themselves support.

use nalgebra::Matrix2;

use super::arc::{Arc, BEAM_SLACK};
use super::triple::Label;
use crate::geometry::{Vec2, unit};

/// Bearings at which a minimum is looked for before it is refined. Both local minima, left and
/// right of the base line, are seen this way where the beams hold both.
const SAMPLES: u32 = 24;

/// Golden sections of the bracket around the best sample: to a millionth of the beam.
const REFINEMENTS: u32 = 24;

/// What the readings of a triple support.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// Only a line explains them.
    Line,
    /// Only a point does.
    Point,
    /// Both do: the base line is too short for the noise, or the target is seen end-on.
    Ambiguous,
    /// Neither does: they come from different targets.
    Neither,
}

/// The second opinion on a triple.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opinion {
    /// Weighted squares that remain of the best line inside the beams; infinite where the beams
    /// have no bearing in common.
    pub chi2_line: f64,
    /// The same of the best point.
    pub chi2_point: f64,
    /// What follows from the two.
    pub support: Support,
}

impl Opinion {
    /// The opinion on three neighbouring arcs; a model explains them when its chi2 is below `gate`.
    pub fn of(arcs: [&Arc; 3], gate: f64) -> Self {
        let (chi2_line, chi2_point) = (chi2_line(arcs), chi2_point(arcs));
        let support = match (chi2_line < gate, chi2_point < gate) {
            (true, false) => Support::Line,
            (false, true) => Support::Point,
            (true, true) => Support::Ambiguous,
            (false, false) => Support::Neither,
        };
        Self {
            chi2_line,
            chi2_point,
            support,
        }
    }

    /// Whether the readings contradict a label.
    pub fn contradicts(&self, label: Label) -> bool {
        match label {
            Label::Contact => matches!(self.support, Support::Point | Support::Neither),
            Label::Intersection => matches!(self.support, Support::Line | Support::Neither),
            Label::Unidentified(_) => false,
        }
    }
}

impl Support {
    /// The word in files: `line`, `point`, `ambiguous` or `neither`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Point => "point",
            Self::Ambiguous => "ambiguous",
            Self::Neither => "neither",
        }
    }
}

/// The least chi2 of a line whose normal lies in all three beams.
fn chi2_line(arcs: [&Arc; 3]) -> f64 {
    // For a given normal n the best offset of the line is the weighted mean of r_i + s_i . n, and
    // what remains is a quadratic form in n.
    let weights = arcs.map(|arc| 1.0 / arc.variance);
    let total: f64 = weights.iter().sum();
    let weighted = || arcs.iter().zip(weights);
    let mean_range = weighted().map(|(arc, w)| arc.range * w).sum::<f64>() / total;
    let mean_center =
        weighted().fold(Vec2::zeros(), |sum, (arc, w)| sum + arc.center() * w) / total;
    let (mut constant, mut linear, mut quadratic) = (0.0, Vec2::zeros(), Matrix2::zeros());
    for (arc, w) in weighted() {
        let (r, s) = (arc.range - mean_range, arc.center() - mean_center);
        constant += w * r * r;
        linear += s * (w * r);
        quadratic += s * s.transpose() * w;
    }
    let beams = Beams::of(arcs);
    least(beams.middle_half, |offset| {
        let normal = beams.direction(offset);
        if !beams.hold([normal; 3]) {
            return f64::INFINITY;
        }
        (constant + 2.0 * linear.dot(&normal) + normal.dot(&(quadratic * normal))).max(0.0)
    })
}

/// The least chi2 of a point that lies in all three beams.
fn chi2_point(arcs: [&Arc; 3]) -> f64 {
    let [_, middle, _] = arcs;
    let beams = Beams::of(arcs);
    least(beams.middle_half, |offset| {
        let along = beams.direction(offset);
        let point = best_point(arcs, middle.center(), along, middle.range);
        let towards = arcs.map(|arc| point - arc.center());
        if !beams.hold(towards) {
            return f64::INFINITY;
        }
        towards
            .iter()
            .zip(arcs)
            .map(|(towards, arc)| {
                let residual = towards.norm() - arc.range;
                residual * residual / arc.variance
            })
            .sum()
    })
}

/// The point on a ray that fits the three ranges best: Gauss-Newton steps along the ray.
fn best_point(arcs: [&Arc; 3], origin: Vec2, along: Vec2, start: f64) -> Vec2 {
    let mut way = start;
    for _ in 0..3 {
        let point = origin + along * way;
        let (mut information, mut gradient) = (0.0, 0.0);
        for arc in arcs {
            let from = point - arc.center();
            let range = from.norm();
            let slope = if range > 0.0 {
                from.dot(&along) / range
            } else {
                1.0
            };
            information += slope * slope / arc.variance;
            gradient += slope * (arc.range - range) / arc.variance;
        }
        if information <= 0.0 {
            break;
        }
        way = (way + gradient / information).max(0.0);
    }
    origin + along * way
}

/// The beams of a triple, made ready for many questions.
struct Beams {
    middle_yaw: f64,
    middle_half: f64,
    /// Of each beam: its axis, and the cosine of half its width.
    edges: [(Vec2, f64); 3],
}

impl Beams {
    fn of(arcs: [&Arc; 3]) -> Self {
        let [_, middle, _] = arcs;
        Self {
            middle_yaw: middle.world_from_sensor.yaw,
            middle_half: middle.beam_width / 2.0,
            edges: arcs.map(|arc| {
                let half = arc.beam_width / 2.0 + BEAM_SLACK;
                (unit(arc.world_from_sensor.yaw), libm::cos(half))
            }),
        }
    }

    /// The direction at an angle from the axis of the middle beam.
    fn direction(&self, offset: f64) -> Vec2 {
        unit(self.middle_yaw + offset)
    }

    /// Whether each beam holds the direction that is asked of it.
    fn hold(&self, towards: [Vec2; 3]) -> bool {
        self.edges
            .iter()
            .zip(towards)
            .all(|((axis, cosine), towards)| axis.dot(&towards) >= cosine * towards.norm())
    }
}

/// The least value of a function on [-half, half]: the best of evenly spaced samples, refined by
/// golden sections between its neighbours.
fn least(half: f64, function: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let step = 2.0 * half / f64::from(SAMPLES);
    let at = |k: u32| -half + step * f64::from(k);
    let best = (0..=SAMPLES)
        .map(|k| (function(at(k)), k))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((value, k)) = best.filter(|(value, _)| value.is_finite()) else {
        return f64::INFINITY;
    };
    let (mut low, mut high) = ((at(k) - step).max(-half), (at(k) + step).min(half));
    let mut left = high - GOLDEN * (high - low);
    let mut right = low + GOLDEN * (high - low);
    let (mut at_left, mut at_right) = (function(left), function(right));
    let mut least = value.min(at_left).min(at_right);
    for _ in 0..REFINEMENTS {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = function(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = function(right);
        }
        least = least.min(at_left).min(at_right);
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::SonarId;
    use crate::geometry::Pose2;
    use crate::tmam::arc::ArcId;
    use proptest::prelude::*;

    const GATE: f64 = 6.63;

    /// Three arcs of a sensor that looks along `yaw`, a step of 12 cm apart along x.
    fn triple(yaw: f64, sigma: f64, range: impl Fn(Vec2) -> f64) -> [Arc; 3] {
        [0.0, 0.12, 0.24].map(|x| {
            let sensor = Vec2::new(x, 0.0);
            Arc {
                id: ArcId {
                    frame: 0,
                    sonar: SonarId(0),
                },
                stamp_ns: 0,
                world_from_sensor: Pose2::new(sensor.x, sensor.y, yaw),
                range: range(sensor),
                beam_width: 0.5,
                variance: sigma * sigma,
            }
        })
    }

    fn opinion(arcs: &[Arc; 3]) -> Opinion {
        let [a, b, c] = arcs;
        Opinion::of([a, b, c], GATE)
    }

    proptest! {
        #[test]
        fn exact_readings_support_what_gave_them(yaw in 1.1..2.0f64, tilt in -0.1..0.1f64, rho in 1.5..4.0f64) {
            let normal = unit(yaw + tilt);
            let wall = opinion(&triple(yaw, 1e-5, |s| rho - normal.dot(&s)));
            prop_assert!(wall.chi2_line < 1e-3, "{wall:?}");
            prop_assert_eq!(wall.support, Support::Line);
            let corner = Vec2::new(0.12, 0.0) + unit(yaw + tilt) * rho;
            let point = opinion(&triple(yaw, 1e-5, |s| (corner - s).norm()));
            prop_assert!(point.chi2_point < 1e-3, "{point:?}");
            prop_assert_eq!(point.support, Support::Point);
        }

        #[test]
        fn coarse_readings_decide_nothing(yaw in 1.3..1.8f64, rho in 1.0..3.0f64) {
            let normal = unit(yaw);
            let wall = opinion(&triple(yaw, 0.1, |s| rho - normal.dot(&s)));
            prop_assert_eq!(wall.support, Support::Ambiguous);
        }
    }

    #[test]
    fn readings_of_different_targets_support_nothing() {
        let found = opinion(&triple(
            1.57,
            0.003,
            |s| if s.x == 0.12 { 2.5 } else { 2.0 },
        ));
        assert_eq!(found.support, Support::Neither);
        assert!(found.contradicts(Label::Contact) && found.contradicts(Label::Intersection));
    }

    #[test]
    fn seen_end_on_a_wall_and_a_point_look_alike() {
        let found = opinion(&triple(0.0, 0.003, |s| 3.0 - s.x));
        assert_eq!(found.support, Support::Ambiguous, "{found:?}");
        assert!(!found.contradicts(Label::Contact));
    }

    #[test]
    fn beams_without_a_common_bearing_have_no_line() {
        let mut arcs = triple(1.57, 0.003, |_| 2.0);
        arcs[2].world_from_sensor.yaw = 0.2;
        assert_eq!(opinion(&arcs).chi2_line, f64::INFINITY);
    }

    #[test]
    fn chi2_has_one_degree_of_freedom() {
        // Over many noisy triples of a wall, the mean of chi2 is one.
        let mut rng = crate::tmam::fit::testing::Gauss::new(5);
        let (sigma, n) = (0.003, 2000);
        let sum: f64 = (0..n)
            .map(|_| {
                let mut arcs = triple(1.6, sigma, |_| 2.0);
                for arc in &mut arcs {
                    arc.range += sigma * rng.sample();
                }
                opinion(&arcs).chi2_line
            })
            .sum();
        let mean = sum / f64::from(n);
        assert!((0.85..1.15).contains(&mean), "{mean}");
    }
}
