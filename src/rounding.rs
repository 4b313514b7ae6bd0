//! Numbers as files hold them: rounded to 1e-9, so that the last bits of a sum do not show.

use nalgebra::Matrix2;
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

/// The rows of a matrix, rounded.
pub fn rows(m: &Matrix2<f64>) -> [[f64; 2]; 2] {
    [
        [rounded(m.m11), rounded(m.m12)],
        [rounded(m.m21), rounded(m.m22)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_decimals_and_no_negative_zero() {
        assert_eq!(rounded(1.234_567_890_4), 1.234_567_890);
        assert_eq!(rounded(-1e-12).to_bits(), 0.0_f64.to_bits());
        assert_eq!(rounded(1e12 + 0.5), 1e12 + 0.5);
        assert!(rounded(f64::NAN).is_nan());
    }
}
