//! From the bytes of a channel's messages to the wanted fields: one decoder for all channels of a
//! definition, and no more definitions than a log needs.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::container::{Channel, Schema};
use super::ros::{DefinitionError, Dialect, Layout, RosError, short};
use super::value::{Fields, Path};
use super::{json, protobuf, ros};
use crate::core::legible::shortened;

/// Bytes of definitions that are parsed of a log, all together: `sensor_msgs` with all that it contains takes
/// 20 000, and parsed it takes many times its bytes.
const MOST_TOGETHER: usize = 2 << 20;

/// A parser's complaint may quote what it complains of: longest word and whole, characters.
const COMPLAINT: (usize, usize) = (200, 1000);

/// Takes the wanted fields of a channel's messages.
#[derive(Debug)]
pub struct Decoder {
    paths: Vec<Path>,
    encoding: Encoding,
}

#[derive(Debug)]
enum Encoding {
    Ros(ros::Decoder),
    Protobuf(protobuf::Decoder),
    Json,
}

/// Why a message cannot be decoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DecodeError {
    /// Its channel holds what is not read: what it is and what would work.
    Channel(String),
    /// It is damaged, or not what its schema says.
    Message(String),
}

impl Decoder {
    /// The decoder that fits a channel's encoding and schema; `type_name` is the type that its messages
    /// are of where no schema defines it.
    ///
    /// # Errors
    /// What the encoding is and what would work, for a person.
    pub fn of(channel: &Channel, type_name: &str, paths: Vec<String>) -> Result<Self, String> {
        let Schema {
            name,
            encoding,
            data,
        } = &*channel.schema;
        let is_blank = data.trim_ascii().is_empty();
        let ros = |dialect, layout: Result<Rc<Layout>, DefinitionError>| {
            let layout = layout.map_err(|error| error.to_string())?;
            Ok::<_, String>(Encoding::Ros(ros::Decoder::new(dialect, &layout, &paths)))
        };
        let encoding = match (channel.encoding.as_str(), encoding.as_str()) {
            ("cdr", "" | "ros2msg") if is_blank => {
                let standard = Layout::standard(type_name).ok_or_else(|| undefined(type_name))?;
                ros(Dialect::Ros2, standard)?
            }
            ("cdr", "ros2msg") => {
                let own = Layout::new(Dialect::Ros2, name, data);
                ros(
                    Dialect::Ros2,
                    own.or_else(|error| Layout::standard(type_name).unwrap_or(Err(error))),
                )?
            }
            ("ros1", "ros1msg") => ros(Dialect::Ros1, Layout::new(Dialect::Ros1, name, data))?,
            ("protobuf", "protobuf") => protobuf::Decoder::new(name, data, &paths)
                .map(Encoding::Protobuf)
                .map_err(|error| error.to_string())?,
            ("json", _) => Encoding::Json,
            (encoding, schema) => return Err(refusal(encoding, schema)),
        };
        Ok(Self {
            paths: paths.into_iter().map(Path::from).collect(),
            encoding,
        })
    }

    /// Takes the wanted fields of one message.
    ///
    /// # Errors
    /// What does not fit.
    pub fn decode<'m>(&self, message: &'m [u8]) -> Result<Fields<'_, 'm>, DecodeError> {
        let values = match &self.encoding {
            Encoding::Ros(decoder) => decoder.decode(message).map_err(|error| match error {
                RosError::Encapsulation(_) => DecodeError::Channel(error.to_string()),
                other => DecodeError::Message(other.to_string()),
            }),
            Encoding::Protobuf(decoder) => {
                (decoder.decode(message)).map_err(|error| DecodeError::Message(error.to_string()))
            }
            Encoding::Json => json::decode(message, &self.paths)
                .map_err(|error| DecodeError::Message(format!("it is not JSON: {error}"))),
        }?;
        Ok(Fields {
            paths: &self.paths,
            values,
        })
    }
}

/// What tells one decoder from another: the channel's encoding, the type, the schema by where it is held,
/// and the topic where the configuration describes the fields.
type Key = (String, String, Option<*const Schema>, Option<String>);

