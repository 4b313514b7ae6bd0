//! One decoder per encoding: from a channel's bytes to neutral values.

use super::container::Channel;
use super::ros2::Ros2Error;
use super::value::Value;
use super::{json, protobuf, ros1, ros2, standard};

/// Decodes the messages of one channel.
#[derive(Debug, Clone)]
pub enum Decoder {
    /// ROS 1.
    Ros1(ros1::Decoder),
    /// ROS 2.
    Ros2(ros2::Decoder),
    /// Protobuf.
    Protobuf(protobuf::Decoder),
    /// JSON.
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
    pub fn of(channel: &Channel, type_name: &str) -> Result<Self, String> {
        let schema = &channel.schema;
        let is_blank = schema.data.trim_ascii().is_empty();
        match (channel.encoding.as_str(), schema.encoding.as_str()) {
            ("cdr", "" | "ros2msg") if is_blank => {
                let definition =
                    standard::definition(type_name).ok_or_else(|| undefined(type_name))?;
                ros2::Decoder::new(type_name, definition.as_bytes())
                    .map(Self::Ros2)
                    .map_err(|error| error.to_string())
            }
            ("cdr", "ros2msg") => ros2::Decoder::new(&schema.name, &schema.data)
                .map(Self::Ros2)
                .map_err(|error| error.to_string()),
            ("ros1", "ros1msg") => ros1::Decoder::new(&schema.name, &schema.data)
                .map(Self::Ros1)
                .map_err(|error| error.to_string()),
            ("protobuf", "protobuf") => protobuf::Decoder::new(&schema.name, &schema.data)
                .map(Self::Protobuf)
                .map_err(|error| error.to_string()),
            ("json", _) => Ok(Self::Json),
            (encoding, schema) => Err(refusal(encoding, schema)),
        }
    }

    /// Decodes one message.
    ///
    /// # Errors
    /// What does not fit.
    pub fn decode(&self, message: &[u8]) -> Result<Value, DecodeError> {
        let damaged = |error: &dyn std::error::Error| DecodeError::Message(error.to_string());
        match self {
            Self::Ros1(decoder) => decoder.decode(message).map_err(|e| damaged(&e)),
            Self::Ros2(decoder) => decoder.decode(message).map_err(|error| match error {
                Ros2Error::Encapsulation(_) => DecodeError::Channel(error.to_string()),
                other => damaged(&other),
            }),
            Self::Protobuf(decoder) => decoder.decode(message).map_err(|e| damaged(&e)),
            Self::Json => json::decode(message)
                .map_err(|e| DecodeError::Message(format!("it is not JSON: {e}"))),
        }
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
    use std::rc::Rc;

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
        Decoder::of(&channel, name)
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
                let value = decoder.decode(&[&message[..], variance].concat()).unwrap();
                assert_eq!(value.number("range"), Ok(1.5), "{name}");
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
}
