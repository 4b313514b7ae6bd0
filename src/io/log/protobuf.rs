//! Protobuf messages, read by a plan made of the descriptors that the file carries: it takes the wanted
//! fields and steps over all others.

use std::collections::BTreeMap;

use prost::Message as _;
use prost::encoding::{WireType, decode_key, decode_varint, skip_field};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

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

/// The message types of a schema by their full names, and whether fields of each are there or not even where
/// they are no messages, as in proto2.
struct Types<'d>(BTreeMap<String, (&'d DescriptorProto, bool)>);

/// Reads the messages of one type.
#[derive(Debug)]
pub struct Decoder {
    plan: Plan,
    wanted: usize,
}

/// What is taken of the messages of a type, by the numbers of its fields.
#[derive(Debug, Default)]
struct Plan {
    takes: BTreeMap<u32, Take>,
}

#[derive(Debug)]
struct Take {
    /// The paths that end at the field.
    slots: Vec<usize>,
    /// Those that end in it, too.
    all: Vec<usize>,
    kind: Kind,
    is_array: bool,
    /// Whether what is absent is not there; else it has the default of its kind.
    has_presence: bool,
}

#[derive(Debug)]
enum Kind {
    Basic(Type),
    Message(Plan),
    /// A message of seconds and nanoseconds, with the numbers of these fields.
    Time(u32, u32),
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
        let wanted = paths.iter().map(String::as_str).enumerate();
        let wanted: Vec<(usize, &str)> = wanted.filter(|(_, path)| !path.is_empty()).collect();
        Ok(Self {
            plan: types.plan(name.trim_start_matches('.'), &wanted)?,
            wanted: paths.len(),
        })
    }

    /// What stands at each path of a message. Numbers, texts and arrays that are absent have their default;
    /// messages that are absent are not there.
    ///
    /// # Errors
    /// Bytes that do not fit the schema.
    pub fn decode<'m>(&self, message: &'m [u8]) -> Result<Vec<Value<'m>>, ProtobufError> {
        let mut values = vec![Value::Nothing; self.wanted];
        self.plan.read(message, &mut values)?;
        Ok(values)
    }
}

