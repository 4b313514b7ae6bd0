//! ROS 1 messages: packed little-endian bytes read by the `ros1msg` definition that the file
//! carries.

use std::rc::Rc;

use re_ros_msg::message_spec::BuiltInType;

use super::msg_schema::{Dialect, Element, Kind, Plan, SchemaError};
use super::value::Value;

/// Why a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Ros1Error {
    /// The message ends early.
    #[error("a message ends {0} bytes before its definition does")]
    Short(usize),
    /// The message goes on after its last field.
    #[error("a message is {0} bytes longer than its definition says")]
    Long(usize),
    /// An array that claims more elements than the message has bytes for.
    #[error("an array claims {claimed} elements with {left} bytes left")]
    ArrayTooLong {
        /// Elements claimed.
        claimed: usize,
        /// Bytes left in the message.
        left: usize,
    },
}

/// Reads the messages of one definition.
#[derive(Debug, Clone)]
pub struct Decoder {
    root: Rc<Plan>,
}

impl Decoder {
    /// A decoder for messages of type `name`, defined by the text of a `ros1msg` schema.
    ///
    /// # Errors
    /// A definition that cannot be read.
    pub fn new(name: &str, definition: &[u8]) -> Result<Self, SchemaError> {
        let root = Plan::new(Dialect::Ros1, name, definition)?;
        Ok(Self { root })
    }

    /// Decodes one message.
    ///
    /// # Errors
    /// Bytes that do not fit the definition.
    pub fn decode(&self, message: &[u8]) -> Result<Value, Ros1Error> {
        let mut rest = message;
        let value = read_message(&mut rest, &self.root)?;
        match rest.len() {
            0 => Ok(value),
            left => Err(Ros1Error::Long(left)),
        }
    }
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8], Ros1Error> {
    let missing = count.saturating_sub(rest.len());
    let (taken, left) = rest
        .split_at_checked(count)
        .ok_or(Ros1Error::Short(missing))?;
    *rest = left;
    Ok(taken)
}

fn bytes<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], Ros1Error> {
    let missing = N.saturating_sub(rest.len());
    let (taken, left) = rest.split_first_chunk().ok_or(Ros1Error::Short(missing))?;
    *rest = left;
    Ok(*taken)
}

fn length(rest: &mut &[u8]) -> Result<usize, Ros1Error> {
    let length = u32::from_le_bytes(bytes(rest)?);
    Ok(usize::try_from(length).unwrap_or(usize::MAX))
}

fn read_message(rest: &mut &[u8], plan: &Plan) -> Result<Value, Ros1Error> {
    if plan.least_bytes == 0 {
        return Ok(Value::Message(Vec::new())); // it carries nothing, however deep it is
    }
    let mut fields = Vec::with_capacity(plan.fields.len());
    for (name, kind) in &plan.fields {
        let value = match kind {
            Kind::One(element) => read_one(rest, element)?,
            Kind::Many(element, count) => {
                let count = match count {
                    Some(count) => *count,
                    None => length(rest)?,
                };
                read_many(rest, element, count)?
            }
        };
        fields.push((Rc::clone(name), value));
    }
    Ok(Value::Message(fields))
}

fn read_many(rest: &mut &[u8], element: &Element, count: usize) -> Result<Value, Ros1Error> {
    // Before anything is reserved: a message is no longer than its bytes.
    if count.saturating_mul(element.least_bytes()) > rest.len() {
        return Err(Ros1Error::ArrayTooLong {
            claimed: count,
            left: rest.len(),
        });
    }
    if element.least_bytes() == 0 {
        return Ok(Value::List(Vec::new()));
    }
    let mut items = (0..count).map(|_| read_one(rest, element));
    if !element.is_number() {
        return Ok(Value::List(items.collect::<Result<_, _>>()?));
    }
    let numbers = items.try_fold(Vec::with_capacity(count), |mut numbers, item| {
        numbers.extend(item?.as_number());
        Ok::<_, Ros1Error>(numbers)
    })?;
    Ok(Value::Numbers(numbers))
}

