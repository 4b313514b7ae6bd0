//! JSON messages. Their schema, where there is one, adds nothing to what the text says itself.

use serde_json::Value as Json;

use super::value::{NANOSECONDS, Path, SECONDS, Value, time_of};

/// What stands at each path of a message. Names for numbers that JSON does not have, as Python writes them
/// (`NaN`, `Infinity`, `-Infinity`), are read too.
///
/// # Errors
/// Text that is not JSON.
pub fn decode(message: &[u8], paths: &[Path]) -> Result<Vec<Value<'static>>, serde_json::Error> {
    let parsed: Result<Json, _> = serde_json::from_slice(message);
    let json = match parsed {
        Ok(json) => json,
        Err(error) => match with_quoted_numbers(message) {
            Some(quoted) => serde_json::from_slice(&quoted).map_err(|_| error)?,
            None => return Err(error),
        },
    };
    let at = |path: &Path| match path.text.as_str() {
        "" => Value::Nothing,
        path => find(&json, path),
    };
    Ok(paths.iter().map(at).collect())
}

fn find(json: &Json, path: &str) -> Value<'static> {
    if path.is_empty() {
        return value(json);
    }
    if let Json::Array(items) = json {
        return Value::List(items.iter().map(|item| find(item, path)).collect());
    }
    let (name, rest) = path.split_once('.').unwrap_or((path, ""));
    let array = name
        .strip_suffix(']')
        .and_then(|name| name.rsplit_once('['));
    let name = array.map_or(name, |(name, _)| name);
    json.get(name)
        .map_or(Value::Nothing, |inner| find(inner, rest))
}

fn value(json: &Json) -> Value<'static> {
    match json {
        Json::Null => Value::Null,
        Json::Bool(truth) => Value::Int((*truth).into()),
        Json::Number(number) => number.as_i64().map_or_else(
            || Value::Float(number.as_f64().unwrap_or(f64::NAN)),
            Value::Int,
        ),
        Json::String(text) => Value::Text(text.clone().into()),
        Json::Array(items) => {
            let numbers: Option<Vec<f64>> = items.iter().map(Json::as_f64).collect();
            numbers.map_or_else(
                || Value::List(items.iter().map(value).collect()),
                Value::Numbers,
            )
        }
        Json::Object(fields) => {
            let part = |names: &[&str]| {
                let part = names.iter().find_map(|name| fields.get(*name))?;
                value(part).as_integer()
            };
            match (part(&SECONDS), part(&NANOSECONDS)) {
                (Some(seconds), Some(nanoseconds)) => Value::Time(time_of(seconds, nanoseconds)),
                _ => Value::Message,
            }
        }
    }
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

    fn values(text: &str, paths: &[&str]) -> Vec<Value<'static>> {
        let paths = paths.iter().map(|path| Path::from((*path).to_owned()));
        let paths: Vec<Path> = paths.collect();
        decode(text.as_bytes(), &paths).unwrap()
    }

    #[test]
    fn arrays_of_numbers_and_of_messages() {
        let text = r#"{"a":[1,2.5,null],"b":[1,2],"c":[],"d":{"e":true},"f":[{"x":1},{}]}"#;
        let paths = ["a", "b[]", "c", "d.e", "f.x", "d", "d.x"];
        let (one, null) = (Value::Int(1), Value::Null);
        let expected = [
            Value::List(vec![one.clone(), Value::Float(2.5), null]),
            Value::Numbers(vec![1.0, 2.0]),
            Value::Numbers(Vec::new()),
            one.clone(),
            Value::List(vec![one, Value::Nothing]),
            Value::Message,
            Value::Nothing,
        ];
        assert_eq!(values(text, &paths), expected);
    }

    #[test]
    fn a_time_goes_by_many_names() {
        for (seconds, nanoseconds) in [("sec", "nanosec"), ("secs", "nsecs"), ("seconds", "nanos")]
        {
            let text = format!(r#"{{"t":{{"{seconds}":"2","{nanoseconds}":500}}}}"#);
            assert_eq!(values(&text, &["t"]), [Value::Time(2_000_000_500)]);
        }
        assert_eq!(values(r#"{"t":{"sec":2}}"#, &["t"]), [Value::Message]);
    }

    #[test]
    fn pythons_numbers_are_read_and_texts_left_alone() {
        let found = values(r#"{"a":[NaN,-Infinity],"b":"\"NaN"}"#, &["a", "b"]);
        let Value::List(numbers) = &found[0] else {
            panic!()
        };
        assert!(numbers[0].as_number().unwrap().is_nan());
        assert_eq!(numbers[1].as_number(), Some(f64::NEG_INFINITY));
        assert_eq!(found[1], Value::Text("\"NaN".into()));
    }

    #[test]
    fn what_is_not_json_is_refused() {
        for text in ["", "{", "[1,", "{\"a\":NaN", "\"\\", "nil"] {
            assert!(decode(text.as_bytes(), &[]).is_err(), "{text}");
        }
        let deep = "[".repeat(100_000);
        assert!(decode(deep.as_bytes(), &[]).is_err());
    }
}
