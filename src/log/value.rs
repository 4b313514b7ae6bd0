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
    /// An array of numbers.
    Numbers(Vec<f64>),
    /// An array of anything else.
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
        match self.get(path) {
            Some(Self::Float(x)) => Ok(*x),
            Some(Self::Int(n)) => Ok(*n as f64),
            _ => Err(missing(path, "a number")),
        }
    }

    /// The whole number at a path.
    ///
    /// # Errors
    /// When there is none.
    pub fn integer(&self, path: &str) -> Result<i64, FieldError> {
        match self.get(path) {
            Some(Self::Int(n)) => Ok(*n),
            _ => Err(missing(path, "a whole number")),
        }
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

    /// The list at a path.
    ///
    /// # Errors
    /// When there is none.
    pub fn list(&self, path: &str) -> Result<&[Self], FieldError> {
        match self.get(path) {
            Some(Self::List(items)) => Ok(items),
            _ => Err(missing(path, "a list")),
        }
    }
}

fn missing(path: &str, expected: &'static str) -> FieldError {
    FieldError {
        path: path.to_owned(),
        expected,
    }
}
