//! Protobuf messages, read by the descriptors that the file carries: every wanted field is looked up in the
//! bytes, and all others are stepped over.

use std::collections::BTreeMap;

use prost::Message as _;
use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FileDescriptorProto, FileDescriptorSet};

use super::value::{NANOSECONDS, SECONDS, Value, behind, time_of};

/// Why a schema or a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ProtobufError {
    #[error("its schema is no FileDescriptorSet: {0}")]
    Descriptors(String),
    #[error("its schema does not describe `{0}`")]
    UnknownType(String),
    #[error("its bytes do not fit its schema: {0}")]
    Bytes(#[from] prost::DecodeError),
    #[error("its bytes do not fit its schema: a field ends early or is of another kind")]
    Field,
}

/// Reads the messages of one type.
#[derive(Debug)]
pub struct Decoder {
    /// The fields that lead to each of the wanted paths; none where it leads nowhere.
    ways: Vec<Vec<Part>>,
}

/// One field on the way.
#[derive(Debug)]
struct Part {
    number: u32,
    kind: Type,
    is_array: bool,
    /// Whether what is absent is not there; else it has the default of its kind.
    has_presence: bool,
    /// The numbers of the two fields of a message that is a time.
    time: Option<(u32, u32)>,
}

impl Decoder {
    /// A decoder for what stands at some paths of messages of type `name`, described by a
    /// `FileDescriptorSet`.
    ///
    /// # Errors
    /// A schema that is none, or does not have the type.
    pub fn new(name: &str, descriptors: &[u8], paths: &[String]) -> Result<Self, ProtobufError> {
        let set = FileDescriptorSet::decode(descriptors);
        let set = set.map_err(|error| ProtobufError::Descriptors(error.to_string()))?;
        let mut types = Types(BTreeMap::new());
        set.file.iter().for_each(|file| types.take_file(file));
        let name = name.trim_start_matches('.');
        if !types.0.contains_key(name) {
            return Err(ProtobufError::UnknownType(name.to_owned()));
        }
        let ways = paths.iter().map(|path| types.way(name, path));
        let ways = ways.collect::<Result<_, _>>()?;
        Ok(Self { ways })
    }

    /// What stands at each path of a message. Numbers, texts and arrays that are absent have their default;
    /// messages that are absent are not there.
    ///
    /// # Errors
    /// Bytes that do not fit the schema.
    pub fn decode<'m>(&self, message: &'m [u8]) -> Result<Vec<Value<'m>>, ProtobufError> {
        let at = |way: &Vec<Part>| match way.split_first() {
            Some((part, rest)) => find(message, part, rest),
            None => Ok(Value::Nothing),
        };
        self.ways.iter().map(at).collect()
    }
}

/// The message types of a schema by their full names, and whether fields of each are there or not even where
/// they are no messages, as in proto2.
struct Types<'d>(BTreeMap<String, (&'d DescriptorProto, bool)>);

impl<'d> Types<'d> {
    fn take_file(&mut self, file: &'d FileDescriptorProto) {
        let is_proto3 = file.syntax() == "proto3";
        let messages = file.message_type.iter();
        let mut inside: Vec<_> = messages.map(|m| (file.package().to_owned(), m)).collect();
        while let Some((scope, message)) = inside.pop() {
            let dot = if scope.is_empty() { "" } else { "." };
            let name = format!("{scope}{dot}{}", message.name());
            inside.extend(
                message
                    .nested_type
                    .iter()
                    .map(|nested| (name.clone(), nested)),
            );
            self.0.insert(name, (message, !is_proto3));
        }
    }

