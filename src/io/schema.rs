//! The `schema` of the files this program writes: `tmam.features/1` is version 1 of the format
//! `tmam.features`.

use serde::Deserialize;

/// How a file's schema stands to the one that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// It is the same.
    Same,
    /// A later version of the same format.
    Newer,
    /// An earlier one.
    Older,
    /// Another format.
    Other,
}

/// Compares a file's schema with the known one.
pub fn relation(found: &str, known: &str) -> Relation {
    let split = |schema: &str| -> Option<(String, u32)> {
        let (name, version) = schema.rsplit_once('/')?;
        Some((name.to_owned(), version.parse().ok()?))
    };
    match (split(found), split(known)) {
        _ if found == known => Relation::Same,
        (Some((name, found)), Some((ours, known))) if name == ours => match found.cmp(&known) {
            std::cmp::Ordering::Less => Relation::Older,
            std::cmp::Ordering::Equal => Relation::Other,
            std::cmp::Ordering::Greater => Relation::Newer,
        },
        _ => Relation::Other,
    }
}

#[derive(Deserialize)]
struct Head {
    schema: Option<String>,
}

/// What the first JSON value of a file says that it is; `None` where it does not say.
///
/// # Errors
/// What is wrong with the JSON, in words for a person.
pub fn of_file(bytes: &[u8]) -> Result<Option<String>, String> {
    let mut values = serde_json::Deserializer::from_slice(bytes).into_iter::<Head>();
    match values.next() {
        Some(Ok(head)) => Ok(head.schema),
        Some(Err(error)) => Err(in_words(&error)),
        None => Err("it is empty".to_owned()),
    }
}

/// An error of the JSON reader; a file that merely stops is said to be cut off.
pub fn in_words(error: &serde_json::Error) -> String {
    if error.is_eof() {
        format!(
            "it is cut off: the JSON ends in the middle, at line {}",
            error.line()
        )
    } else {
        error.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_of_one_format_are_ordered_and_others_are_others() {
        for (found, relation) in [
            ("tmam.features/1", Relation::Older),
            ("tmam.features/2", Relation::Same),
            ("tmam.features/10", Relation::Newer),
            ("tmam.features/02", Relation::Other),
            ("tmam.features/x", Relation::Other),
            ("tmam.features", Relation::Other),
            ("tmam.golden/2", Relation::Other),
            ("", Relation::Other),
        ] {
            assert_eq!(
                super::relation(found, "tmam.features/2"),
                relation,
                "{found}"
            );
        }
    }

    #[test]
    fn the_schema_is_read_of_whatever_begins_with_an_object() {
        let schema = |text: &str| of_file(text.as_bytes());
        assert_eq!(
            schema(r#"{"schema": "a/1", "b": []}"#),
            Ok(Some("a/1".to_owned()))
        );
        assert_eq!(schema("{\"frame\": 1}\n{\"frame\": 2}\n"), Ok(None));
        assert!(
            schema(r#"{"schema": "a/1", "b": ["#)
                .unwrap_err()
                .contains("cut off")
        );
        assert!(schema(r#"{"schema": 7}"#).is_err());
    }
}
