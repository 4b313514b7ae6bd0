//! One decoder per encoding: from a channel's bytes to neutral values.

use super::container::Channel;
use super::value::Value;
use super::{json, protobuf, ros1, ros2};

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

impl Decoder {
    /// The decoder that fits a channel's encoding and schema.
    ///
    /// # Errors
    /// What the encoding is and what would work, for a person.
    pub fn of(channel: &Channel) -> Result<Self, String> {
        let schema = &channel.schema;
        match (channel.encoding.as_str(), schema.encoding.as_str()) {
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
    /// What does not fit, for a person.
    pub fn decode(&self, message: &[u8]) -> Result<Value, String> {
        match self {
            Self::Ros1(decoder) => decoder.decode(message).map_err(|e| e.to_string()),
            Self::Ros2(decoder) => decoder.decode(message).map_err(|e| e.to_string()),
            Self::Protobuf(decoder) => decoder.decode(message).map_err(|e| e.to_string()),
            Self::Json => json::decode(message).map_err(|e| format!("it is not JSON: {e}")),
        }
    }
}

/// What an encoding is that is not read, and what would work.
fn refusal(encoding: &str, schema: &str) -> String {
    format!(
        "encoding `{encoding}` with schema `{schema}` is not read; record as `cdr` with `ros2msg`"
    )
}
