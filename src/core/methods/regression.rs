//! Lines through places.

use std::f64::consts::FRAC_PI_2;

use crate::core::geometry::{Vec2, unit};
use crate::core::tmam::feature::{Segment, UNKNOWN_COVARIANCE};

/// The line with the least squared distances from places, from the first of them to the last along it;
/// `None` of less than two places apart.
pub fn line_through(places: &[Vec2]) -> Option<Segment> {
    let count = places.len() as f64;
    let middle = places.iter().fold(Vec2::zeros(), |sum, place| sum + place) / count;
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for off in places.iter().map(|place| place - middle) {
        xx += off.x * off.x;
        xy += off.x * off.y;
        yy += off.y * off.y;
    }
    let are_apart = places.len() >= 2 && xx + yy > 0.0;
    if !are_apart {
        return None;
    }
    let theta = libm::atan2(2.0 * xy, xx - yy) / 2.0 + FRAC_PI_2;
    let line = Segment {
        rho: middle.dot(&unit(theta)),
        theta,
        covariance: UNKNOWN_COVARIANCE,
        mid: middle,
        half_length: 0.0,
    };
    Some(line.reaching_over(places.iter().copied()).canonical())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::geometry::angle_between;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn places_on_a_line_give_the_line(rho in 0.1..5.0f64, theta in -3.1..3.1f64, length in 0.1..9.0f64) {
            let along = unit(theta + FRAC_PI_2);
            let places = [-0.5, 0.1, 0.5].map(|share| unit(theta) * rho + along * (share * length));
            let line = line_through(&places).unwrap();
            prop_assert!((line.rho - rho).abs() < 1e-9 && angle_between(line.theta, theta) < 1e-9);
            prop_assert!((line.half_length - length / 2.0).abs() < 1e-9);
        }
    }

    #[test]
    fn one_place_has_no_line() {
        assert_eq!(line_through(&[]), None);
        assert_eq!(line_through(&[Vec2::new(1.0, 2.0); 3]), None);
    }
}
