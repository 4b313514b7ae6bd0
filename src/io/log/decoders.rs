//! One decoder for all channels of a definition, and no more definitions than a log needs.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::container::{Channel, Schema};
use super::decoder::Decoder;
use super::msg_schema::short;
use crate::core::legible::shortened;

/// The longest text that is read as a definition, bytes: `sensor_msgs` with all that it contains
/// takes 20 000, and parsed it takes many times its bytes.
const LONGEST_TEXT: usize = 256 << 10;

/// The longest set of protobuf descriptors, bytes: they come with all that they import.
const LONGEST_DESCRIPTORS: usize = 1 << 20;

/// Bytes of definitions that are parsed of a log, all together.
const MOST_TOGETHER: usize = 2 << 20;

/// A parser's complaint may quote what it complains of: longest word and whole, characters.
const COMPLAINT: (usize, usize) = (200, 1000);

/// Why a definition is not even parsed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
enum TooLong {
    /// By itself.
    #[error(
        "the definition of its messages is {bytes} bytes long; no more than {most} are read, and no message \
         of ranges or poses needs as many"
    )]
    Alone {
        /// Of this definition.
        bytes: usize,
        /// The limit.
        most: usize,
    },
    /// With those before it.
    #[error(
        "the definition of its messages is {bytes} bytes long, and with those of other channels longer \
         than the {MOST_TOGETHER} that are read of a log; leave other topics out with --range-topic and \
         --odom-topic"
    )]
    Together {
        /// Of this definition.
        bytes: usize,
    },
}

/// What tells one decoder from another: the channel's encoding, the type, and the schema, by where
/// it is held.
type Key = (String, String, Option<*const Schema>);

/// The decoders of a log.
#[derive(Debug, Default)]
pub struct Decoders {
    made: BTreeMap<Key, Result<Decoder, String>>,
    /// What keys point to is held, so that it stays where it is.
    schemas: Vec<Rc<Schema>>,
    /// Bytes of definitions parsed.
    parsed: usize,
}

impl Decoders {
    /// The decoder of a channel, see [`Decoder::of`].
    ///
    /// # Errors
    /// Why there is none and what would work, for a person.
    pub fn of(&mut self, channel: &Channel, type_name: &str) -> Result<Decoder, String> {
        let schema = &channel.schema;
        // Channels without a definition may each have an empty one of their own.
        let place = (!schema.data.is_empty()).then_some(Rc::as_ptr(schema));
        let key = (channel.encoding.clone(), short(type_name), place);
        if let Some(known) = self.made.get(&key) {
            return known.clone();
        }
        let made = match self.admit(channel) {
            Ok(()) => Decoder::of(channel, type_name)
                .map_err(|problem| shortened(&problem, COMPLAINT.0, COMPLAINT.1)),
            Err(refused) => Err(refused.to_string()),
        };
        if place.is_some() {
            self.schemas.push(Rc::clone(schema));
        }
        self.made.insert(key, made.clone());
        made
    }

    /// Refuses what would take too much memory or time.
    fn admit(&mut self, channel: &Channel) -> Result<(), TooLong> {
        let bytes = channel.schema.data.len();
        let most = match channel.encoding.as_str() {
            "json" => return Ok(()), // its schema is not read
            "protobuf" => LONGEST_DESCRIPTORS,
            _ => LONGEST_TEXT,
        };
        if bytes > most {
            return Err(TooLong::Alone { bytes, most });
        }
        let parsed = self.parsed.saturating_add(bytes);
        if parsed > MOST_TOGETHER {
            return Err(TooLong::Together { bytes });
        }
        self.parsed = parsed;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(encoding: &str, schema: &Rc<Schema>) -> Channel {
        Channel {
            id: 1,
            topic: "/t".into(),
            encoding: encoding.into(),
            schema: Rc::clone(schema),
        }
    }

    fn schema(encoding: &str, data: &[u8]) -> Rc<Schema> {
        Rc::new(Schema {
            name: "my_msgs/msg/Echo".into(),
            encoding: encoding.into(),
            data: data.into(),
        })
    }

    #[test]
    fn channels_of_one_definition_share_what_it_was_parsed_to() {
        let mut decoders = Decoders::default();
        let [one, other] = [b"uint8 a", b"uint8 b"].map(|text| schema("ros2msg", text));
        for _ in 0..2000 {
            decoders.of(&channel("cdr", &one), &one.name).unwrap();
        }
        assert_eq!((decoders.parsed, decoders.made.len()), (7, 1));
        let decoder = decoders.of(&channel("cdr", &other), &other.name).unwrap();
        assert_eq!((decoders.parsed, decoders.made.len()), (14, 2));
        let value = decoder.decode(&[0, 1, 0, 0, 9]).unwrap();
        assert_eq!(value.number("b"), Ok(9.0));
        // Nor is one that cannot be parsed tried again.
        let broken = schema("ros2msg", b"\xff");
        for _ in 0..3 {
            assert!(decoders.of(&channel("cdr", &broken), &broken.name).is_err());
        }
        assert_eq!(decoders.parsed, 15);
    }

    #[test]
    fn a_definition_longer_than_any_is_not_parsed() {
        let cases = [
            ("cdr", "ros2msg", LONGEST_TEXT),
            ("ros1", "ros1msg", LONGEST_TEXT),
            ("protobuf", "protobuf", LONGEST_DESCRIPTORS),
        ];
        for (encoding, schema_encoding, most) in cases {
            let mut decoders = Decoders::default();
            let long = schema(schema_encoding, &vec![b'#'; most + 1]);
            let refused = decoders.of(&channel(encoding, &long), &long.name);
            let said = refused.unwrap_err();
            assert!(said.contains(&format!("no more than {most}")), "{said}");
            assert_eq!(decoders.parsed, 0, "{encoding}");
        }
    }

    #[test]
    fn no_number_of_definitions_is_parsed_without_end() {
        let mut decoders = Decoders::default();
        let comment = vec![b'#'; 100_000];
        let outcomes: Vec<bool> = (0..30)
            .map(|_| {
                let schema = schema("ros2msg", &comment);
                let outcome = decoders.of(&channel("cdr", &schema), &schema.name);
                outcome.is_ok()
            })
            .collect();
        let read = MOST_TOGETHER / comment.len();
        assert!(outcomes[..read].iter().all(|made| *made), "{outcomes:?}");
        assert!(outcomes[read..].iter().all(|made| !made), "{outcomes:?}");
        let json = schema("jsonschema", &vec![b' '; MOST_TOGETHER]);
        assert!(decoders.of(&channel("json", &json), &json.name).is_ok());
    }
}