impl<'d> Types<'d> {
    fn take_file(&mut self, file: &'d FileDescriptorProto) {
        let is_proto3 = file.syntax() == "proto3";
        let mut inside: Vec<(String, &DescriptorProto)> = (file.message_type.iter())
            .map(|message| (file.package().to_owned(), message))
            .collect();
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

    fn plan(&self, name: &str, wanted: &[(usize, &str)]) -> Result<Plan, ProtobufError> {
        let unknown = || ProtobufError::UnknownType(name.to_owned());
        let (message, all_have_presence) = self.0.get(name).ok_or_else(unknown)?;
        let mut plan = Plan::default();
        for field in &message.field {
            let inside = wanted.iter();
            let inside =
                inside.filter_map(|(slot, path)| Some((*slot, behind(path, field.name())?)));
            let (itself, inside): (Vec<_>, Vec<_>) = inside.partition(|(_, path)| path.is_empty());
            let slots: Vec<usize> = itself.iter().map(|(slot, _)| *slot).collect();
            let all = [&itself[..], &inside].concat();
            if all.is_empty() {
                continue;
            }
            let is_array = field.label() == Label::Repeated;
            let is_message = field.r#type() == Type::Message;
            let take = Take {
                slots,
                all: all.into_iter().map(|(slot, _)| slot).collect(),
                kind: self.kind(field, &inside)?,
                is_array,
                has_presence: !is_array
                    && (*all_have_presence || is_message || field.oneof_index.is_some()),
            };
            plan.takes.insert(field.number().unsigned_abs(), take);
        }
        Ok(plan)
    }

    fn kind(
        &self,
        field: &FieldDescriptorProto,
        inside: &[(usize, &str)],
    ) -> Result<Kind, ProtobufError> {
        if field.r#type() != Type::Message {
            return Ok(Kind::Basic(field.r#type()));
        }
        let name = field.type_name().trim_start_matches('.');
        let part = |names: &[&str]| {
            let (message, _) = self.0.get(name)?;
            let part = message.field.iter().find(|part| {
                let is_whole = matches!(
                    part.r#type(),
                    Type::Int32 | Type::Int64 | Type::Uint32 | Type::Uint64
                );
                names.contains(&part.name()) && is_whole && part.label() != Label::Repeated
            })?;
            Some(part.number().unsigned_abs())
        };
        match (part(&SECONDS), part(&NANOSECONDS)) {
            (Some(seconds), Some(nanoseconds)) if inside.is_empty() => {
                Ok(Kind::Time(seconds, nanoseconds))
            }
            _ => Ok(Kind::Message(self.plan(name, inside)?)),
        }
    }
}

impl Plan {
    /// Takes a message; what it does not have is left at its default.
    fn read<'m>(&self, message: &'m [u8], out: &mut [Value<'m>]) -> Result<(), ProtobufError> {
        for take in self.takes.values() {
            let slots = if take.is_array {
                &take.all
            } else {
                &take.slots
            };
            slots
                .iter()
                .for_each(|slot| put(out, *slot, take.default()));
        }
        each_field(
            message,
            &mut |number, field| match self.takes.get(&number) {
                Some(take) => take.read(field, out),
                None => Ok(()),
            },
        )
    }
}

impl Take {
    fn default(&self) -> Value<'static> {
        match &self.kind {
            _ if self.has_presence => Value::Nothing,
            Kind::Basic(Type::String | Type::Bytes) | Kind::Message(_) | Kind::Time(..)
                if self.is_array =>
            {
                Value::List(Vec::new())
            }
            Kind::Basic(_) if self.is_array => Value::Numbers(Vec::new()),
            Kind::Basic(Type::String) => Value::Text("".into()),
            Kind::Basic(Type::Bytes) => Value::Bytes(&[]),
            Kind::Basic(Type::Double | Type::Float) => Value::Float(0.0),
            _ => Value::Int(0),
        }
    }

    fn read<'m>(&self, field: Wire<'m>, out: &mut [Value<'m>]) -> Result<(), ProtobufError> {
        let packed = match (&self.kind, field) {
            (Kind::Basic(Type::String | Type::Bytes), _) => None,
            (Kind::Basic(kind), Wire::Bytes(packed)) if self.is_array => Some((*kind, packed)),
            _ => None,
        };
        if let Some((kind, mut packed)) = packed {
            while !packed.is_empty() {
                let field = Wire::take(wire_type(kind), &mut packed)?;
                self.add(&basic(kind, field)?, out);
            }
            return Ok(());
        }
        let value = match (&self.kind, field) {
            (Kind::Basic(kind), field) => basic(*kind, field)?,
            (Kind::Time(seconds, nanoseconds), Wire::Bytes(message)) => {
                let mut parts = (0, 0);
                each_field(message, &mut |number, field| {
                    match field {
                        Wire::Varint(n) if number == *seconds => parts.0 = n.cast_signed(),
                        Wire::Varint(n) if number == *nanoseconds => parts.1 = n.cast_signed(),
                        _ => {}
                    }
                    Ok(())
                })?;
                Value::Time(time_of(parts.0, parts.1))
            }
            (Kind::Message(plan), Wire::Bytes(message)) if self.is_array => {
                let mut inner = vec![Value::Nothing; out.len()];
                plan.read(message, &mut inner)?;
                for slot in &self.all {
                    let is_itself = self.slots.contains(slot);
                    let value = if is_itself {
                        Some(&Value::Message)
                    } else {
                        inner.get(*slot)
                    };
                    push(out, *slot, value.cloned().unwrap_or(Value::Nothing));
                }
                return Ok(());
            }
            (Kind::Message(plan), Wire::Bytes(message)) => {
                plan.read(message, out)?;
                Value::Message
            }
            _ => return Err(ProtobufError::Field),
        };
        self.add(&value, out);
        Ok(())
    }

    fn add<'m>(&self, value: &Value<'m>, out: &mut [Value<'m>]) {
        for slot in &self.slots {
            if self.is_array {
                push(out, *slot, value.clone());
            } else {
                put(out, *slot, value.clone());
            }
        }
    }
}

fn put<'m>(out: &mut [Value<'m>], slot: usize, value: Value<'m>) {
    if let Some(place) = out.get_mut(slot) {
        *place = value;
    }
}

fn push<'m>(out: &mut [Value<'m>], slot: usize, value: Value<'m>) {
    match out.get_mut(slot) {
        Some(Value::Numbers(numbers)) => numbers.extend(value.as_number()),
        Some(Value::List(items)) => items.push(value),
        _ => {}
    }
}

