//! ROS 2 messages: `cdr` bytes read by the `ros2msg` definition that the file carries.

use std::rc::Rc;

use re_cdr::{BigEndian, CdrEndian, CdrReader, LittleEndian};
use re_ros_msg::message_spec::BuiltInType;

use super::msg_schema::{Dialect, Element, Kind, Plan, SchemaError};
use super::value::Value;

/// Why a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Ros2Error {
    /// A representation other than plain CDR.
    #[error(
        "its messages are {kind} (encapsulation {0:#06x}), not plain CDR, and are not read; record with XCDR1, \
         which ROS 2 uses unless told otherwise", kind = representation(*.0)
    )]
    Encapsulation(u16),
    /// The message ends early, or its bytes are not what the definition says.
    #[error("its bytes do not fit its definition: {0}")]
    Bytes(String),
    /// An array that claims more elements than the message has bytes for.
    #[error("an array claims {claimed} elements with {left} bytes left")]
    ArrayTooLong {
        /// Elements claimed.
        claimed: usize,
        /// Bytes left in the message.
        left: usize,
    },
    /// A kind of text that is encoded differently by every middleware.
    #[error("it has a field of type wstring, which is not read")]
    WideText,
}

/// Reads the messages of one definition.
#[derive(Debug, Clone)]
pub struct Decoder {
    root: Rc<Plan>,
}

impl Decoder {
    /// A decoder for messages of type `name`, defined by the text of a `ros2msg` schema.
    ///
    /// # Errors
    /// A definition that cannot be read.
    pub fn new(name: &str, definition: &[u8]) -> Result<Self, SchemaError> {
        let root = Plan::new(Dialect::Ros2, name, definition)?;
        Ok(Self { root })
    }

    /// Decodes one message.
    ///
    /// # Errors
    /// Bytes that do not fit the definition.
    pub fn decode(&self, message: &[u8]) -> Result<Value, Ros2Error> {
        let Some((header, body)) = message.split_first_chunk::<4>() else {
            return Err(Ros2Error::Bytes("no encapsulation header".to_owned()));
        };
        let [high, low, ..] = *header;
        match u16::from_be_bytes([high, low]) {
            0 => read_message(&mut CdrReader::<BigEndian>::new(body), &self.root),
            1 => read_message(&mut CdrReader::<LittleEndian>::new(body), &self.root),
            other => Err(Ros2Error::Encapsulation(other)),
        }
    }
}

fn read_message<B: CdrEndian>(
    reader: &mut CdrReader<'_, B>,
    plan: &Plan,
) -> Result<Value, Ros2Error> {
    if plan.least_bytes == 0 {
        return Ok(Value::Message(Vec::new())); // it carries nothing, however deep it is
    }
    if plan.fields.is_empty() {
        reader.read_u8().map_err(bytes)?; // an empty struct takes one byte
    }
    let mut fields = Vec::with_capacity(plan.fields.len());
    for (name, kind) in &plan.fields {
        let value = match kind {
            Kind::One(element) => read_one(reader, element)?,
            Kind::Many(element, count) => {
                let count = match count {
                    Some(count) => *count,
                    None => reader.read_sequence_length().map_err(bytes)?,
                };
                read_many(reader, element, count)?
            }
        };
        fields.push((Rc::clone(name), value));
    }
    Ok(Value::Message(fields))
}

fn read_many<B: CdrEndian>(
    reader: &mut CdrReader<'_, B>,
    element: &Element,
    count: usize,
) -> Result<Value, Ros2Error> {
    // Before anything is reserved: a message is no longer than its bytes.
    let left = reader.remaining();
    if count.saturating_mul(element.least_bytes()) > left {
        return Err(Ros2Error::ArrayTooLong {
            claimed: count,
            left,
        });
    }
    if element.least_bytes() == 0 {
        return Ok(Value::List(Vec::new()));
    }
    let mut items = (0..count).map(|_| read_one(reader, element));
    if !element.is_number() {
        return Ok(Value::List(items.collect::<Result<_, _>>()?));
    }
    let numbers = items.try_fold(Vec::with_capacity(count), |mut numbers, item| {
        numbers.extend(item?.as_number());
        Ok::<_, Ros2Error>(numbers)
    })?;
    Ok(Value::Numbers(numbers))
}

fn read_one<B: CdrEndian>(
    reader: &mut CdrReader<'_, B>,
    element: &Element,
) -> Result<Value, Ros2Error> {
    let basic = match element {
        Element::Nested(plan) => return read_message(reader, plan),
        Element::Basic(basic) => basic,
    };
    let value = match basic {
        BuiltInType::Bool | BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 => {
            reader.read_u8().map(|n| Value::Int(n.into()))
        }
        BuiltInType::Int8 => reader.read_i8().map(|n| Value::Int(n.into())),
        BuiltInType::Int16 => reader.read_i16().map(|n| Value::Int(n.into())),
        BuiltInType::UInt16 => reader.read_u16().map(|n| Value::Int(n.into())),
        BuiltInType::Int32 => reader.read_i32().map(|n| Value::Int(n.into())),
        BuiltInType::UInt32 => reader.read_u32().map(|n| Value::Int(n.into())),
        BuiltInType::Int64 => reader.read_i64().map(Value::Int),
        BuiltInType::UInt64 => reader
            .read_u64()
            .map(|n| i64::try_from(n).map_or(Value::Float(n as f64), Value::Int)),
        BuiltInType::Float32 => reader.read_f32().map(|x| Value::Float(x.into())),
        BuiltInType::Float64 => reader.read_f64().map(Value::Float),
        BuiltInType::String(_) => reader.read_string().map(Value::Text),
        BuiltInType::WString(_) => return Err(Ros2Error::WideText),
    };
    value.map_err(bytes)
}

/// What an encapsulation stands for.
fn representation(encapsulation: u16) -> &'static str {
    match encapsulation {
        2 | 3 => "a parameter list of XCDR1",
        6..=11 => "XCDR2",
        _ => "in an unknown representation",
    }
}

fn bytes(error: re_cdr::Error) -> Ros2Error {
    Ros2Error::Bytes(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claimed_length_is_held_against_the_bytes() {
        let decoder = Decoder::new("p/msg/T", b"float64[] x").unwrap();
        let message = [&[0, 1, 0, 0][..], &1000_u32.to_le_bytes(), &[0; 8]].concat();
        let refused = Ros2Error::ArrayTooLong {
            claimed: 1000,
            left: 8,
        };
        assert_eq!(decoder.decode(&message), Err(refused));
    }

    #[test]
    fn what_carries_nothing_is_not_repeated() {
        // Three levels of a million elements that take no byte.
        let text = "A[1000000] a\nuint8 n\n===\nMSG: p/A\nB[1000000] b\n===\nMSG: p/B\nuint8[0] x";
        let decoder = Decoder::new("p/msg/T", text.as_bytes()).unwrap();
        let value = decoder.decode(&[0, 1, 0, 0, 7]).unwrap();
        assert_eq!(value.number("n"), Ok(7.0));
    }

    #[test]
    fn other_representations_are_named() {
        let decoder = Decoder::new("p/msg/T", b"uint8 n").unwrap();
        let refused = decoder.decode(&[0, 7, 0, 0, 7]).unwrap_err();
        assert!(refused.to_string().contains("XCDR2"), "{refused}");
        assert!(refused.to_string().contains("0x0007"), "{refused}");
    }
}