    fn way(&self, mut name: &'d str, mut path: &str) -> Result<Vec<Part>, ProtobufError> {
        let mut way = Vec::new();
        while !path.is_empty() {
            let unknown = || ProtobufError::UnknownType(name.to_owned());
            let (message, all_have_presence) = self.0.get(name).ok_or_else(unknown)?;
            let mut fields = message.field.iter();
            let field = fields.find_map(|field| Some((field, behind(path, field.name())?)));
            let Some((field, rest)) = field else {
                return Ok(Vec::new());
            };
            let is_message = field.r#type() == Type::Message;
            if !is_message && !rest.is_empty() {
                return Ok(Vec::new());
            }
            (name, path) = (field.type_name().trim_start_matches('.'), rest);
            let is_array = field.label() == Label::Repeated;
            way.push(Part {
                number: field.number().unsigned_abs(),
                kind: field.r#type(),
                is_array,
                has_presence: !is_array
                    && (*all_have_presence || is_message || field.oneof_index.is_some()),
                time: self.time(name).filter(|_| rest.is_empty()),
            });
        }
        Ok(way)
    }

    fn time(&self, name: &str) -> Option<(u32, u32)> {
        let (message, _) = self.0.get(name)?;
        let part = |names: &[&str]| {
            let mut fields = message.field.iter();
            let field = fields.find(|field| names.contains(&field.name()))?;
            Some(field.number().unsigned_abs())
        };
        Some((part(&SECONDS)?, part(&NANOSECONDS)?))
    }
}

/// What stands at the end of a way that begins with a field of a message.
fn find<'m>(message: &'m [u8], part: &Part, rest: &[Part]) -> Result<Value<'m>, ProtobufError> {
    let mut found = part.default(rest.is_empty());
    let mut bytes = message;
    while let Some((number, field)) = Field::next(&mut bytes)? {
        if number != part.number {
            continue;
        }
        let value = match (field, rest.split_first()) {
            (Field::Bytes(inner), Some((next, rest))) => find(inner, next, rest)?,
            (Field::Bytes(packed), _) if part.is_array && wire_type(part.kind).is_some() => {
                let mut packed = packed;
                while !packed.is_empty() {
                    let field = Field::take(wire_type(part.kind), &mut packed)?;
                    push(&mut found, part.value(field)?);
                }
                continue;
            }
            _ => part.value(field)?,
        };
        if part.is_array {
            push(&mut found, value);
        } else {
            found = value;
        }
    }
    Ok(found)
}

fn push<'m>(array: &mut Value<'m>, value: Value<'m>) {
    match array {
        Value::Numbers(numbers) => numbers.extend(value.as_number()),
        Value::List(items) => items.push(value),
        _ => {}
    }
}

impl Part {
    fn default(&self, is_last: bool) -> Value<'static> {
        let is_number = wire_type(self.kind).is_some();
        match self.kind {
            _ if self.has_presence => Value::Nothing,
            _ if self.is_array && is_number && is_last => Value::Numbers(Vec::new()),
            _ if self.is_array => Value::List(Vec::new()),
            Type::String => Value::Text("".into()),
            Type::Bytes => Value::Bytes(&[]),
            Type::Double | Type::Float => Value::Float(0.0),
            _ => Value::Int(0),
        }
    }

    /// What a field holds.
    fn value<'m>(&self, field: Field<'m>) -> Result<Value<'m>, ProtobufError> {
        let whole = |n: u64| i64::try_from(n).map_or(Value::Float(n as f64), Value::Int);
        Ok(match (self.kind, field) {
            (Type::Double, Field::Eight(n)) => Value::Float(f64::from_bits(n)),
            (Type::Float, Field::Four(n)) => Value::Float(f32::from_bits(n).into()),
            (Type::Fixed64, Field::Eight(n)) | (Type::Uint64, Field::Varint(n)) => whole(n),
            (Type::Sfixed64, Field::Eight(n)) | (Type::Int64, Field::Varint(n)) => {
                Value::Int(n.cast_signed())
            }
            (Type::Fixed32, Field::Four(n)) => Value::Int(n.into()),
            (Type::Sfixed32, Field::Four(n)) => Value::Int(n.cast_signed().into()),
            (Type::Uint32, Field::Varint(n)) => Value::Int((n as u32).into()),
            (Type::Int32 | Type::Enum, Field::Varint(n)) => Value::Int((n as i32).into()),
            (Type::Bool, Field::Varint(n)) => Value::Int((n != 0).into()),
            (Type::Sint32 | Type::Sint64, Field::Varint(n)) => {
                Value::Int((n >> 1).cast_signed() ^ -(n & 1).cast_signed())
            }
            (Type::String, Field::Bytes(text)) => {
                let text = std::str::from_utf8(text).map_err(|_| ProtobufError::Field)?;
                Value::Text(text.into())
            }
            (Type::Bytes, Field::Bytes(bytes)) => Value::Bytes(bytes),
            (Type::Message, Field::Bytes(message)) => match self.time {
                Some((seconds, nanoseconds)) => Value::Time(time_of(
                    varint(message, seconds)?,
                    varint(message, nanoseconds)?,
                )),
                None => Value::Message,
            },
            _ => return Err(ProtobufError::Field),
        })
    }
}

