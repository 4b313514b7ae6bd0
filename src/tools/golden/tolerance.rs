//! How far a feature may move before somebody should look.

use serde::{Deserialize, Serialize};

/// What counts as the same. Metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// A line's distance from the origin, metres.
    pub rho: f64,
    /// The direction of its normal, radians.
    pub theta: f64,
    /// Its middle along the line, and half its length, metres.
    pub extent: f64,
    /// A point's x and y, metres.
    pub position: f64,
    /// A standard deviation, as a fraction of itself.
    pub sigma: f64,
    /// The number of readings behind a feature.
    pub readings: u32,
    /// A label that flipped with less than this to spare may be rounding, radians.
    pub borderline: f64,
    /// The same for a label that the readings decide, not the angles: chi2.
    #[serde(default = "borderline_chi2")]
    pub borderline_chi2: f64,
    /// Features farther apart than this are never the same one, metres.
    pub pair_distance: f64,
    /// Lines whose normals differ by more than this are never the same one, radians.
    pub pair_angle: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            rho: 0.010,
            theta: 0.010,
            extent: 0.050,
            position: 0.010,
            sigma: 0.05,
            readings: 1,
            borderline: 0.001,
            borderline_chi2: borderline_chi2(),
            pair_distance: 0.30,
            pair_angle: 0.20,
        }
    }
}

/// A hundredth of what decides: far more than rounding, less than any change that matters.
fn borderline_chi2() -> f64 {
    0.1
}

/// A tolerance that makes no sense.
#[derive(Debug, thiserror::Error)]
pub enum ToleranceError {
    /// Not a number that can be a tolerance.
    #[error("tolerance {key} is {value}; it must be a number of at least 0")]
    OutOfBounds {
        /// Which.
        key: &'static str,
        /// As given.
        value: f64,
    },
    /// Features would be told apart before they are out of tolerance.
    #[error(
        "tolerance {key} is {value}, more than {gate}, which is {limit}: farther apart, two features are never taken for the same one. Raise {gate} too"
    )]
    BeyondGate {
        /// Which.
        key: &'static str,
        /// As given.
        value: f64,
        /// The gate's name.
        gate: &'static str,
        /// The gate.
        limit: f64,
    },
    /// Not `KEY=VALUE` with a known key.
    #[error(
        "`{text}` is no tolerance: {reason}. Give KEY=VALUE, such as rho=0.02 (metres and radians)"
    )]
    Malformed {
        /// As given.
        text: String,
        /// Why.
        reason: String,
    },
}

impl Tolerance {
    /// Checks that every number is one.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), ToleranceError> {
        for (key, value) in [
            ("rho", self.rho),
            ("theta", self.theta),
            ("extent", self.extent),
            ("position", self.position),
            ("sigma", self.sigma),
            ("borderline", self.borderline),
            ("borderline_chi2", self.borderline_chi2),
            ("pair_distance", self.pair_distance),
            ("pair_angle", self.pair_angle),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(ToleranceError::OutOfBounds { key, value });
            }
        }
        let (distance, angle) = (self.pair_distance, self.pair_angle);
        for (key, value, gate, limit) in [
            ("rho", self.rho, "pair_distance", distance),
            ("position", self.position, "pair_distance", distance),
            ("theta", self.theta, "pair_angle", angle),
        ] {
            if value > limit {
                return Err(ToleranceError::BeyondGate {
                    key,
                    value,
                    gate,
                    limit,
                });
            }
        }
        Ok(())
    }

    /// The same with one more `KEY=VALUE`.
    ///
    /// # Errors
    /// An unknown key or a value that is no number.
    pub fn with(self, text: impl AsRef<str>) -> Result<Self, ToleranceError> {
        let text = text.as_ref();
        let malformed = |reason: String| ToleranceError::Malformed {
            text: text.to_owned(),
            reason,
        };
        let (key, value) = text
            .split_once('=')
            .ok_or_else(|| malformed("it has no `=`".to_owned()))?;
        let value =
            number(value.trim()).ok_or_else(|| malformed("the value is no number".to_owned()))?;
        let mut all = serde_json::to_value(self).map_err(|e| malformed(e.to_string()))?;
        if let Some(all) = all.as_object_mut() {
            all.insert(key.trim().to_owned(), value);
        }
        let changed: Self = serde_json::from_value(all).map_err(|e| malformed(e.to_string()))?;
        changed.check()?;
        Ok(changed)
    }
}

/// A number as people write it: whole where it can be.
fn number(text: &str) -> Option<serde_json::Value> {
    let whole = text.parse::<u64>().ok().map(serde_json::Value::from);
    whole.or_else(|| {
        let number = serde_json::Number::from_f64(text.parse().ok()?)?;
        Some(number.into())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tolerance_is_set_by_its_name() {
        let wide = Tolerance::default().with("rho = 0.02").unwrap();
        assert_eq!(wide.rho, 0.02);
        assert_eq!(wide.with("readings=3").unwrap().readings, 3);
        assert_eq!(wide.with("rho=.03").unwrap().rho, 0.03);
        for (text, said) in [
            ("roh=1", "unknown field `roh`"),
            ("rho", "no `=`"),
            ("rho=much", "no number"),
            ("rho=inf", "no number"),
            ("rho=-1", "at least 0"),
            ("rho=0.5", "Raise pair_distance"),
            ("readings=1.5", "readings"),
        ] {
            let error = Tolerance::default().with(text).unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
