//! A comparison that a rule makes, with both of its sides.

use crate::core::ties;

/// How a value must lie to a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// Greater.
    Above,
    /// Greater or equal.
    AtLeast,
    /// Less.
    Below,
    /// Less or equal.
    AtMost,
}

/// A comparison of something found with a bound that a parameter sets. SI units and radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// The parameter: a key of the configuration.
    pub key: &'static str,
    /// The left side.
    pub found: f64,
    /// How it must lie.
    pub relation: Relation,
    /// The right side.
    pub bound: f64,
}

impl Condition {
    /// Whether it holds.
    pub fn holds(&self) -> bool {
        self.relation.holds(self.found, self.bound)
    }

    /// What it has to spare; negative where it does not hold.
    pub fn room(&self) -> f64 {
        if self.relation.is_upward() {
            self.found - self.bound
        } else {
            self.bound - self.found
        }
    }
}

impl Relation {
    /// `>`, `>=`, `<` or `<=`.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Above => ">",
            Self::AtLeast => ">=",
            Self::Below => "<",
            Self::AtMost => "<=",
        }
    }

    /// Whether a value lies so; what may be equal to its bound is so within a millionth: metres,
    /// radians or seconds.
    pub fn holds(self, value: f64, bound: f64) -> bool {
        match self {
            Self::Above => value > bound,
            Self::AtLeast => ties::at_least(value, bound, ties::LENGTH),
            Self::Below => value < bound,
            Self::AtMost => ties::at_most(value, bound, ties::LENGTH),
        }
    }

    /// Whether a value gets there by growing.
    pub fn is_upward(self) -> bool {
        matches!(self, Self::Above | Self::AtLeast)
    }
}
