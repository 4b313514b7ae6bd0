//! JSON messages. Their schema, where there is one, adds nothing to what the text says itself.

use std::rc::Rc;

use super::value::Value;

/// Decodes one message. Names for numbers that JSON does not have, as Python writes them (`NaN`,
/// `Infinity`, `-Infinity`), are read too.
///
/// # Errors
/// Text that is not JSON.
pub fn decode(message: &[u8]) -> Result<Value, serde_json::Error> {
    let parsed: Result<serde_json::Value, _> = serde_json::from_slice(message);
    let json = match parsed {
        Ok(json) => json,
        Err(error) => match with_quoted_numbers(message) {
            Some(quoted) => serde_json::from_slice(&quoted).map_err(|_| error)?,
            None => return Err(error),
        },
    };
    Ok(value(json))
}

fn value(json: serde_json::Value) -> Value {
    match json {
        serde_json::Value::Null => Value::Null,
        serde_json::Value::Bool(truth) => Value::Int(truth.into()),
        serde_json::Value::Number(number) => number.as_i64().map_or_else(
            || Value::Float(number.as_f64().unwrap_or(f64::NAN)),
            Value::Int,
        ),
        serde_json::Value::String(text) => Value::Text(text),
        serde_json::Value::Array(items) => array(items),
        serde_json::Value::Object(fields) => Value::Message(
            fields
                .into_iter()
                .map(|(name, field)| (Rc::from(name), value(field)))
                .collect(),
        ),
    }
}

fn array(items: Vec<serde_json::Value>) -> Value {
    let numbers: Option<Vec<f64>> = items.iter().map(serde_json::Value::as_f64).collect();
    numbers.map_or_else(
        || Value::List(items.into_iter().map(value).collect()),
        Value::Numbers,
    )
}

/// The text with bare `NaN`, `Infinity` and `-Infinity` in quotes; `None` where it has none.
fn with_quoted_numbers(message: &[u8]) -> Option<Vec<u8>> {
    const NAMES: [&[u8]; 3] = [b"NaN", b"-Infinity", b"Infinity"];
    let mut quoted = Vec::with_capacity(message.len() + 16);
    let (mut in_text, mut found, mut rest) = (false, false, message);
    while let Some((byte, behind)) = rest.split_first() {
        let name = NAMES.into_iter().find(|name| rest.starts_with(name));
        rest = match (in_text, byte, name) {
            (false, _, Some(name)) => {
                found = true;
                quoted.push(b'"');
                quoted.extend_from_slice(name);
                quoted.push(b'"');
                rest.get(name.len()..)?
            }
            (true, b'\\', _) => {
                let (escaped, behind) = behind.split_first()?;
                quoted.extend_from_slice(&[*byte, *escaped]);
                behind
            }
            (_, byte, _) => {
                in_text ^= *byte == b'"';
                quoted.push(*byte);
                behind
            }
        };
    }
    found.then_some(quoted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_numbers_and_null() {
        let value = decode(br#"{"a":[1,2.5,null],"b":[1,2],"c":[],"d":{"e":true}}"#).unwrap();
        assert_eq!(value.distances("a"), Ok(vec![1.0, 2.5, f64::INFINITY]));
        assert_eq!(value.get("b"), Some(&Value::Numbers(vec![1.0, 2.0])));
        assert_eq!(value.list("c"), Ok(&[][..]));
        assert_eq!(value.number("d.e"), Ok(1.0));
    }

    #[test]
    fn pythons_numbers_are_read_and_texts_left_alone() {
        let value = decode(br#"{"a":[NaN,Infinity,-Infinity],"b":"\"NaN"}"#).unwrap();
        let numbers = value.distances("a").unwrap();
        assert!(numbers[0].is_nan());
        assert_eq!(numbers[1..], [f64::INFINITY, f64::NEG_INFINITY]);
        assert_eq!(value.text("b"), Ok("\"NaN"));
    }

    #[test]
    fn what_is_not_json_is_refused() {
        for text in ["", "{", "[1,", "{\"a\":NaN", "\"\\", "nil"] {
            assert!(decode(text.as_bytes()).is_err(), "{text}");
        }
        let deep = "[".repeat(100_000);
        assert!(decode(deep.as_bytes()).is_err());
    }
}
