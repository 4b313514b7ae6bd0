//! How large chi2 may be: one gate for any number of readings.

use std::f64::consts::SQRT_2;

/// The gate on chi2 that lets through the same share of true readings at every degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    with_one: f64,
    /// What a normal deviate exceeds as often as chi2 exceeds the gate.
    z: f64,
}

impl Gate {
    /// From the gate on chi2 with one degree of freedom.
    pub fn new(with_one: f64) -> Self {
        let exceeded = libm::erfc((with_one / 2.0).sqrt());
        // By bisection, since there is no closed form.
        let (mut low, mut high) = (-8.0, 38.0);
        for _ in 0..64 {
            let middle = (low + high) / 2.0;
            if libm::erfc(middle / SQRT_2) / 2.0 > exceeded {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self { with_one, z: low }
    }

    /// The gate for chi2 with `freedom` degrees of freedom: the approximation of Wilson and
    /// Hilferty, good to 3 % from two degrees on.
    pub fn at(&self, freedom: usize) -> f64 {
        if freedom <= 1 {
            return self.with_one;
        }
        let n = freedom as f64;
        let spread = 2.0 / (9.0 * n);
        let root = (1.0 - spread + self.z * spread.sqrt()).max(0.0);
        n * root * root * root
    }
}

#[cfg(test)]
mod tests {
    use super::Gate;

    #[test]
    fn the_gates_are_those_of_the_tables() {
        let in_a_hundred = Gate::new(6.635);
        for (freedom, tabled) in [
            (1, 6.635),
            (2, 9.210),
            (5, 15.086),
            (10, 23.209),
            (30, 50.892),
        ] {
            let found = in_a_hundred.at(freedom);
            assert!((found / tabled - 1.0).abs() < 0.03, "{freedom}: {found}");
        }
        let in_a_thousand = Gate::new(10.828);
        for (freedom, tabled) in [(2, 13.816), (5, 20.515), (10, 29.588)] {
            let found = in_a_thousand.at(freedom);
            assert!((found / tabled - 1.0).abs() < 0.03, "{freedom}: {found}");
        }
    }
}
