//! The fields that are wanted of a message, whatever it was encoded in.
//!
//! A field has a path: names joined by dots. Behind an array a path goes on into each of its elements, so
//! that the field is a column; `[]` may stand behind the array's name and changes nothing, `[1]` chooses its
//! second element.

use std::borrow::Cow;

use crate::core::legible::name;

/// What stands at one path.
#[derive(Debug, Clone, PartialEq)]
pub enum Value<'m> {
    Nothing,
    /// JSON's null.
    Null,
    /// A message that is there; what is in it has paths of its own.
    Message,
    /// Of seconds and nanoseconds: nanoseconds.
    Time(i64),
    Int(i64),
    Float(f64),
    Text(Cow<'m, str>),
    Bytes(&'m [u8]),
    Numbers(Vec<f64>),
    /// An array of anything else, or a column.
    List(Vec<Value<'m>>),
}

/// A field that a message lacks or has as something else.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("field `{path}` is not there as {expected}")]
pub struct FieldError {
    pub path: String,
    pub expected: &'static str,
}

/// Where a wanted field stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    pub text: String,
    /// The element that it chooses of an array.
    element: Option<usize>,
}

impl From<String> for Path {
    fn from(text: String) -> Self {
        Self {
            element: element_of(&text),
            text,
        }
    }
}

/// The wanted fields of one message.
#[derive(Debug, Clone, PartialEq)]
pub struct Fields<'p, 'm> {
    pub paths: &'p [Path],
    /// One for each path.
    pub values: Vec<Value<'m>>,
}

impl<'m> Fields<'_, 'm> {
    /// The first so many of them.
    pub fn all<const N: usize>(&self) -> [Field<'_, 'm>; N] {
        let mut all = self.paths.iter().zip(&self.values);
        std::array::from_fn(|_| match all.next() {
            None => Field::NOTHING,
            Some((path, value)) => Field {
                path: &path.text,
                value: match path.element {
                    Some(element) => Cow::Owned(value.element(element)),
                    None => Cow::Borrowed(value),
                },
            },
        })
    }
}

/// One field of a message.
#[derive(Debug, Clone)]
pub struct Field<'f, 'm> {
    pub path: &'f str,
    pub value: Cow<'f, Value<'m>>,
}

impl<'m> Field<'_, 'm> {
    /// What stands where a message has no more fields.
    const NOTHING: Self = Self {
        path: "",
        value: Cow::Owned(Value::Nothing),
    };

    pub fn is_there(&self) -> bool {
        *self.value != Value::Nothing
    }

    /// How many elements an array or a column has.
    pub fn count(&self) -> Option<usize> {
        match &*self.value {
            Value::Bytes(bytes) => Some(bytes.len()),
            Value::Numbers(numbers) => Some(numbers.len()),
            Value::List(items) => Some(items.len()),
            _ => None,
        }
    }

    /// What an element of a column has; what is no column is the same for all elements.
    pub fn at(&self, element: usize) -> Field<'_, 'm> {
        let value = match &*self.value {
            Value::Bytes(bytes) => bytes.get(element).map(|byte| Value::Int((*byte).into())),
            Value::Numbers(numbers) => numbers.get(element).copied().map(Value::Float),
            Value::List(items) => {
                return Field {
                    path: self.path,
                    value: items
                        .get(element)
                        .map_or(Cow::Owned(Value::Nothing), Cow::Borrowed),
                };
            }
            _ => return self.clone(),
        };
        Field {
            path: self.path,
            value: Cow::Owned(value.unwrap_or(Value::Nothing)),
        }
    }

    pub fn number(&self) -> Result<f64, FieldError> {
        self.value
            .as_number()
            .ok_or_else(|| self.missing("a number"))
    }

    pub fn finite(&self) -> Result<f64, FieldError> {
        let number = self.number()?;
        let finite = number.is_finite().then_some(number);
        finite.ok_or_else(|| self.missing("a finite number"))
    }

    /// Metres; null is no echo, which gives +inf.
    pub fn distance(&self) -> Result<f64, FieldError> {
        self.value
            .as_distance()
            .ok_or_else(|| self.missing("a distance"))
    }

    pub fn distances(&self) -> Result<Vec<f64>, FieldError> {
        let distances = match &*self.value {
            Value::Bytes(bytes) => Some(bytes.iter().map(|byte| f64::from(*byte)).collect()),
            Value::Numbers(numbers) => Some(numbers.clone()),
            Value::List(items) => items.iter().map(Value::as_distance).collect(),
            _ => None,
        };
        distances.ok_or_else(|| self.missing("an array of distances"))
    }

    pub fn text(&self) -> Result<&str, FieldError> {
        match &*self.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.missing("text")),
        }
    }

    /// The name of a frame, without a leading slash.
    pub fn frame(&self) -> Result<Cow<'m, str>, FieldError> {
        match &*self.value {
            Value::Text(Cow::Borrowed(text)) => Ok(name(text.trim_start_matches('/'))),
            _ => Ok(name(self.text()?.trim_start_matches('/'))
                .into_owned()
                .into()),
        }
    }

    /// Nanoseconds.
    pub fn time(&self) -> Result<i64, FieldError> {
        let time = self.value.as_time();
        time.ok_or_else(|| {
            self.missing("a time of seconds and nanoseconds, or one like 2015-01-01T00:00:00Z")
        })
    }

    /// Nanoseconds; 0 where the field is absent, as protobuf leaves out what is zero.
    pub fn time_or_zero(&self) -> Result<i64, FieldError> {
        if self.is_there() { self.time() } else { Ok(0) }
    }

    pub fn missing(&self, expected: &'static str) -> FieldError {
        FieldError {
            path: self.path.to_owned(),
            expected,
        }
    }
}

