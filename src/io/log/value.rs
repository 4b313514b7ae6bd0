//! A decoded message, whatever it was encoded in: named fields, found by path.

use std::rc::Rc;

/// One decoded value.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Any number; integers beyond 2^53 keep their value in `Int`.
    Float(f64),
    /// A whole number.
    Int(i64),
    /// Text.
    Text(String),
    /// JSON's null.
    Null,
    /// An array of numbers, maybe empty.
    Numbers(Vec<f64>),
    /// An array of anything else, or an empty one.
    List(Vec<Value>),
    /// Named fields in their order.
    Message(Vec<(Rc<str>, Value)>),
}

/// A field that a message lacks or has as something else.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("field `{path}` is not there as {expected}")]
pub struct FieldError {
    /// Path of the field.
    pub path: String,
    /// What was looked for.
    pub expected: &'static str,
}

impl Value {
    /// The value at a dotted path.
    pub fn get(&self, path: &str) -> Option<&Self> {
        path.split('.').try_fold(self, |value, name| match value {
            Self::Message(fields) => fields
                .iter()
                .find_map(|(field, value)| (**field == *name).then_some(value)),
            _ => None,
        })
    }

    /// The number at a path.
    ///
    /// # Errors
    /// When there is none.
    pub fn number(&self, path: &str) -> Result<f64, FieldError> {
        self.get(path)
            .and_then(Self::as_number)
            .ok_or_else(|| missing(path, "a number"))
    }

    /// The distance at a path, metres: a number, or null for no echo, which gives +inf.
    ///
    /// # Errors
    /// When there is none.
    pub fn distance(&self, path: &str) -> Result<f64, FieldError> {
        self.get(path)
            .and_then(Self::as_distance)
            .ok_or_else(|| missing(path, "a distance"))
    }

    /// The distances at a path, metres; null is no echo, which gives +inf.
    ///
    /// # Errors
    /// When there is no array, or anything else in it.
    pub fn distances(&self, path: &str) -> Result<Vec<f64>, FieldError> {
        let distances = match self.get(path) {
            Some(Self::Numbers(numbers)) => Some(numbers.clone()),
            Some(Self::List(items)) => items.iter().map(Self::as_distance).collect(),
            _ => None,
        };
        distances.ok_or_else(|| missing(path, "an array of distances"))
    }

    /// The text at a path.
    ///
    /// # Errors
    /// When there is none.
    pub fn text(&self, path: &str) -> Result<&str, FieldError> {
        match self.get(path) {
            Some(Self::Text(text)) => Ok(text),
            _ => Err(missing(path, "text")),
        }
    }

    /// The time at a path, nanoseconds: every encoding has its own names for the two parts.
    ///
    /// # Errors
    /// When there is none.
    pub fn time(&self, path: &str) -> Result<i64, FieldError> {
        self.get(path).and_then(Self::as_time).ok_or_else(|| {
            missing(
                path,
                "a time of seconds and nanoseconds, or one like 2015-01-01T00:00:00Z",
            )
        })
    }

    /// The list at a path.
    ///
    /// # Errors
    /// When there is none.
    pub fn list(&self, path: &str) -> Result<&[Self], FieldError> {
        match self.get(path) {
            Some(Self::List(items)) => Ok(items),
            Some(Self::Numbers(numbers)) if numbers.is_empty() => Ok(&[]),
            _ => Err(missing(path, "a list")),
        }
    }

    /// This value as a number; JSON writers put infinities and NaN, and some put long integers,
    /// as text.
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Float(x) => Some(*x),
            Self::Int(n) => Some(*n as f64),
            Self::Text(text) => text.parse().ok(),
            _ => None,
        }
    }

    /// This value as a time, nanoseconds.
    pub fn as_time(&self) -> Option<i64> {
        // As protobuf's JSON has it.
        if let Self::Text(text) = self {
            let time: jiff::Timestamp = text.parse().ok()?;
            return i64::try_from(time.as_nanosecond()).ok();
        }
        let part = |names: &[&str]| names.iter().find_map(|name| self.get(name)?.as_integer());
        let seconds = part(&["sec", "secs", "seconds"])?;
        let nanoseconds = part(&["nanosec", "nsec", "nsecs", "nanos"])?;
        Some(
            seconds
                .saturating_mul(1_000_000_000)
                .saturating_add(nanoseconds),
        )
    }

    /// This value as a distance, metres: null is no echo, which is +inf.
    pub fn as_distance(&self) -> Option<f64> {
        match self {
            Self::Null => Some(f64::INFINITY),
            other => other.as_number(),
        }
    }

    /// This value as a whole number.
    pub fn as_integer(&self) -> Option<i64> {
        match self {
            Self::Int(n) => Some(*n),
            Self::Text(text) => text.parse().ok(),
            _ => None,
        }
    }
}

/// The error for a field that is not there as it should be.
pub fn missing(path: &str, expected: &'static str) -> FieldError {
    FieldError {
        path: path.to_owned(),
        expected,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(fields: &[(&str, Value)]) -> Value {
        let field = |(name, value): &(&str, Value)| (Rc::from(*name), value.clone());
        Value::Message(fields.iter().map(field).collect())
    }

    #[test]
    fn a_time_goes_by_many_names() {
        for (seconds, nanoseconds) in [
            ("sec", "nanosec"),
            ("sec", "nsec"),
            ("secs", "nsecs"),
            ("seconds", "nanos"),
        ] {
            let stamp = message(&[
                (seconds, Value::Int(2)),
                (nanoseconds, Value::Int(500_000_000)),
            ]);
            let message = message(&[("stamp", stamp)]);
            assert_eq!(message.time("stamp"), Ok(2_500_000_000));
        }
        let half = message(&[("stamp", message(&[("sec", Value::Int(2))]))]);
        assert!(half.time("stamp").is_err());
    }

    #[test]
    fn null_is_no_echo_and_no_number() {
        let message = message(&[
            ("range", Value::Null),
            ("ranges", Value::List(vec![Value::Float(1.5), Value::Null])),
            ("text", Value::Text("-Infinity".into())),
        ]);
        assert_eq!(message.distance("range"), Ok(f64::INFINITY));
        assert_eq!(message.distances("ranges"), Ok(vec![1.5, f64::INFINITY]));
        assert_eq!(message.number("text"), Ok(f64::NEG_INFINITY));
        assert!(message.number("range").is_err());
    }
}
