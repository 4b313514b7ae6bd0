//! Numbers as files hold them: rounded to 1e-9, so that the last bits of a sum do not show.
//! Covariances are rounded to ten digits instead: they are small where things are known well.

use nalgebra::{Matrix2, Matrix3};
use serde::Serializer;

/// `x` to nine decimals; zero has no sign.
pub fn rounded(x: f64) -> f64 {
    let scaled = x * 1e9;
    if scaled.abs() < 9e15 {
        libm::rint(scaled) / 1e9 + 0.0
    } else {
        x
    }
}

/// `x` to six decimals; zero has no sign.
pub fn micro(x: f64) -> f64 {
    let scaled = x * 1e6;
    if scaled.abs() < 9e15 {
        libm::rint(scaled) / 1e6 + 0.0
    } else {
        x
    }
}

/// A number with so many decimals; zero has no sign.
pub fn fixed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        _ => text,
    }
}

/// Serialises a rounded number.
///
/// # Errors
/// When the serializer fails.
pub fn number<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(rounded(*x))
}

/// Serialises a rounded number or null.
///
/// # Errors
/// When the serializer fails.
pub fn optional<S: Serializer>(x: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match x {
        Some(x) => number(x, serializer),
        None => serializer.serialize_none(),
    }
}

/// Digits of what a covariance says.
const DIGITS: usize = 10;
/// Digits that bring back every f64.
const ALL_DIGITS: usize = 17;

/// `x` to so many digits; zero has no sign.
fn significant(x: f64, digits: usize) -> f64 {
    let text = format!("{x:.*e}", digits.saturating_sub(1));
    text.parse().map_or(x, |rounded: f64| rounded + 0.0)
}

/// The rows of a covariance, rounded so that it stays one.
///
/// Of a line far from the origin, rho and theta are correlated but for what little the line moves
/// where it was seen: that is a difference of numbers which agree in many digits, so these are
/// kept, and ten more.
pub fn covariance(m: &Matrix2<f64>) -> [[f64; 2]; 2] {
    let left = m.determinant() / (m.m11 * m.m22);
    let digits = if left > 0.0 && left <= 1.0 {
        DIGITS + libm::ceil(-libm::log10(left)) as usize
    } else {
        ALL_DIGITS
    };
    let entry = |x| significant(x, digits.min(ALL_DIGITS));
    [[entry(m.m11), entry(m.m12)], [entry(m.m21), entry(m.m22)]]
}

/// The rows of a circle's covariance over (x, y, radius). How far away it is and how thick have nearly all of their
/// errors in common, so more digits are kept.
pub fn covariance_of_circle(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    let entry = |row, column| significant(m[(row, column)], ALL_DIGITS - 3);
    std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_has_no_sign() {
        assert_eq!(fixed(-0.04, 1), "0.0");
        assert_eq!(fixed(-0.06, 1), "-0.1");
        assert_eq!(fixed(f64::INFINITY, 1), "inf");
    }

    #[test]
    fn nine_decimals_and_no_negative_zero() {
        assert_eq!(rounded(1.234_567_890_4), 1.234_567_890);
        assert_eq!(rounded(-1e-12).to_bits(), 0.0_f64.to_bits());
        assert_eq!(rounded(1e12 + 0.5), 1e12 + 0.5);
        assert!(rounded(f64::NAN).is_nan());
    }

    #[test]
    fn a_covariance_keeps_ten_digits() {
        let m = Matrix2::new(1.234_567_890_123e-7, 1e-12, 1e-12, 4.0);
        assert_eq!(covariance(&m), [[1.234_567_890e-7, 1e-12], [1e-12, 4.0]]);
        assert_eq!(covariance(&Matrix2::zeros()), [[0.0; 2]; 2]);
    }

    #[test]
    fn the_covariance_of_a_line_far_from_the_origin_stays_one() {
        for far in [1.0, 1e3, 1e6, 1e7] {
            // Known to 1 mm and 1 mrad where it was seen.
            let world_from_local = Matrix2::new(1.0, far, 0.0, 1.0);
            let local = Matrix2::new(1e-6, 1e-8, 1e-8, 1e-6);
            let m = world_from_local * local * world_from_local.transpose();
            let [[a, b], [c, d]] = covariance(&m);
            let det = a * d - b * c;
            let expected = 1e-12 - 1e-16;
            assert!((det / expected - 1.0).abs() < 0.1, "{far}: {det}");
        }
    }
}
