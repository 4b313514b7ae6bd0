//! The noise of the ranges, and whether they tell it themselves: all of the noise-aware rule hangs on it.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::compare::deviation;
use super::difference::{Change, Value};
use super::tolerance::Tolerance;
use crate::core::config::Config;
use crate::core::noise_estimate::VarianceFrom;

/// What is known of the noise of the ranges. In files a number, `null`, or nothing at all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum RangeNoise {
    /// Nothing: it was not recorded.
    #[default]
    Unknown,
    /// It was not measured: messages or the configuration say it, or there is too little to measure it by.
    Given,
    /// The ranges tell it themselves: the standard deviation of a range, metres.
    Measured(f64),
}

impl RangeNoise {
    /// Of a replay, by where it had the variance from and what it used.
    pub fn of(variance: VarianceFrom, config: &Config) -> Self {
        let measured = config.noise.sigma_abs.map(Self::Measured);
        measured
            .filter(|_| variance == VarianceFrom::Ranges)
            .unwrap_or(Self::Given)
    }

    /// Whether nothing is recorded.
    pub fn is_unknown(&self) -> bool {
        *self == Self::Unknown
    }

    fn words(self) -> String {
        match self {
            Self::Measured(sigma) => format!("measured {:.1} mm", sigma * 1e3),
            Self::Given => "said by messages or configuration".to_owned(),
            Self::Unknown => "unknown".to_owned(),
        }
    }
}

impl Serialize for RangeNoise {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Measured(sigma) => serializer.serialize_some(sigma),
            Self::Given | Self::Unknown => serializer.serialize_none(),
        }
    }
}

impl<'de> Deserialize<'de> for RangeNoise {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let sigma = Option::<f64>::deserialize(deserializer)?;
        Ok(sigma.map_or(Self::Given, Self::Measured))
    }
}

/// How the noise differs, where both sides record it.
pub fn compare_noise(
    golden: RangeNoise,
    actual: RangeNoise,
    tolerance: &Tolerance,
) -> Option<Change> {
    match (golden, actual) {
        (RangeNoise::Measured(then), RangeNoise::Measured(now)) => {
            deviation("measured sigma", then, now, tolerance.sigma)
        }
        (RangeNoise::Unknown, _) | (_, RangeNoise::Unknown) => None,
        (then, now) => (then != now).then(|| Change {
            what: "noise",
            value: Value::Word {
                golden: then.words(),
                actual: now.words(),
            },
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_that_begins_or_ends_to_be_measured_is_a_difference() {
        use RangeNoise::{Given, Measured, Unknown};
        let differs = |a, b| compare_noise(a, b, &Tolerance::default()).is_some();
        assert!(differs(Measured(0.0035), Given) && differs(Given, Measured(0.0035)));
        assert!(differs(Measured(0.0035), Measured(0.005)));
        assert!(!differs(Given, Given) && !differs(Measured(0.0035), Measured(0.0036)));
        for other in [Unknown, Given, Measured(0.0035)] {
            assert!(!differs(Unknown, other) && !differs(other, Unknown));
        }
    }
}
