//! How far noise spreads the two angles of a triple: sigma propagated through (2) and (3).
//!
//! Where the spread of an angle is as large as the difference that the rule asks for, the base line
//! was too short to decide.

use super::arc::Arc;
use super::pair::{MIN_BASELINE, cos_contact, cos_intersection};

/// Predicted standard deviations of the two angles, radians; infinite where the angle has no
/// derivative (end-on, or no base line).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    theta_c: f64,
    theta_i: f64,
}

impl Spread {
    const WITHOUT_END: Self = Self {
        theta_c: f64::INFINITY,
        theta_i: f64::INFINITY,
    };

    /// Of three neighbouring arcs. The two sides of travel mirror each other, so they spread alike.
    pub fn of([before, middle, after]: [&Arc; 3]) -> Self {
        let ranges = [before.range, middle.range, after.range];
        let first = (middle.center() - before.center()).norm();
        let second = (after.center() - middle.center()).norm();
        if first < MIN_BASELINE || second < MIN_BASELINE {
            return Self::WITHOUT_END;
        }
        let variances = [before.variance, middle.variance, after.variance];
        let sigma = |gradient: [f64; 3]| {
            let terms = gradient.iter().zip(variances);
            let variance: f64 = terms
                .map(|(slope, variance)| slope * slope * variance)
                .sum();
            if variance.is_finite() {
                variance.sqrt()
            } else {
                f64::INFINITY
            }
        };
        Self {
            theta_c: sigma(slopes_of_theta_c(ranges, first, second)),
            theta_i: sigma(slopes_of_theta_i(ranges, first, second)),
        }
    }

    /// Of theta_c, where it has a derivative.
    pub fn theta_c(&self) -> Option<f64> {
        Some(self.theta_c).filter(|sigma| sigma.is_finite())
    }

    /// Of theta_i, where it has one.
    pub fn theta_i(&self) -> Option<f64> {
        Some(self.theta_i).filter(|sigma| sigma.is_finite())
    }
}

/// Derivatives of the angle between the contact points by the three ranges.
fn slopes_of_theta_c([r1, r2, r3]: [f64; 3], first: f64, second: f64) -> [f64; 3] {
    // From (2): d phi / d r_a = -1 / (d sin phi), and the opposite by r_b.
    let by = |a: f64, b: f64, d: f64| 1.0 / (d * sine_of(cos_contact(a, b, d)));
    let (one, two) = (by(r1, r2, first), by(r2, r3, second));
    [-one, one + two, -two]
}

/// Derivatives of the angle between the intersection points by the three ranges.
fn slopes_of_theta_i([r1, r2, r3]: [f64; 3], first: f64, second: f64) -> [f64; 3] {
    // From (3), both pairs seen from the middle arc: its own range, then the other's.
    let by_own = |other: f64, d: f64| {
        let cosine = cos_intersection(r2, other, d);
        (1.0 / d - cosine / r2) / sine_of(cosine)
    };
    let by_other = |other: f64, d: f64| other / (d * r2 * sine_of(cos_intersection(r2, other, d)));
    [
        -by_other(r1, first),
        by_own(r1, first) + by_own(r3, second),
        -by_other(r3, second),
    ]
}

/// The sine that goes with a cosine; NaN beyond 1, where there is no point.
fn sine_of(cosine: f64) -> f64 {
    (1.0 - cosine * cosine).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::{Vec2, unit};
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};
    use crate::core::tmam::pair::Points;
    use crate::core::tmam::triple::Angles;
    use proptest::prelude::*;

    /// A circle of radius `radius` seen on the way along x, so that both angles differ from zero.
    fn triple(off: f64, range: f64, radius: f64) -> [Arc; 3] {
        let center = Vec2::new(0.12, 0.0) + unit(off) * (range + radius);
        [0.0, 0.12, 0.24].map(|x| {
            let sensor = Vec2::new(x, 0.0);
            let mut arc = arc(0, sensor, off, (center - sensor).norm() - radius);
            arc.beam_width = 1.5;
            arc
        })
    }

    fn angles(arcs: &[Arc; 3]) -> (f64, f64) {
        let [a, b, c] = arcs;
        let found = Angles::between(&[Points::of(a, b), Points::of(b, c)], 1.5);
        (found.theta_c, found.theta_i)
    }

    proptest! {
        #[test]
        fn slopes_equal_differences(off in 0.8..2.3f64, range in 0.8..4.0f64, radius in 0.2..0.6f64) {
            let arcs = triple(off, range, radius);
            let ranges = [arcs[0].range, arcs[1].range, arcs[2].range];
            let c = slopes_of_theta_c(ranges, 0.12, 0.12);
            let i = slopes_of_theta_i(ranges, 0.12, 0.12);
            let h = 1e-7;
            for k in 0..3 {
                let moved = |by: f64| {
                    let mut arcs = arcs;
                    arcs[k].range += by;
                    angles(&arcs)
                };
                let (up, down) = (moved(h), moved(-h));
                // The angle is the magnitude of what the slopes are of.
                let by_c = (up.0 - down.0) / (2.0 * h);
                let by_i = (up.1 - down.1) / (2.0 * h);
                prop_assert!((by_c.abs() - c[k].abs()).abs() < 1e-4 * (1.0 + c[k].abs()), "{by_c} {}", c[k]);
                prop_assert!((by_i.abs() - i[k].abs()).abs() < 1e-4 * (1.0 + i[k].abs()), "{by_i} {}", i[k]);
            }
        }
    }

    #[test]
    fn the_prediction_is_the_spread_of_many_noisy_triples() {
        let arcs = triple(1.4, 2.0, 0.5);
        let sigma = SIGMA / 10.0;
        let with_sigma = arcs.map(|arc| Arc {
            variance: sigma * sigma,
            ..arc
        });
        let [a, b, c] = &with_sigma;
        let predicted = Spread::of([a, b, c]);
        let mut rng = Gauss::new(3);
        let n = 4000;
        let (mean_c, mean_i) = angles(&with_sigma);
        let (mut sum_c, mut sum_i) = (0.0, 0.0);
        for _ in 0..n {
            let noisy = with_sigma.map(|arc| Arc {
                range: arc.range + sigma * rng.sample(),
                ..arc
            });
            let (theta_c, theta_i) = angles(&noisy);
            sum_c += (theta_c - mean_c) * (theta_c - mean_c);
            sum_i += (theta_i - mean_i) * (theta_i - mean_i);
        }
        for (sum, predicted) in [(sum_c, predicted.theta_c), (sum_i, predicted.theta_i)] {
            let found = (sum / f64::from(n)).sqrt();
            assert!(
                (found / predicted - 1.0).abs() < 0.06,
                "{found} {predicted}"
            );
        }
    }

    #[test]
    fn end_on_there_is_no_spread_to_speak_of() {
        let arcs = [0.0, 0.12, 0.24].map(|x| arc(0, Vec2::new(x, 0.0), 0.0, 3.0 - x));
        let [a, b, c] = &arcs;
        let spread = Spread::of([a, b, c]);
        assert!(spread.theta_c > 1e3, "{spread:?}");
        assert_eq!(Spread::of([a, a, a]).theta_c(), None);
    }
}
