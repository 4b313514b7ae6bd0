//! How far the ranges scatter, told by the ranges themselves.
//!
//! While a robot drives past a wall or a corner, four ranges in a row lie on a parabola, but for the
//! noise. Where they come from different targets they are farther off, never nearer, so a low
//! quantile of what is left measures the noise as long as most neighbours share a target.

use std::collections::{BTreeMap, VecDeque};
use std::ops::RangeInclusive;

use crate::core::config::Config;
use crate::core::event::{RangeReading, Return, SonarId};
use crate::core::geometry::angle_between;
use crate::core::ties;
use crate::core::tmam::arc::Arc;

/// A sensor that turned by more than this over four arcs may see something else, radians.
const MOST_TURN: f64 = 0.035;
/// Sensors closer than this say nothing of the noise: drivers repeat what they measured, metres.
const SHORTEST: f64 = 0.02;
/// Over longer ways than this targets change, metres.
const LONGEST: f64 = 1.0;
/// The share of the smallest deviations that is looked at, and its end in units of sigma: the
/// absolute value of a normal deviate lies below it with this probability.
const SHARE: f64 = 1.0 / 3.0;
const SHARE_IN_SIGMAS: f64 = 0.430_727_3;
/// Fewer deviations than this mean nothing.
const ENOUGH: usize = 50;
/// Ranges come as 32-bit numbers; what lies closer together than this is dust, metres.
const DUST: f64 = 2e-6;
/// This share of ranges, or more, has an equal if they are on a raster that is worth the name.
const EQUAL_ON_RASTER: f64 = 0.3;
/// Rounding to a raster is noise of the raster over the square root of twelve.
const ROUNDING: f64 = 3.464_101_615;
/// Noise that is measured lies in here, metres: finer is not believed, coarser no sonar.
const BELIEVED: RangeInclusive<f64> = 1e-3..=0.1;
/// Noise within these factors of what it is taken to be is as expected.
const AS_EXPECTED: RangeInclusive<f64> = 0.4..=2.0;

/// Noise as measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseEstimate {
    /// Standard deviation of a range, metres.
    pub sigma: f64,
    /// The same in units of what it is taken to be: 1 where the configuration or the messages'
    /// variance is right.
    pub ratio: f64,
}

impl NoiseEstimate {
    /// Whether the noise is taken to be what it is, within a factor of about two.
    pub fn is_as_expected(&self) -> bool {
        AS_EXPECTED.contains(&self.ratio)
    }

    /// What the noise is to be taken for, metres, in whole micrometres.
    /// `besides` is what else adds to it, in variances: what the pose does.
    pub fn believed(&self, besides: f64) -> f64 {
        let variance = (self.sigma * self.sigma - besides).max(0.0);
        let sigma = variance.sqrt().clamp(*BELIEVED.start(), *BELIEVED.end());
        libm::rint(sigma * 1e6) / 1e6
    }

    /// What is wrong, in words.
    pub fn complaint(&self) -> String {
        let [measured, taken] = [self.sigma, self.sigma / self.ratio].map(|m| m * 1e3);
        format!(
            "the ranges scatter by {measured:.1} mm, but their noise is taken to be {taken:.1} mm"
        )
    }

    /// The keys that mend it.
    pub fn mend(&self, variance: VarianceFrom) -> String {
        let digits = |metres: f64| match metres {
            m if m < 0.01 => format!("{m:.4}"),
            m => format!("{m:.3}"),
        };
        let sigma = digits(self.sigma);
        if self.sigma > *BELIEVED.end() {
            return "no sonar scatters so: they are in another unit, or many are of other sonars' sound or of \
                    targets that move"
                .to_owned();
        }
        match variance {
            VarianceFrom::Configuration | VarianceFrom::Ranges | VarianceFrom::Nothing => {
                format!("set noise.sigma_abs = {sigma}")
            }
            VarianceFrom::Messages if self.ratio > 1.0 => {
                let rest = (1.0 - 1.0 / (self.ratio * self.ratio)).max(0.0).sqrt();
                format!(
                    "their variance comes with the messages: add to it with noise.sigma_pose = {}, \
                     or set noise.trust_variance = false and noise.sigma_abs = {sigma}",
                    digits(self.sigma * rest)
                )
            }
            VarianceFrom::Messages => format!(
                "their variance comes with the messages: set noise.trust_variance = false and \
                 noise.sigma_abs = {sigma}"
            ),
        }
    }
}