/// A whole number in a message; 0 where it is absent.
fn varint(mut message: &[u8], wanted: u32) -> Result<i64, ProtobufError> {
    let mut found = 0;
    while let Some((number, field)) = Field::next(&mut message)? {
        match field {
            Field::Varint(n) if number == wanted => found = n.cast_signed(),
            _ => {}
        }
    }
    Ok(found)
}

/// A field as it lies in the bytes.
#[derive(Debug, Clone, Copy)]
enum Field<'m> {
    Varint(u64),
    Four(u32),
    Eight(u64),
    Bytes(&'m [u8]),
    Group,
}

impl<'m> Field<'m> {
    fn next(rest: &mut &'m [u8]) -> Result<Option<(u32, Self)>, ProtobufError> {
        if rest.is_empty() {
            return Ok(None);
        }
        let (number, kind) = decode_key(rest)?;
        if kind == WireType::StartGroup {
            skip_field(kind, number, rest, DecodeContext::default())?;
            return Ok(Some((number, Self::Group)));
        }
        Ok(Some((number, Self::take(Some(kind), rest)?)))
    }

    fn take(kind: Option<WireType>, rest: &mut &'m [u8]) -> Result<Self, ProtobufError> {
        Ok(match kind {
            Some(WireType::Varint) => Self::Varint(decode_varint(rest)?),
            Some(WireType::ThirtyTwoBit) => Self::Four(u32::from_le_bytes(first(rest)?)),
            Some(WireType::SixtyFourBit) => Self::Eight(u64::from_le_bytes(first(rest)?)),
            Some(WireType::LengthDelimited) => {
                let length = usize::try_from(decode_varint(rest)?);
                let length = length.map_err(|_| ProtobufError::Field)?;
                let (bytes, behind) = rest.split_at_checked(length).ok_or(ProtobufError::Field)?;
                *rest = behind;
                Self::Bytes(bytes)
            }
            _ => return Err(ProtobufError::Field),
        })
    }
}

fn first<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], ProtobufError> {
    let (bytes, behind) = rest.split_first_chunk().ok_or(ProtobufError::Field)?;
    *rest = behind;
    Ok(*bytes)
}

/// How a number lies in the bytes; `None` for what is none.
fn wire_type(kind: Type) -> Option<WireType> {
    match kind {
        Type::Double | Type::Fixed64 | Type::Sfixed64 => Some(WireType::SixtyFourBit),
        Type::Float | Type::Fixed32 | Type::Sfixed32 => Some(WireType::ThirtyTwoBit),
        Type::String | Type::Bytes | Type::Message | Type::Group => None,
        _ => Some(WireType::Varint),
    }
}

#[cfg(test)]
mod tests {
    use prost_types::FieldDescriptorProto;

    use super::*;

    #[test]
    fn broken_descriptors_are_refused_without_a_panic() {
        let seed = include_bytes!("../../../fuzz/corpus/protobuf/nested");
        let descriptors = &seed[2..];
        let paths = ["frame_id".to_owned(), "inner.ranges".to_owned()];
        for place in 0..descriptors.len() {
            for flip in [1, 2, 4, 8, 16, 32, 64, 128] {
                let mut broken = descriptors.to_vec();
                broken[place] ^= flip;
                let _ = Decoder::new("Fuzz", &broken, &paths);
                let _ = Decoder::new("Fuzz", &broken[..place], &paths);
            }
        }
    }

