//! How far features are off, and whether their covariances say so.

use serde::Serialize;

use super::matching::{self, Comparison};
use super::share;
use crate::core::rounding::{number, optional};

/// The value that a chi2 with two degrees of freedom exceeds one time in twenty.
const CHI2_95: f64 = 5.991;

/// Mean and largest magnitude of an error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Mean magnitude.
    #[serde(serialize_with = "number")]
    pub mean: f64,
    /// Largest magnitude.
    #[serde(serialize_with = "number")]
    pub max: f64,
}

/// Whether the covariances are honest: normalised errors squared.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Nees {
    /// Features it is taken over; those without an inverse covariance are left out.
    pub features: u64,
    /// Mean per degree of freedom: 1 where the covariances are honest, more where they are too
    /// small.
    #[serde(serialize_with = "optional")]
    pub mean: Option<f64>,
    /// Share inside the ellipse that should hold 95 %.
    #[serde(serialize_with = "optional")]
    pub within_95: Option<f64>,
}

/// How much they are off.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Of lines, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rho: Option<Spread>,
    /// Of lines, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta: Option<Spread>,
    /// Of points, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<Spread>,
    /// Against their covariances.
    pub nees: Nees,
}

impl Errors {
    /// Sums up.
    pub fn of<'a>(comparisons: impl Iterator<Item = &'a Comparison> + Clone) -> Self {
        let spread = |of: fn(&matching::Error) -> Option<f64>| {
            let errors: Vec<f64> = comparisons
                .clone()
                .filter_map(|c| of(&c.error).map(f64::abs))
                .collect();
            (!errors.is_empty()).then(|| Spread {
                mean: errors.iter().sum::<f64>() / errors.len() as f64,
                max: errors.iter().copied().fold(0.0, f64::max),
            })
        };
        let nees: Vec<f64> = comparisons.clone().filter_map(|c| c.nees).collect();
        let count = nees.len() as u64;
        let within = nees.iter().filter(|nees| **nees <= CHI2_95).count() as u64;
        Self {
            rho: spread(|error| match error {
                matching::Error::Line { rho, .. } => Some(*rho),
                matching::Error::Point { .. } => None,
            }),
            theta: spread(|error| match error {
                matching::Error::Line { theta, .. } => Some(*theta),
                matching::Error::Point { .. } => None,
            }),
            position: spread(|error| match error {
                matching::Error::Point { distance } => Some(*distance),
                matching::Error::Line { .. } => None,
            }),
            nees: Nees {
                features: count,
                mean: (count > 0).then(|| nees.iter().sum::<f64>() / (2 * count) as f64),
                within_95: share(within, count),
            },
        }
    }
}