/// Where the variance of a log's ranges comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum VarianceFrom {
    /// `[noise]` of the configuration.
    #[default]
    Configuration,
    /// The messages themselves.
    Messages,
    /// It is measured.
    Ranges,
    /// Too little tells of it, so something usual is assumed.
    Nothing,
}

impl VarianceFrom {
    /// Of a log's readings under a configuration.
    pub fn of(readings: impl Iterator<Item = RangeReading>, config: &Config) -> Self {
        let given = |reading: RangeReading| reading.variance > 0.0 && reading.variance.is_finite();
        let noise = &config.noise;
        let mut echoes = readings.filter(|r| r.classify() == Return::Echo);
        if noise.trust_variance && echoes.all(given) {
            Self::Messages
        } else if noise.sigma_abs.is_none() {
            Self::Ranges
        } else {
            Self::Configuration
        }
    }
}

/// Watches the arcs of a replay.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NoiseEstimator {
    sonars: BTreeMap<SonarId, Sonar>,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Sonar {
    /// The newest arcs.
    last: VecDeque<Arc>,
    /// Of four arcs each, in metres and in standard deviations.
    deviations: Vec<(f64, f64)>,
    ranges: Vec<f64>,
}

impl NoiseEstimator {
    /// Takes the next arc of its sonar.
    pub fn push(&mut self, arc: &Arc) {
        let sonar = self.sonars.entry(arc.id.sonar).or_default();
        sonar.ranges.push(arc.range);
        sonar.last.push_back(*arc);
        let newest = sonar.last.make_contiguous();
        if let [first, second, third, fourth] = newest {
            sonar
                .deviations
                .extend(deviation([first, second, third, fourth]));
            sonar.last.pop_front();
        }
    }

    /// The noise of one sonar; `None` where too little tells of it.
    pub fn of(&self, sonar: SonarId) -> Option<NoiseEstimate> {
        scatter(std::iter::once(self.sonars.get(&sonar)?))
    }

    /// The noise of all sonars together.
    pub fn overall(&self) -> Option<NoiseEstimate> {
        scatter(self.sonars.values())
    }
}

/// How far four arcs in a row are from any parabola, in metres and in standard deviations; `None`
/// where they were not measured in passing.
fn deviation(arcs: [&Arc; 4]) -> Option<(f64, f64)> {
    let [first, second, third, last] = arcs;
    let turned = angle_between(first.world_from_sensor.yaw, last.world_from_sensor.yaw);
    let apart = |a: &Arc, b: &Arc| (b.center() - a.center()).norm();
    let steps = [
        apart(first, second),
        apart(second, third),
        apart(third, last),
    ];
    let along = steps.iter().sum::<f64>();
    let too_short = |step: &f64| ties::below(*step, SHORTEST, ties::LENGTH);
    if ties::above(turned, MOST_TURN, ties::ANGLE)
        || ties::above(along, LONGEST, ties::LENGTH)
        || steps.iter().any(too_short)
    {
        return None;
    }
    let ways = [0.0, steps[0], steps[0] + steps[1], along];
    let (mut off, mut squares, mut variance) = (0.0, 0.0, 0.0);
    for (arc, way) in arcs.iter().zip(ways) {
        // The weights of the third divided difference.
        let others = ways.iter().filter(|other| **other != way);
        let weight = 1.0 / others.map(|other| way - other).product::<f64>();
        off += weight * arc.range;
        squares += weight * weight;
        variance += weight * weight * arc.variance;
    }
    Some((off.abs() / squares.sqrt(), off.abs() / variance.sqrt()))
}

