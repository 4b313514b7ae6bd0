//! What a parameter would have to be: a bound, and a value that a person can type.

use serde::{Serialize, Serializer, ser::SerializeStruct as _};

use crate::core::rounding::rounded;
use crate::io::config::keys::{Bounds, KEYS, Unit};

/// How a parameter must lie to a bound.
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

    /// Whether a value lies so.
    pub fn holds(self, value: f64, bound: f64) -> bool {
        match self {
            Self::Above => value > bound,
            Self::AtLeast => value >= bound,
            Self::Below => value < bound,
            Self::AtMost => value <= bound,
        }
    }

    /// Whether a value gets there by growing.
    pub fn is_upward(self) -> bool {
        matches!(self, Self::Above | Self::AtLeast)
    }
}

/// A parameter and the bound that it would have to pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// The key of the configuration.
    pub key: &'static str,
    /// On which side of the bound.
    pub relation: Relation,
    /// The bound, SI units or radians.
    pub bound: f64,
}

impl Need {
    /// A value with few digits on the right side of the bound, as it is written in the
    /// configuration; `None` where the key does not take any.
    pub fn value(&self) -> Option<f64> {
        let key = KEYS.iter().find(|key| key.path == self.key)?;
        let inside = |value: f64| match key.unit {
            Unit::Degrees => value.to_radians(),
            Unit::Plain => value,
        };
        let bound = match key.unit {
            Unit::Degrees => self.bound.to_degrees(),
            Unit::Plain => self.bound,
        };
        let allowed = |value: f64| match key.bounds {
            Bounds::Any => true,
            Bounds::Between(low, high) => value > low && value < high,
            Bounds::Above(low) => value > low,
            Bounds::AtLeast(low) => value >= low,
        };
        (2..=12).find_map(|decimals: u32| {
            let scale = 10_u64.pow(decimals) as f64;
            let value = if self.relation.is_upward() {
                (bound * scale).ceil() / scale
            } else {
                (bound * scale).floor() / scale
            };
            let right = self.relation.holds(inside(value), self.bound);
            // The next number of this many digits, where the bound itself is one of them.
            let next = if self.relation.is_upward() {
                value + 1.0 / scale
            } else {
                value - 1.0 / scale
            };
            let next = (next * scale).round() / scale;
            let value = if right { value } else { next };
            (value.is_finite() && allowed(value) && self.relation.holds(inside(value), self.bound))
                .then_some(value)
        })
    }

    /// The flag that sets such a value, as one types it.
    pub fn flag(&self) -> Option<String> {
        let value = self.value()?;
        Some(match self.key {
            "triple.alpha" => format!("--alpha {value}"),
            "triple.beta" => format!("--beta {value}"),
            "triple.gamma" => format!("--gamma {value}"),
            key => format!("--set {key}={value}"),
        })
    }
}

impl Serialize for Need {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut need = serializer.serialize_struct("Need", 4)?;
        need.serialize_field("key", self.key)?;
        need.serialize_field("relation", self.relation.sign())?;
        need.serialize_field("bound", &rounded(self.bound))?;
        need.serialize_field("flag", &self.flag())?;
        need.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn need(key: &'static str, relation: Relation, bound: f64) -> Need {
        Need {
            key,
            relation,
            bound,
        }
    }

    proptest! {
        #[test]
        fn what_one_types_lies_on_the_right_side(bound in 1e-6..0.999_f64, relation in prop::sample::select(vec![Relation::Above, Relation::AtLeast, Relation::Below, Relation::AtMost])) {
            for key in ["triple.alpha", "triple.gamma", "sequence.max_gap"] {
                let value = need(key, relation, bound).value().unwrap();
                let inside = if key == "triple.gamma" { value.to_radians() } else { value };
                prop_assert!(relation.holds(inside, bound), "{key} {value} {relation:?} {bound}");
            }
        }
    }

    #[test]
    fn few_digits_but_enough() {
        let flag = |key, relation, bound| need(key, relation, bound).flag();
        let gamma = flag("triple.gamma", Relation::Above, 11.304_f64.to_radians());
        assert_eq!(gamma.as_deref(), Some("--gamma 11.31"));
        // 1 is no alpha, so it takes more digits.
        let alpha = flag("triple.alpha", Relation::Above, 0.9993);
        assert_eq!(alpha.as_deref(), Some("--alpha 0.9994"));
        // The bound itself will not do.
        let beta = flag("triple.beta", Relation::Below, 2.5);
        assert_eq!(beta.as_deref(), Some("--beta 2.49"));
        let gap = flag("sequence.max_gap", Relation::AtLeast, 6.25);
        assert_eq!(gap.as_deref(), Some("--set sequence.max_gap=6.25"));
        assert_eq!(flag("triple.beta", Relation::Below, 1.0), None);
    }
}
