//! Variances that are none: stand-ins as 255 or -1 for "unknown".

use super::examined::{Examined, in_words};
use super::finding::{Finding, Weight};
use crate::core::event::RangeReading;
use crate::core::statistics::median;

/// No sonar is as bad, metres.
const WORST: f64 = 0.5;

pub fn check(of: &Examined<'_>) -> Vec<Finding> {
    found(of).into_iter().collect()
}

fn found(of: &Examined<'_>) -> Option<Finding> {
    if !of.survey.config.noise.trust_variance {
        return None;
    }
    let variances = of
        .survey
        .log
        .events
        .readings
        .iter()
        .map(|reading: RangeReading| reading.variance);
    let mut variances: Vec<f64> = variances
        .filter(|variance| *variance != 0.0 && !variance.is_nan())
        .collect();
    variances.sort_unstable_by(f64::total_cmp);
    let middle = median(&variances)?;
    let is_wrong = !(0.0..=WORST * WORST).contains(&middle);
    is_wrong.then(|| {
        let tried = of.tried("noise.trust_variance = false");
        Finding::new(
            Weight::Serious,
            "variance",
            format!(
                "the variance that comes with the ranges is {middle} m^2 in the middle, no sonar's"
            ),
            "ranges are taken to scatter so much that walls and corners all fit alike",
            format!(
                "set noise.trust_variance = false: the noise is then measured from the ranges{}",
                in_words(tried.as_ref())
            ),
        )
        .with(tried)
    })
}
