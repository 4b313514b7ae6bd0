//! Comparisons that the last bit does not decide.
//!
//! The end of a wall is its outermost reading, a robot that stops every 0.1 m opens a frame at each
//! stop, and a wall and its mirror image at a straight path fit equally well. Such values are equal
//! in the world; which of them comes out larger is left to rounding, unless the comparison has a
//! slack. Every slack here is a thousand times what rounding does to a log's numbers, and a
//! thousandth of what a sonar tells apart.

/// Lengths that differ by less are equal, metres.
pub const LENGTH: f64 = 1e-6;

/// A reading this near to the closest or farthest distance of its sonar is equal to it, metres: 32-bit
/// numbers of a decimetre are farther apart.
pub const RANGE: f64 = 1e-8;

/// Angles that differ by less are equal, radians.
pub const ANGLE: f64 = 1e-6;

/// Chi2 that differ by less are equal: this much, and this share of the smaller one. A nanometre
/// moves chi2 by a hundred-thousandth at most; noise moves it by one.
pub const CHI2: f64 = 1e-4;

/// Whether a value is beyond a bound, and not only by rounding.
pub fn above(value: f64, bound: f64, slack: f64) -> bool {
    value > bound + slack
}

/// Whether a value lies before a bound, and not only by rounding.
pub fn below(value: f64, bound: f64, slack: f64) -> bool {
    value < bound - slack
}

/// Whether a value reaches a bound, or would but for rounding.
pub fn at_least(value: f64, bound: f64, slack: f64) -> bool {
    value >= bound - slack
}

/// Whether a value stays within a bound, or would but for rounding.
pub fn at_most(value: f64, bound: f64, slack: f64) -> bool {
    value <= bound + slack
}

/// What two chi2 may differ by and still be equal.
pub fn of_chi2(a: f64, b: f64) -> f64 {
    CHI2 * (1.0 + a.min(b))
}

/// The first of those that are least: a later one must be less by more than the slack that goes with
/// the two values.
pub fn first_least<T>(
    items: impl IntoIterator<Item = (f64, T)>,
    slack: impl Fn(f64, f64) -> f64,
) -> Option<(f64, T)> {
    let finite = items.into_iter().filter(|(value, _)| !value.is_nan());
    finite.reduce(|best, item| {
        if below(item.0, best.0, slack(item.0, best.0)) {
            item
        } else {
            best
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_what_is_equal_but_for_rounding_the_first_is_taken() {
        let least = |values: &[f64]| {
            first_least(values.iter().copied().zip(0..), of_chi2).map(|(_, place)| place)
        };
        assert_eq!(least(&[]), None);
        assert_eq!(least(&[3.0, 2.0, 2.0 - 1e-9, 2.5]), Some(1));
        assert_eq!(least(&[3.0, 2.0 - 1e-9, 2.0, 1.9]), Some(3));
        assert_eq!(least(&[f64::NAN, f64::INFINITY, 7.0]), Some(2));
        assert_eq!(least(&[f64::INFINITY, f64::INFINITY]), Some(0));
    }

    #[test]
    fn a_bound_that_is_met_but_for_rounding_is_met() {
        for by in [-1e-9, 0.0, 1e-9] {
            assert!(at_least(0.1 + by, 0.1, LENGTH) && at_most(0.1 + by, 0.1, LENGTH));
            assert!(!above(0.1 + by, 0.1, LENGTH) && !below(0.1 + by, 0.1, LENGTH));
        }
    }
}