/// A field as it lies in the bytes.
#[derive(Debug, Clone, Copy)]
enum Wire<'m> {
    Varint(u64),
    Four([u8; 4]),
    Eight([u8; 8]),
    Bytes(&'m [u8]),
}

impl<'m> Wire<'m> {
    fn take(kind: WireType, rest: &mut &'m [u8]) -> Result<Self, ProtobufError> {
        Ok(match kind {
            WireType::Varint => Self::Varint(decode_varint(rest)?),
            WireType::ThirtyTwoBit => Self::Four(first(rest)?),
            WireType::SixtyFourBit => Self::Eight(first(rest)?),
            WireType::LengthDelimited => {
                let length =
                    usize::try_from(decode_varint(rest)?).map_err(|_| ProtobufError::Field)?;
                let (bytes, behind) = rest.split_at_checked(length).ok_or(ProtobufError::Field)?;
                *rest = behind;
                Self::Bytes(bytes)
            }
            WireType::StartGroup | WireType::EndGroup => return Err(ProtobufError::Field),
        })
    }
}

fn first<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], ProtobufError> {
    let (bytes, behind) = rest.split_first_chunk().ok_or(ProtobufError::Field)?;
    *rest = behind;
    Ok(*bytes)
}

/// Hands over every field of a message but groups.
fn each_field<'m>(
    mut rest: &'m [u8],
    take: &mut dyn FnMut(u32, Wire<'m>) -> Result<(), ProtobufError>,
) -> Result<(), ProtobufError> {
    while !rest.is_empty() {
        let (number, kind) = decode_key(&mut rest)?;
        if kind == WireType::StartGroup {
            skip_field(
                kind,
                number,
                &mut rest,
                prost::encoding::DecodeContext::default(),
            )?;
        } else {
            take(number, Wire::take(kind, &mut rest)?)?;
        }
    }
    Ok(())
}

fn wire_type(kind: Type) -> WireType {
    match kind {
        Type::Double | Type::Fixed64 | Type::Sfixed64 => WireType::SixtyFourBit,
        Type::Float | Type::Fixed32 | Type::Sfixed32 => WireType::ThirtyTwoBit,
        Type::String | Type::Bytes | Type::Message => WireType::LengthDelimited,
        Type::Group => WireType::StartGroup,
        _ => WireType::Varint,
    }
}

fn basic(kind: Type, field: Wire<'_>) -> Result<Value<'_>, ProtobufError> {
    let whole = |n: u64| i64::try_from(n).map_or(Value::Float(n as f64), Value::Int);
    Ok(match (kind, field) {
        (Type::Double, Wire::Eight(bytes)) => Value::Float(f64::from_le_bytes(bytes)),
        (Type::Float, Wire::Four(bytes)) => Value::Float(f32::from_le_bytes(bytes).into()),
        (Type::Fixed64, Wire::Eight(bytes)) => whole(u64::from_le_bytes(bytes)),
        (Type::Sfixed64, Wire::Eight(bytes)) => Value::Int(i64::from_le_bytes(bytes)),
        (Type::Fixed32, Wire::Four(bytes)) => Value::Int(u32::from_le_bytes(bytes).into()),
        (Type::Sfixed32, Wire::Four(bytes)) => Value::Int(i32::from_le_bytes(bytes).into()),
        (Type::Uint64, Wire::Varint(n)) => whole(n),
        (Type::Uint32, Wire::Varint(n)) => Value::Int((n as u32).into()),
        (Type::Int64, Wire::Varint(n)) => Value::Int(n.cast_signed()),
        (Type::Int32 | Type::Enum, Wire::Varint(n)) => Value::Int((n as i32).into()),
        (Type::Bool, Wire::Varint(n)) => Value::Int((n != 0).into()),
        (Type::Sint32 | Type::Sint64, Wire::Varint(n)) => {
            Value::Int((n >> 1).cast_signed() ^ -(n & 1).cast_signed())
        }
        (Type::String, Wire::Bytes(text)) => Value::Text(
            std::str::from_utf8(text)
                .map_err(|_| ProtobufError::Field)?
                .into(),
        ),
        (Type::Bytes, Wire::Bytes(bytes)) => Value::Bytes(bytes),
        _ => return Err(ProtobufError::Field),
    })
}

#[cfg(test)]
mod tests {
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
            Value::Message,
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
