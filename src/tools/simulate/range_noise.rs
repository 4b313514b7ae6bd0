//! What goes wrong with ranges: noisy, missing and spurious echoes.

use crate::core::world::Echo;

use super::random::Random;
use super::{Ring, SimulateError, deviation, require};

/// What goes wrong with a reading. All zero: nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RangeNoise {
    /// Standard deviation of an echo's range, metres.
    pub sigma: f64,
    /// Probability that an echo is not heard.
    pub no_echo: f64,
    /// Probability that a reading is replaced by a range drawn evenly from all that the sonar can
    /// measure, whether there was an echo or not.
    pub outliers: f64,
}

impl RangeNoise {
    /// The variance that the sonar reports, square metres.
    pub fn variance(&self) -> f64 {
        self.sigma * self.sigma
    }

    /// Refuses what is not a deviation or a probability.
    pub(super) fn validate(&self) -> Result<(), SimulateError> {
        deviation("the range noise in metres", self.sigma)?;
        for (name, value) in [
            ("the probability of no echo", self.no_echo),
            ("the probability of an outlier", self.outliers),
        ] {
            require((0.0..=1.0).contains(&value), name, value, "0 to 1")?;
        }
        Ok(())
    }
}

/// What a sonar made of an echo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measured {
    /// Metres, as REP-117 has it: +inf for no echo, -inf for an echo too close to measure.
    pub(super) range: f32,
    /// Whether the range has nothing to do with the echo.
    pub(super) outlier: bool,
}

/// Sonars with noise.
pub(super) struct NoisySonar {
    noise: RangeNoise,
    random: Random,
}

impl NoisySonar {
    pub(super) fn new(noise: RangeNoise, seed: u64) -> Self {
        Self {
            noise,
            random: Random::new(seed, 0),
        }
    }

    /// The reading that `echo` gives a sonar of `ring`.
    pub(super) fn measure(&mut self, echo: Option<Echo>, ring: &Ring) -> Measured {
        let Ring {
            min_range,
            max_range,
            ..
        } = *ring;
        // Always the same draws, so that one setting does not reshuffle another's noise.
        let deviation = self.random.normal() * self.noise.sigma;
        let lost = self.random.uniform() < self.noise.no_echo;
        let outlier = self.random.uniform() < self.noise.outliers;
        let anywhere = min_range + (max_range - min_range) * self.random.uniform();

        let range = if outlier {
            anywhere
        } else {
            echo.filter(|_| !lost)
                .map_or(f64::INFINITY, |echo| echo.range + deviation)
        } as f32;
        Measured {
            range: if range >= max_range as f32 {
                f32::INFINITY
            } else if range < min_range as f32 {
                f32::NEG_INFINITY
            } else {
                range
            },
            outlier,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::world::Reflector;
    use crate::tools::simulate::random::tests::mean_and_deviation;

    fn echo(range: f64) -> Option<Echo> {
        Some(Echo {
            range,
            reflector: Reflector::Line(0),
        })
    }

    #[test]
    fn without_noise_an_echo_is_itself() {
        let mut sonar = NoisySonar::new(RangeNoise::default(), 1);
        let mut range = |echo| sonar.measure(echo, &Ring::default()).range;
        assert_eq!(range(echo(2.5)), 2.5);
        assert_eq!(range(None), f32::INFINITY);
        assert_eq!(range(echo(0.1)), f32::NEG_INFINITY);
        // Rounded to 32 bits this is the maximum range, so no echo.
        assert_eq!(range(echo(9.999_999_99)), f32::INFINITY);
    }

    #[test]
    fn readings_go_missing_and_astray_as_often_as_asked() {
        let noise = RangeNoise {
            sigma: 0.003,
            no_echo: 0.2,
            outliers: 0.1,
        };
        let mut sonar = NoisySonar::new(noise, 3);
        let readings: Vec<_> = (0..10_000)
            .map(|_| sonar.measure(echo(3.0), &Ring::default()))
            .collect();
        let share = |predicate: fn(&Measured) -> bool| {
            readings.iter().filter(|m| predicate(m)).count() as f64 / 10_000.0
        };
        assert!((share(|m| m.outlier) - 0.1).abs() < 0.02);
        assert!((share(|m| m.range == f32::INFINITY) - 0.9 * 0.2).abs() < 0.02);
        let good = readings
            .iter()
            .filter(|m| !m.outlier && m.range.is_finite());
        let errors: Vec<_> = good.map(|m| f64::from(m.range) - 3.0).collect();
        let (mean, deviation) = mean_and_deviation(&errors);
        assert!(mean.abs() < 2e-4 && (deviation - 0.003).abs() < 2e-4);
    }

    #[test]
    fn impossible_noise_is_refused() {
        for (sigma, no_echo, outliers) in [
            (-0.1, 0.0, 0.0),
            (f64::NAN, 0.0, 0.0),
            (0.0, 1.1, 0.0),
            (0.0, 0.0, -0.1),
            (0.0, 0.0, f64::NAN),
        ] {
            let noise = RangeNoise {
                sigma,
                no_echo,
                outliers,
            };
            assert!(noise.validate().is_err(), "{noise:?}");
        }
    }
}
