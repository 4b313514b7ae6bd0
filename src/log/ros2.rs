//! ROS 2 messages: `cdr` bytes read by the `ros2msg` definition that the file carries.

use std::collections::BTreeMap;
use std::rc::Rc;

use re_cdr::{BigEndian, CdrEndian, CdrReader, LittleEndian};
use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{
    ArraySize, BuiltInType, ComplexType, MessageSpecification, Type, message_package,
};

use super::value::Value;

/// Types nested deeper than this are refused.
const MAX_DEPTH: usize = 32;

/// Why a definition or a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Ros2Error {
    /// The definition is not one.
    #[error("its definition cannot be read: {0}")]
    Definition(String),
    /// A type that the definition uses and does not contain.
    #[error("its definition uses `{0}` and does not contain it")]
    UnknownType(String),
    /// Types that contain themselves, or nest beyond any use.
    #[error("its types are nested more than {MAX_DEPTH} deep")]
    TooDeep,
    /// A representation other than plain CDR.
    #[error("its messages are not plain CDR (encapsulation {0:#06x}); record with XCDR1")]
    Encapsulation(u16),
    /// The message ends early, or its bytes are not what the definition says.
    #[error("its bytes do not fit its definition: {0}")]
    Bytes(String),
    /// An array that claims more elements than the message has bytes.
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

/// A message type with all its references resolved.
#[derive(Debug)]
struct Plan {
    fields: Vec<(Rc<str>, Kind)>,
}

#[derive(Debug)]
enum Kind {
    One(Element),
    /// `None`: as many as the message says.
    Many(Element, Option<usize>),
}

#[derive(Debug)]
enum Element {
    Basic(BuiltInType),
    Nested(Rc<Plan>),
}

impl Decoder {
    /// A decoder for messages of type `name`, defined by the text of a `ros2msg` schema.
    ///
    /// # Errors
    /// A definition that cannot be read.
    pub fn new(name: &str, definition: &[u8]) -> Result<Self, Ros2Error> {
        let text =
            std::str::from_utf8(definition).map_err(|e| Ros2Error::Definition(e.to_string()))?;
        let schema = MessageSchema::parse(&short(name), &without_values(text))
            .map_err(|e| Ros2Error::Definition(format!("{e:#}")))?;
        let types: BTreeMap<String, &MessageSpecification> = schema
            .dependencies
            .iter()
            .map(|spec| (short(&spec.name), spec))
            .collect();
        let root = plan(&schema.spec, &types, &mut BTreeMap::new(), 0)?;
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
        match u16::from_be_bytes([header[0], header[1]]) {
            0 => read_message(&mut CdrReader::<BigEndian>::new(body), &self.root),
            1 => read_message(&mut CdrReader::<LittleEndian>::new(body), &self.root),
            other => Err(Ros2Error::Encapsulation(other)),
        }
    }
}

/// `package/Type` for `package/msg/Type`.
fn short(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// Drops the constants and default values of a definition: they are not in the bytes, not all of their
/// forms (hexadecimal numbers) can be parsed, and a default of a single quote stops the parser for good.
fn without_values(text: &str) -> String {
    let is_constant = |line: &str| {
        let mut words = line.trim().splitn(2, char::is_whitespace);
        let rest = words.nth(1).unwrap_or_default().trim_start();
        let name = rest.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
        name.len() < rest.len() && name.trim_start().starts_with('=')
    };
    text.lines()
        .filter(|line| !is_constant(line))
        // Type and name, or the head of another definition.
        .map(|line| {
            let words: Vec<&str> = line.split_whitespace().take(2).collect();
            words.join(" ")
        })
        .collect::<Vec<_>>()
        .join("\n")
}

/// Resolves a type and all that it contains; `done` keeps each type's plan.
fn plan(
    spec: &MessageSpecification,
    types: &BTreeMap<String, &MessageSpecification>,
    done: &mut BTreeMap<String, Rc<Plan>>,
    depth: usize,
) -> Result<Rc<Plan>, Ros2Error> {
    if depth > MAX_DEPTH {
        return Err(Ros2Error::TooDeep);
    }
    let mut fields = Vec::with_capacity(spec.fields.len());
    for field in &spec.fields {
        let mut element = |ty: &Type| match ty {
            Type::BuiltIn(basic) => Ok(Element::Basic(basic.clone())),
            Type::Complex(complex) => {
                let name = resolve(spec, complex);
                if let Some(known) = done.get(&name) {
                    return Ok(Element::Nested(Rc::clone(known)));
                }
                let inner = types
                    .get(&name)
                    .ok_or_else(|| Ros2Error::UnknownType(name.clone()))?;
                let inner = plan(inner, types, done, depth + 1)?;
                done.insert(name, Rc::clone(&inner));
                Ok(Element::Nested(inner))
            }
            Type::Array { .. } => Err(Ros2Error::Definition("an array of arrays".to_owned())),
        };
        let kind = match &field.ty {
            Type::Array { ty, size } => {
                let count = match size {
                    ArraySize::Fixed(count) => Some(*count),
                    ArraySize::Bounded(_) | ArraySize::Unbounded => None,
                };
                Kind::Many(element(ty)?, count)
            }
            single => Kind::One(element(single)?),
        };
        fields.push((Rc::from(field.name.as_str()), kind));
    }
    Ok(Rc::new(Plan { fields }))
}

/// The full name of a type that `scope` refers to.
fn resolve(scope: &MessageSpecification, complex: &ComplexType) -> String {
    match complex {
        ComplexType::Absolute { package, name } => short(&format!("{package}/{name}")),
        ComplexType::Relative { name } => match message_package(&scope.name) {
            Some(package) => format!("{package}/{name}"),
            None => name.clone(),
        },
    }
}

fn read_message<B: CdrEndian>(
    reader: &mut CdrReader<'_, B>,
    plan: &Plan,
) -> Result<Value, Ros2Error> {
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
    // Every element takes a byte or more, so this bounds memory and time by the message's size.
    let left = reader.remaining();
    if count > left {
        return Err(Ros2Error::ArrayTooLong {
            claimed: count,
            left,
        });
    }
    let mut items = (0..count).map(|_| read_one(reader, element));
    let numeric = !matches!(
        element,
        Element::Nested(_) | Element::Basic(BuiltInType::String(_) | BuiltInType::WString(_))
    );
    if !numeric {
        return Ok(Value::List(items.collect::<Result<_, _>>()?));
    }
    let numbers = items.try_fold(Vec::with_capacity(count), |mut numbers, item| {
        match item? {
            Value::Float(x) => numbers.push(x),
            Value::Int(n) => numbers.push(n as f64),
            _ => {}
        }
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
        BuiltInType::WString(_) => {
            return Err(Ros2Error::Definition("a field of type wstring".to_owned()));
        }
    };
    value.map_err(bytes)
}

fn bytes(error: re_cdr::Error) -> Ros2Error {
    Ros2Error::Bytes(error.to_string())
}