    fn field(name: &str, number: i32, kind: Type, label: Label) -> FieldDescriptorProto {
        FieldDescriptorProto {
            name: Some(name.into()),
            number: Some(number),
            label: Some(label.into()),
            r#type: Some(kind.into()),
            type_name: (kind == Type::Message).then(|| ".test.Scan".into()),
            ..FieldDescriptorProto::default()
        }
    }

    fn descriptors(syntax: &str) -> Vec<u8> {
        let scan = DescriptorProto {
            name: Some("Scan".into()),
            field: vec![
                field("frame_id", 1, Type::String, Label::Optional),
                field("start", 2, Type::Double, Label::Optional),
                field("ranges", 3, Type::Double, Label::Repeated),
                field("nanos", 4, Type::Int32, Label::Optional),
                field("inner", 5, Type::Message, Label::Optional),
                field("turn", 6, Type::Sint32, Label::Optional),
                field("parts", 7, Type::Message, Label::Repeated),
                field("seconds", 8, Type::Int64, Label::Optional),
            ],
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            name: Some("scan.proto".into()),
            package: Some("test".into()),
            message_type: vec![scan],
            syntax: Some(syntax.into()),
            ..FileDescriptorProto::default()
        };
        FileDescriptorSet { file: vec![file] }.encode_to_vec()
    }

    fn decoder(syntax: &str, paths: &[&str]) -> Decoder {
        let paths: Vec<String> = paths.iter().map(|path| (*path).to_owned()).collect();
        Decoder::new("test.Scan", &descriptors(syntax), &paths).unwrap()
    }

    #[test]
    fn what_is_absent_has_its_default_but_for_messages() {
        let paths = [
            "frame_id",
            "start",
            "ranges",
            "inner",
            "inner.start",
            "parts.start",
        ];
        let (nothing, list) = (Value::Nothing, Value::List(Vec::new()));
        let (text, numbers) = (Value::Text("".into()), Value::Numbers(Vec::new()));
        let found = decoder("proto3", &paths).decode(&[]).unwrap();
        let expected = [
            &text,
            &Value::Float(0.0),
            &numbers,
            &nothing,
            &nothing,
            &list,
        ];
        assert!(found.iter().eq(expected), "{found:?}");
        let found = decoder("proto2", &paths).decode(&[]).unwrap();
        let expected = [&nothing, &nothing, &numbers, &nothing, &nothing, &list];
        assert!(found.iter().eq(expected), "{found:?}");
    }

    #[test]
    fn a_message_is_read_by_its_own_descriptors() {
        let paths = [
            "frame_id",
            "ranges",
            "inner.nanos",
            "turn",
            "parts[].nanos",
            "inner",
            "parts.inner",
        ];
        let decoder = decoder("proto3", &paths);
        let mut message = b"\x0a\x04ring\x1a\x10".to_vec();
        message.extend(1.5_f64.to_le_bytes());
        message.extend(f64::INFINITY.to_le_bytes());
        message.extend(b"\x20\x07\x2a\x02\x20\x08"); // nanos 7, inner.nanos 8
        message.extend(b"\x30\x03"); // turn -2
        message.extend(b"\x19"); // a range that is not packed
        message.extend(2.5_f64.to_le_bytes());
        message.extend(b"\x3a\x02\x20\x01\x3a\x04\x2a\x02\x40\x09"); // parts: nanos 1; inner.seconds 9
        let expected = [
            Value::Text("ring".into()),
            Value::Numbers(vec![1.5, f64::INFINITY, 2.5]),
            Value::Int(8),
            Value::Int(-2),
            Value::List(vec![Value::Int(1), Value::Int(0)]),
            Value::Time(8),
            Value::List(vec![Value::Nothing, Value::Time(9_000_000_000)]),
        ];
        assert_eq!(decoder.decode(&message).unwrap(), expected);
        for length in [1, 5, 7, 20, 25, 38] {
            assert!(decoder.decode(&message[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn a_schema_that_is_none_is_refused() {
        assert!(Decoder::new("test.Scan", b"\xff\xff", &[]).is_err());
        let refused = Decoder::new("test.Other", &descriptors("proto3"), &[]).unwrap_err();
        assert_eq!(refused, ProtobufError::UnknownType("test.Other".into()));
    }
}