fn scatter<'a>(sonars: impl Iterator<Item = &'a Sonar> + Clone) -> Option<NoiseEstimate> {
    let deviations = sonars.clone().flat_map(|sonar| &sonar.deviations);
    let (metres, sigmas): (Vec<f64>, Vec<f64>) = deviations.copied().unzip();
    if metres.len() < ENOUGH {
        return None;
    }
    let raster = raster(sonars.flat_map(|sonar| &sonar.ranges).copied().collect());
    let sigma = quantile(metres, SHARE)? / SHARE_IN_SIGMAS;
    let ratio = quantile(sigmas, SHARE)? / SHARE_IN_SIGMAS;
    Some(NoiseEstimate {
        sigma: sigma.max(raster / ROUNDING),
        ratio,
    })
}

/// The raster of ranges; 0 where they are on none.
fn raster(mut ranges: Vec<f64>) -> f64 {
    ranges.sort_by(f64::total_cmp);
    let gaps = ranges.array_windows().map(|[a, b]| b - a);
    let (apart, equal): (Vec<f64>, Vec<f64>) = gaps.partition(|gap| *gap > DUST);
    if (equal.len() as f64) < EQUAL_ON_RASTER * ranges.len() as f64 {
        return 0.0;
    }
    quantile(apart, 0.05).unwrap_or(0.0)
}

fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    let at = (share * values.len() as f64) as usize;
    if at >= values.len() {
        return None;
    }
    let (_, value, _) = values.select_nth_unstable_by(at, f64::total_cmp);
    Some(*value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::Vec2;
    use crate::core::tmam::fit::testing::{Gauss, SIGMA, arc};

    /// Along a wall that is not parallel to the path; every third reading is of something else.
    fn drive(step: f64, noise: f64, strangers: bool) -> NoiseEstimator {
        let mut rng = Gauss::new(7);
        let mut scattering = NoiseEstimator::default();
        for k in 0..900 {
            let x = step * (f64::from(k) + 0.3 * f64::from(k % 2));
            let stranger = if strangers && k % 15 < 3 {
                f64::from(k % 7)
            } else {
                0.0
            };
            let range = 2.0 + 0.1 * x + stranger + noise * rng.sample();
            scattering.push(&arc(k, Vec2::new(x, 0.0), 1.5, range));
        }
        scattering
    }

    #[test]
    fn the_noise_is_what_it_is_whatever_the_variance_says() {
        for (noise, ratio) in [(SIGMA, 1.0), (4.0 * SIGMA, 4.0), (SIGMA / 4.0, 0.25)] {
            let scatter = drive(0.1, noise, false).overall().unwrap();
            assert!((scatter.sigma / noise - 1.0).abs() < 0.1, "{scatter:?}");
            assert!((scatter.ratio / ratio - 1.0).abs() < 0.1, "{scatter:?}");
            assert_eq!(scatter.is_as_expected(), noise == SIGMA);
        }
    }

    #[test]
    fn noise_is_not_finer_than_the_raster() {
        let mut scattering = NoiseEstimator::default();
        for k in 0..200 {
            let x = 0.1 * f64::from(k);
            let range = libm::round((2.0 + 0.004 * x) * 50.0) / 50.0;
            scattering.push(&arc(k, Vec2::new(x, 0.0), 1.5, range));
        }
        let sigma = scattering.overall().unwrap().sigma;
        assert!((sigma - 0.02 / 12.0_f64.sqrt()).abs() < 1e-6, "{sigma}");
    }

    #[test]
    fn what_else_echoes_hardly_matters() {
        let scatter = drive(0.1, SIGMA, true).overall().unwrap();
        assert!((0.9..1.8).contains(&scatter.ratio), "{scatter:?}");
    }

    #[test]
    fn a_robot_that_stands_or_leaps_says_nothing() {
        assert_eq!(drive(0.001, SIGMA, false).overall(), None);
        assert_eq!(drive(2.0, SIGMA, false).overall(), None);
        assert_eq!(drive(0.1, SIGMA, false).of(SonarId(3)), None);
    }
}