impl Value<'_> {
    /// One element of an array or a column; nothing of what is neither.
    fn element(&self, element: usize) -> Self {
        let found = match self {
            Self::Bytes(bytes) => bytes.get(element).map(|byte| Self::Int((*byte).into())),
            Self::Numbers(numbers) => numbers.get(element).copied().map(Self::Float),
            Self::List(items) => items.get(element).cloned(),
            _ => None,
        };
        found.unwrap_or(Self::Nothing)
    }

    /// JSON writers put infinities and NaN, and some put long integers, as text.
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Float(x) => Some(*x),
            Self::Int(n) => Some(*n as f64),
            Self::Text(text) => text.parse().ok(),
            _ => None,
        }
    }

    pub fn as_distance(&self) -> Option<f64> {
        match self {
            Self::Null => Some(f64::INFINITY),
            other => other.as_number(),
        }
    }

    pub fn as_integer(&self) -> Option<i64> {
        match self {
            Self::Int(n) => Some(*n),
            Self::Text(text) => text.parse().ok(),
            _ => None,
        }
    }

    /// Nanoseconds.
    pub fn as_time(&self) -> Option<i64> {
        match self {
            Self::Time(time) => Some(*time),
            // As protobuf's JSON has it.
            Self::Text(text) => {
                let time: jiff::Timestamp = text.parse().ok()?;
                i64::try_from(time.as_nanosecond()).ok()
            }
            _ => None,
        }
    }
}

/// The two parts of a time, as they are called in one encoding or another.
pub const SECONDS: [&str; 3] = ["sec", "secs", "seconds"];
pub const NANOSECONDS: [&str; 4] = ["nanosec", "nsec", "nsecs", "nanos"];

pub fn time_of(seconds: i64, nanoseconds: i64) -> i64 {
    let seconds = seconds.saturating_mul(1_000_000_000);
    seconds.saturating_add(nanoseconds)
}

/// Where a path goes on behind a field: `Some("")` where it ends there, `None` where it begins otherwise.
pub fn behind<'p>(path: &'p str, field: &str) -> Option<&'p str> {
    let rest = path.strip_prefix(field)?;
    let rest = match rest.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((element, rest)) if element.bytes().all(|digit| digit.is_ascii_digit()) => rest,
        _ => rest,
    };
    match rest.strip_prefix('.') {
        Some(rest) => Some(rest),
        None => rest.is_empty().then_some(""),
    }
}

/// The element that a path chooses of an array, as `position[1]` does.
fn element_of(path: &str) -> Option<usize> {
    let (_, behind) = path.split_once('[')?;
    behind.split_once(']')?.0.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_goes_on_behind_fields_and_arrays() {
        assert_eq!(behind("header.stamp", "header"), Some("stamp"));
        assert_eq!(behind("echoes[].range", "echoes"), Some("range"));
        assert_eq!(behind("ranges[]", "ranges"), Some(""));
        assert_eq!(behind("ranges_far", "ranges"), None);
        assert_eq!(behind("position[1]", "position"), Some(""));
        assert_eq!(behind("position[x]", "position"), None);
    }

    #[test]
    fn one_element_of_an_array_is_a_field_of_its_own() {
        let paths = ["position[1]", "position[3]", "x[0]"].map(|path| Path::from(path.to_owned()));
        let position = || Value::Numbers(vec![1.0, 2.0, 3.0]);
        let fields = Fields {
            paths: &paths,
            values: vec![position(), position(), Value::Float(1.0)],
        };
        let [second, fourth, of_none] = fields.all();
        assert_eq!(second.number(), Ok(2.0));
        assert!(!fourth.is_there() && !of_none.is_there());
    }

    #[test]
    fn null_is_no_echo_and_no_number() {
        let paths = ["range", "ranges", "text"].map(|path| Path::from(path.to_owned()));
        let fields = Fields {
            paths: &paths,
            values: vec![
                Value::Null,
                Value::List(vec![Value::Float(1.5), Value::Null]),
                Value::Text("-Infinity".into()),
            ],
        };
        let [range, ranges, text] = fields.all();
        assert_eq!(range.distance(), Ok(f64::INFINITY));
        assert_eq!(ranges.distances(), Ok(vec![1.5, f64::INFINITY]));
        assert_eq!(ranges.at(0).number(), Ok(1.5));
        assert!(!ranges.at(2).is_there());
        assert_eq!(text.number(), Ok(f64::NEG_INFINITY));
        assert!(range.number().is_err());
    }
}