/// The decoders of a log.
#[derive(Debug, Default)]
pub struct Decoders {
    made: BTreeMap<Key, Result<Rc<Decoder>, String>>,
    /// What keys point to is held, so that it stays where it is.
    schemas: Vec<Rc<Schema>>,
    /// Bytes of definitions parsed.
    parsed: usize,
}

impl Decoders {
    /// The decoder of a channel, see [`Decoder::of`]; `paths` are those of the type, or else those that the
    /// configuration describes for the topic.
    ///
    /// # Errors
    /// Why there is none and what would work, for a person.
    pub fn of(
        &mut self,
        channel: &Channel,
        type_name: &str,
        is_described: bool,
        paths: Vec<String>,
    ) -> Result<Rc<Decoder>, String> {
        let schema = &channel.schema;
        // Channels without a definition may each have an empty one of their own.
        let place = (!schema.data.is_empty()).then_some(Rc::as_ptr(schema));
        let topic = is_described.then(|| channel.topic.clone());
        let key = (channel.encoding.clone(), short(type_name), place, topic);
        if let Some(known) = self.made.get(&key) {
            return known.clone();
        }
        let made = self.admit(channel).and_then(|()| {
            let made = Decoder::of(channel, type_name, paths);
            made.map_err(|problem| shortened(&problem, COMPLAINT.0, COMPLAINT.1))
        });
        let made = made.map(Rc::new);
        if place.is_some() {
            self.schemas.push(Rc::clone(schema));
        }
        self.made.insert(key, made.clone());
        made
    }

    /// Refuses what would take too much memory or time.
    fn admit(&mut self, channel: &Channel) -> Result<(), String> {
        let bytes = channel.schema.data.len();
        if channel.encoding == "json" {
            return Ok(()); // its schema is not read
        }
        if bytes > MOST_TOGETHER - self.parsed {
            return Err(format!(
                "the definition of its messages is {bytes} bytes long, and with those of other channels longer \
                 than the {MOST_TOGETHER} that are read of a log; leave other topics out with --range-topic and \
                 --odom-topic"
            ));
        }
        self.parsed += bytes;
        Ok(())
    }
}

/// What to do about a type that the file does not define.
pub fn undefined(type_name: &str) -> String {
    let what = if type_name.is_empty() {
        "the file does not say of what type the messages are. Record with".to_owned()
    } else {
        format!(
            "the file has no definition of `{type_name}`, and it is no standard type. Record with"
        )
    };
    format!(
        "{what} definitions (`ros2msg`), or name the standard type that it is in the configuration: \
         [channel.\"/topic\"] type = \"sensor_msgs/msg/Range\""
    )
}

