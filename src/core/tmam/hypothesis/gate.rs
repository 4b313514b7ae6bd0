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
        let z = where_it_falls_to(exceeded, |z| libm::erfc(z / SQRT_2) / 2.0);
        Self { with_one, z }
    }

    /// The gate, as chi2 with one degree of freedom, that would just let through this chi2 with
    /// `freedom` degrees.
    pub fn let_through(chi2: f64, freedom: usize) -> f64 {
        if freedom <= 1 || chi2.is_infinite() {
            return chi2;
        }
        let n = freedom as f64;
        let spread = 2.0 / (9.0 * n);
        let z = (libm::cbrt(chi2 / n) - 1.0 + spread) / spread.sqrt();
        let exceeded = libm::erfc(z / SQRT_2) / 2.0;
        if exceeded <= 0.0 {
            return f64::INFINITY;
        }
        where_it_falls_to(exceeded, |gate| libm::erfc((gate.max(0.0) / 2.0).sqrt()))
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

/// Where a falling function passes a value: by bisection, since there is no closed form.
fn where_it_falls_to(value: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-40.0, 1500.0);
    for _ in 0..80 {
        let middle = (low + high) / 2.0;
        if function(middle) > value {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
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

    #[test]
    fn what_a_gate_just_lets_through_leads_back_to_it() {
        for gate in [2.71, 6.63, 30.0] {
            for freedom in [1, 2, 7, 40] {
                let chi2 = Gate::new(gate).at(freedom);
                let back = Gate::let_through(chi2, freedom);
                assert!((back - gate).abs() < 1e-6, "{gate} {freedom}: {back}");
            }
        }
    }
}
