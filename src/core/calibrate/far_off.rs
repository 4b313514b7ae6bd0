//! Coarse trials of what all sonars share: where that is far off, features no longer agree enough for
//! [`ranges`](super::ranges) to see which way it is.

use super::candidate::{Candidate, Estimated};
use super::parameter::{Parameter, Quantity, Whose};

/// What is tried first, up and down.
const STEPS: [(Parameter, f64); 11] = [
    (Parameter::RangeDelay, 0.1),
    (Parameter::ClockRate, 0.005),
    (Parameter::OdometryScale, 0.03),
    (Parameter::OdometryTurnScale, 0.02),
    (Parameter::Sonar(Whose::All, Quantity::X), 0.05),
    (Parameter::Sonar(Whose::All, Quantity::X), 0.1),
    (Parameter::Sonar(Whose::All, Quantity::Y), 0.05),
    (Parameter::Sonar(Whose::All, Quantity::Y), 0.1),
    (Parameter::Sonar(Whose::All, Quantity::RangeScale), 0.03),
    OFFSETS[0],
    OFFSETS[1],
];
/// Each sonar alone still agrees with itself: of all parameters this one shows least in what is explained.
const OFFSETS: [(Parameter, f64); 2] = [
    (Parameter::Sonar(Whose::All, Quantity::RangeOffset), 0.03),
    (Parameter::Sonar(Whose::All, Quantity::RangeOffset), 0.1),
];
/// What gains such a share of the most is followed.
const FOLLOWED: f64 = 0.5;
/// Steps beside the best one, as multiples of it.
const BESIDE: [f64; 6] = [1.3, 1.7, 2.0, 2.5, 3.0, 0.6];

/// What is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    All,
    /// An offset of all ranges alone.
    Offset,
}

impl Scope {
    fn steps(self) -> &'static [(Parameter, f64)] {
        match self {
            Self::All => &STEPS,
            Self::Offset => &OFFSETS,
        }
    }

    /// What is tried before anything is followed.
    pub fn trials(self) -> usize {
        self.steps().len() * 2
    }
}

/// What is worth a closer look, the best first. `gain` is what a value gains, in bits; `None` where it cannot be
/// told.
pub fn far_off(
    scope: Scope,
    gain: &mut dyn FnMut(Parameter, f64) -> Option<f64>,
) -> Vec<Candidate> {
    let mut found: Vec<(Parameter, f64, f64)> = Vec::new();
    for (parameter, step) in scope.steps().iter().copied() {
        let both =
            [step, -step].map(|value| (parameter, value, gain(parameter, value).unwrap_or(0.0)));
        found.extend(both.into_iter().filter(|one| one.2 > 0.0));
    }
    let most = |found: &[(Parameter, f64, f64)]| found.iter().map(|one| one.2).fold(0.0, f64::max);
    let least = FOLLOWED * most(&found);
    found.retain(|one| one.2 > least);
    for (parameter, value, gained) in &mut found {
        let step = *value;
        for multiple in BESIDE {
            let beside = multiple * step;
            let more = gain(*parameter, beside).unwrap_or(0.0);
            if more > *gained {
                (*value, *gained) = (beside, more);
            } else if multiple > 1.0 && *value != step {
                break;
            }
        }
    }
    found.sort_by(|a, b| b.2.total_cmp(&a.2));
    let least = FOLLOWED * most(&found);
    let followed = found.into_iter().filter(|one| one.2 > least);
    followed
        .map(|(parameter, value, gained)| Candidate {
            values: vec![Estimated {
                parameter,
                value,
                deviation: 0.0,
            }],
            gain: gained * std::f64::consts::LN_2,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_far_off_is_followed_to_where_it_gains_most() {
        let mut trials = 0;
        let found = far_off(Scope::All, &mut |parameter, value| {
            trials += 1;
            Some(match parameter {
                Parameter::RangeDelay => 1000.0 - 4000.0 * (value - 0.21).abs(),
                Parameter::OdometryScale => 700.0 - 20_000.0 * (value + 0.03).abs(),
                _ => -1.0,
            })
        });
        assert!(trials <= Scope::All.trials() * (1 + BESIDE.len()));
        let values: Vec<_> = found.iter().map(|one| one.values[0]).collect();
        assert_eq!(values.len(), 2);
        assert_eq!(values[0].parameter, Parameter::RangeDelay);
        assert!((values[0].value - 0.2).abs() < 1e-12);
        assert_eq!(values[1].parameter, Parameter::OdometryScale);
        assert!((values[1].value + 0.03).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_found_where_nothing_gains() {
        assert!(far_off(Scope::All, &mut |_, _| Some(-5.0)).is_empty());
        assert!(far_off(Scope::Offset, &mut |_, _| None).is_empty());
    }
}