/// What an encoding is that is not read, and what would work.
fn refusal(encoding: &str, schema: &str) -> String {
    match (encoding, schema) {
        ("cdr", "ros2idl" | "omgidl") => format!(
            "its type is defined in IDL (`{schema}`), which is not read; use the same type defined by a \
             .msg file, which is recorded as `ros2msg`"
        ),
        ("flatbuffer", _) => {
            "its messages are flatbuffers, which are not read; log Foxglove types as \
             `protobuf` or `json`"
                .to_owned()
        }
        ("cdr" | "ros1" | "protobuf", _) => format!(
            "encoding `{encoding}` with schema `{schema}` is not read; `cdr` goes with `ros2msg`, `ros1` \
             with `ros1msg`, `protobuf` with `protobuf`"
        ),
        _ => format!(
            "encoding `{encoding}` (schema `{schema}`) is not known; record as `cdr`, `ros1`, `protobuf` or \
             `json`"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::log::container::Schema;

    fn decoder(encoding: &str, schema: &str, name: &str, data: &[u8]) -> Result<Decoder, String> {
        let channel = Channel {
            id: 1,
            topic: "/t".into(),
            encoding: encoding.into(),
            schema: Rc::new(Schema {
                name: name.into(),
                encoding: schema.into(),
                data: data.into(),
            }),
        };
        Decoder::of(&channel, name, vec!["range".to_owned()])
    }

    #[test]
    fn a_standard_type_needs_no_definition() {
        let mut message = vec![0, 1, 0, 0];
        message.extend([1_u32, 2, 2].map(u32::to_le_bytes).concat());
        message.extend(b"f\0\0\0"); // the frame, radiation_type, padding
        message.extend([0.5_f32, 0.1, 4.0, 1.5].map(f32::to_le_bytes).concat());
        for name in ["sensor_msgs/msg/Range", "sensor_msgs::msg::dds_::Range_"] {
            let decoder = decoder("cdr", "", name, b"").unwrap();
            for variance in [&[][..], &[0; 4]] {
                let message = [&message[..], variance].concat();
                let fields = decoder.decode(&message).unwrap();
                let [range] = fields.all();
                assert_eq!(range.number(), Ok(1.5), "{name}");
            }
        }
    }

    #[test]
    fn what_is_not_read_says_what_would_work() {
        for (encoding, schema, name, says) in [
            ("cdr", "ros2idl", "sensor_msgs/msg/Range", "`ros2msg`"),
            ("cdr", "", "my_msgs/msg/Echo", "no standard type"),
            ("cdr", "", "", "[channel.\"/topic\"] type"),
            ("flatbuffer", "flatbuffer", "foxglove.LaserScan", "protobuf"),
            ("ros1", "", "sensor_msgs/Range", "`ros1msg`"),
            ("cbor", "", "sensor_msgs/Range", "not known"),
        ] {
            let refused = decoder(encoding, schema, name, b"").unwrap_err();
            assert!(refused.contains(says), "{encoding}: {refused}");
        }
    }

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

    fn of(
        decoders: &mut Decoders,
        encoding: &str,
        schema: &Rc<Schema>,
    ) -> Result<Rc<Decoder>, String> {
        let channel = channel(encoding, schema);
        decoders.of(&channel, &schema.name, false, vec!["b".to_owned()])
    }

    #[test]
    fn channels_of_one_definition_share_what_it_was_parsed_to() {
        let mut decoders = Decoders::default();
        let [one, other] = [b"uint8 a", b"uint8 b"].map(|text| schema("ros2msg", text));
        for _ in 0..2000 {
            of(&mut decoders, "cdr", &one).unwrap();
        }
        assert_eq!((decoders.parsed, decoders.made.len()), (7, 1));
        let decoder = of(&mut decoders, "cdr", &other).unwrap();
        assert_eq!((decoders.parsed, decoders.made.len()), (14, 2));
        let fields = decoder.decode(&[0, 1, 0, 0, 9]).unwrap();
        let [b] = fields.all();
        assert_eq!(b.number(), Ok(9.0));
        // Nor is one that cannot be parsed tried again.
        let broken = schema("ros2msg", b"\xff");
        for _ in 0..3 {
            assert!(of(&mut decoders, "cdr", &broken).is_err());
        }
        assert_eq!(decoders.parsed, 15);
    }

    #[test]
    fn no_number_of_definitions_is_parsed_without_end() {
        let mut decoders = Decoders::default();
        let comment = vec![b'#'; 100_000];
        let outcomes: Vec<bool> = (0..30)
            .map(|_| {
                let schema = schema("ros2msg", &comment);
                let outcome = of(&mut decoders, "cdr", &schema);
                outcome.is_ok()
            })
            .collect();
        let long = schema("ros2msg", &vec![b'#'; MOST_TOGETHER + 1]);
        assert!(of(&mut Decoders::default(), "cdr", &long).is_err());
        let read = MOST_TOGETHER / comment.len();
        assert!(outcomes[..read].iter().all(|made| *made), "{outcomes:?}");
        assert!(outcomes[read..].iter().all(|made| !made), "{outcomes:?}");
        let json = schema("jsonschema", &vec![b' '; MOST_TOGETHER]);
        assert!(of(&mut decoders, "json", &json).is_ok());
    }
}
