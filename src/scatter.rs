//! How far the ranges scatter, told by the ranges themselves.
//!
//! While a robot drives past a wall, a range is the mean of its two neighbours, but for the noise.
//! Whatever else echoes leaves more than that, never less, so a low quantile of what is left
//! measures the noise as long as a good part of the arcs belongs to walls.

use std::collections::BTreeMap;

use crate::config::Config;
use crate::event::{RangeReading, SonarId};
use crate::geometry::angle_between;
use crate::tmam::arc::Arc;

/// A sensor that turned by more than this over three arcs may see something else, radians.
const MOST_TURN: f64 = 0.035;
/// Sensors closer than this say nothing of the noise: drivers repeat what they measured, metres.
const SHORTEST: f64 = 0.02;
/// Over longer ways than this few walls are straight, metres.
const LONGEST: f64 = 1.0;
/// The share of the smallest deviations that is looked at, and its place in units of sigma: the
/// absolute value of a normal deviate lies below 0.3186 sigma with this probability.
const SHARE: f64 = 0.25;
const SHARE_IN_SIGMAS: f64 = 0.318_639_363_96;
/// Fewer deviations than this mean nothing.
const ENOUGH: usize = 30;
/// Noise within these factors of what it is taken to be is as expected.
const AS_EXPECTED: std::ops::RangeInclusive<f64> = 0.4..=2.0;

/// Noise as measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Standard deviation of a range, metres.
    pub sigma: f64,
    /// The same in units of what it is taken to be: 1 where the configuration or the messages'
    /// variance is right.
    pub ratio: f64,
}

impl Scatter {
    /// Whether the noise is taken to be what it is, within a factor of about two.
    pub fn is_as_expected(&self) -> bool {
        AS_EXPECTED.contains(&self.ratio)
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
        match variance {
            VarianceFrom::Configuration => format!("set noise.sigma_abs = {sigma}"),
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
}

impl VarianceFrom {
    /// Of a log's readings under a configuration.
    pub fn of(readings: &[RangeReading], config: &Config) -> Self {
        let given = |reading: &RangeReading| reading.variance > 0.0;
        if config.noise.trust_variance && readings.iter().any(given) {
            Self::Messages
        } else {
            Self::Configuration
        }
    }
}

/// Watches the arcs of a replay.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scattering {
    sonars: BTreeMap<SonarId, Sonar>,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Sonar {
    last: Option<(Arc, Option<Arc>)>,
    /// In metres, and in standard deviations.
    deviations: Vec<(f64, f64)>,
}

impl Scattering {
    /// Takes the next arc of its sonar.
    pub fn push(&mut self, arc: &Arc) {
        let sonar = self.sonars.entry(arc.id.sonar).or_default();
        if let Some((middle, Some(first))) = &sonar.last {
            sonar.deviations.extend(deviation(first, middle, arc));
        }
        sonar.last = Some((*arc, sonar.last.map(|(last, _)| last)));
    }

    /// The noise of one sonar; `None` where too little tells of it.
    pub fn of(&self, sonar: SonarId) -> Option<Scatter> {
        scatter(self.sonars.get(&sonar)?.deviations.iter())
    }

    /// The noise of all sonars together.
    pub fn overall(&self) -> Option<Scatter> {
        scatter(self.sonars.values().flat_map(|sonar| &sonar.deviations))
    }
}

/// How far the middle one of three arcs is from what the others foretell, in metres and in standard
/// deviations; `None` where they foretell nothing.
fn deviation(first: &Arc, middle: &Arc, last: &Arc) -> Option<(f64, f64)> {
    let turned = angle_between(first.world_from_sensor.yaw, last.world_from_sensor.yaw);
    let before = (middle.center() - first.center()).norm();
    let after = (last.center() - middle.center()).norm();
    let apart = before.min(after) >= SHORTEST && before + after <= LONGEST;
    if turned > MOST_TURN || !apart {
        return None;
    }
    let share = before / (before + after);
    let off = (middle.range - first.range * (1.0 - share) - last.range * share).abs();
    let weigh = |of: fn(&Arc) -> f64| {
        let neighbours = (1.0 - share) * (1.0 - share) * of(first) + share * share * of(last);
        (of(middle) + neighbours).sqrt()
    };
    Some((off / weigh(|_| 1.0), off / weigh(|arc| arc.variance)))
}

fn scatter<'a>(deviations: impl Iterator<Item = &'a (f64, f64)>) -> Option<Scatter> {
    let (metres, sigmas): (Vec<f64>, Vec<f64>) = deviations.copied().unzip();
    let sigma = quantile(metres)? / SHARE_IN_SIGMAS;
    let ratio = quantile(sigmas)? / SHARE_IN_SIGMAS;
    Some(Scatter { sigma, ratio })
}

fn quantile(mut deviations: Vec<f64>) -> Option<f64> {
    if deviations.len() < ENOUGH {
        return None;
    }
    let at = (SHARE * deviations.len() as f64) as usize;
    let (_, value, _) = deviations.select_nth_unstable_by(at, f64::total_cmp);
    Some(*value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec2;
    use crate::tmam::fit::testing::{Gauss, SIGMA, arc};

    /// Along a wall that is not parallel to the path; every third reading is of something else.
    fn drive(step: f64, noise: f64, strangers: bool) -> Scattering {
        let mut rng = Gauss::new(7);
        let mut scattering = Scattering::default();
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