fn read_one(rest: &mut &[u8], element: &Element) -> Result<Value, Ros1Error> {
    let basic = match element {
        Element::Nested(plan) => return read_message(rest, plan),
        Element::Basic(basic) => basic,
    };
    Ok(match basic {
        BuiltInType::Bool | BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 => {
            Value::Int(u8::from_le_bytes(bytes(rest)?).into())
        }
        BuiltInType::Int8 => Value::Int(i8::from_le_bytes(bytes(rest)?).into()),
        BuiltInType::Int16 => Value::Int(i16::from_le_bytes(bytes(rest)?).into()),
        BuiltInType::UInt16 => Value::Int(u16::from_le_bytes(bytes(rest)?).into()),
        BuiltInType::Int32 => Value::Int(i32::from_le_bytes(bytes(rest)?).into()),
        BuiltInType::UInt32 => Value::Int(u32::from_le_bytes(bytes(rest)?).into()),
        BuiltInType::Int64 => Value::Int(i64::from_le_bytes(bytes(rest)?)),
        BuiltInType::UInt64 => {
            let n = u64::from_le_bytes(bytes(rest)?);
            i64::try_from(n).map_or(Value::Float(n as f64), Value::Int)
        }
        BuiltInType::Float32 => Value::Float(f32::from_le_bytes(bytes(rest)?).into()),
        BuiltInType::Float64 => Value::Float(f64::from_le_bytes(bytes(rest)?)),
        BuiltInType::String(_) | BuiltInType::WString(_) => {
            let length = length(rest)?;
            let text = take(rest, length)?;
            Value::Text(String::from_utf8_lossy(text).into_owned())
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEFINITION: &str = "Header header\nbyte b\nfloat32[] ranges\nstring[2] names\n\
        duration d\n===\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id";

    fn message() -> Vec<u8> {
        let mut message = Vec::new();
        for n in [9_u32, 3, 500_000_000, 2] {
            message.extend(n.to_le_bytes());
        }
        message.extend(b"/f\xff"); // frame, then byte -1
        message.extend(2_u32.to_le_bytes());
        message.extend(1.5_f32.to_le_bytes());
        message.extend(f32::INFINITY.to_le_bytes());
        for name in [&b"ab"[..], b""] {
            message.extend((name.len() as u32).to_le_bytes());
            message.extend(name);
        }
        message.extend((-1_i32).to_le_bytes());
        message.extend(7_i32.to_le_bytes());
        message
    }

    #[test]
    fn fields_are_packed_without_gaps() {
        let decoder = Decoder::new("p/T", DEFINITION.as_bytes()).unwrap();
        let value = decoder.decode(&message()).unwrap();
        assert_eq!(value.time("header.stamp"), Ok(3_500_000_000));
        assert_eq!(value.text("header.frame_id"), Ok("/f"));
        assert_eq!(value.number("b"), Ok(-1.0));
        assert_eq!(value.distances("ranges"), Ok(vec![1.5, f64::INFINITY]));
        assert_eq!(value.list("names").unwrap().len(), 2);
        assert_eq!(value.time("d"), Ok(-999_999_993));
    }

    #[test]
    fn no_cut_of_a_message_is_read() {
        let decoder = Decoder::new("p/T", DEFINITION.as_bytes()).unwrap();
        let message = message();
        for length in 0..message.len() {
            assert!(decoder.decode(&message[..length]).is_err(), "{length}");
        }
        let longer = [&message[..], &[0]].concat();
        assert_eq!(decoder.decode(&longer), Err(Ros1Error::Long(1)));
    }

    #[test]
    fn a_claimed_length_is_held_against_the_bytes() {
        let decoder = Decoder::new("p/T", b"time[] t").unwrap();
        let refused = Ros1Error::ArrayTooLong {
            claimed: 2,
            left: 15,
        };
        let message = [&2_u32.to_le_bytes()[..], &[0; 15]].concat();
        assert_eq!(decoder.decode(&message), Err(refused));
    }
}
