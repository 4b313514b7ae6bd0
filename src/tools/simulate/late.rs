//! A stretch of the drive in which the ranges come late, as they do while a computer is busy.

use std::str::FromStr;

use super::error::SimulateError;

/// Readings of a stretch of the drive that are stamped late.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LateStretch {
    from: f64,
    to: f64,
    delay: f64,
}

impl LateStretch {
    /// Checks that some of the readings, the last one so many nanoseconds after the start, are in it.
    ///
    /// # Errors
    /// Where none is.
    pub fn validate(&self, last_ns: i64) -> Result<(), SimulateError> {
        let (from, last) = (self.from, last_ns as f64 * 1e-9);
        let refused = SimulateError::NothingLate { from, last };
        (from <= last).then_some(()).ok_or(refused)
    }

    /// How much later than it is taken a reading is stamped, nanoseconds.
    pub fn delay_ns(&self, after_ns: i64) -> i64 {
        let after = after_ns as f64 * 1e-9;
        if (self.from..=self.to).contains(&after) {
            libm::rint(self.delay * 1e9) as i64
        } else {
            0
        }
    }
}

impl FromStr for LateStretch {
    type Err = SimulateError;

    /// `FROM:TO:DELAY`, all in seconds.
    fn from_str(text: &str) -> Result<Self, SimulateError> {
        let refused = || SimulateError::LateText(text.to_owned());
        let numbers: Option<Vec<f64>> = text.split(':').map(|part| part.parse().ok()).collect();
        let Some(&[from, to, delay]) = numbers.as_deref() else {
            return Err(refused());
        };
        let is_stretch = 0.0 <= from && from < to && to.is_finite();
        // A stamp is at most a minute off: more is another fault.
        if is_stretch && 0.0 < delay && delay <= 60.0 {
            Ok(Self { from, to, delay })
        } else {
            Err(refused())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_of_the_stretch_are_late_and_no_others() {
        let late: LateStretch = "2:3.5:0.25".parse().unwrap();
        let delays = [1_999_999_999, 2_000_000_000, 3_500_000_000, 3_500_000_001];
        let delays = delays.map(|after_ns| late.delay_ns(after_ns));
        assert_eq!(delays, [0, 250_000_000, 250_000_000, 0]);
        assert!(late.validate(2_000_000_000).is_ok());
        let refused = late.validate(1_900_000_000).unwrap_err().to_string();
        assert!(refused.contains("later than 1.9 s"), "{refused}");
    }

    #[test]
    fn what_is_no_stretch_is_refused() {
        for text in [
            "",
            "1:2",
            "1:2:3:4",
            "2:1:0.1",
            "-1:2:0.1",
            "1:2:0",
            "1:inf:0.1",
            "1:2:61",
            "a:2:0.1",
            "1:a:2:0.1",
            "1:2:nan",
        ] {
            let refused = text.parse::<LateStretch>().unwrap_err().to_string();
            assert!(refused.contains("FROM:TO:DELAY"), "{text}: {refused}");
        }
    }
}
