//! Protobuf messages, read by the descriptors that the file carries.

use std::rc::Rc;

use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, ReflectMessage};

use super::value::Value;

/// The pool of a schema's descriptors.
///
/// `prost-reflect` 0.16 panics where it words its complaint about some broken descriptors (it looks
/// up the file that it has not yet taken in), so its panic is caught, unseen, and taken for the
/// error that it was to become.
fn pool(descriptors: &[u8]) -> Result<DescriptorPool, ProtobufError> {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let outcome = std::panic::catch_unwind(|| DescriptorPool::decode(descriptors));
    std::panic::set_hook(hook);
    match outcome {
        Ok(Ok(pool)) => Ok(pool),
        Ok(Err(error)) => Err(ProtobufError::Descriptors(error.to_string())),
        Err(_) => Err(ProtobufError::Descriptors(
            "its descriptors contradict each other".to_owned(),
        )),
    }
}

/// Why a schema or a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ProtobufError {
    /// The schema is no set of file descriptors.
    #[error("its schema is no FileDescriptorSet: {0}")]
    Descriptors(String),
    /// The set has no such message.
    #[error("its schema does not describe `{0}`")]
    UnknownType(String),
    /// Bytes that do not fit the descriptor.
    #[error("its bytes do not fit its schema: {0}")]
    Bytes(String),
}

/// Reads the messages of one type.
#[derive(Debug, Clone)]
pub struct Decoder {
    message: MessageDescriptor,
}

impl Decoder {
    /// A decoder for messages of type `name`, described by a `FileDescriptorSet`.
    ///
    /// # Errors
    /// A schema that is none, or does not have the type.
    pub fn new(name: &str, descriptors: &[u8]) -> Result<Self, ProtobufError> {
        let pool = pool(descriptors)?;
        let message = pool
            .get_message_by_name(name.trim_start_matches('.'))
            .ok_or_else(|| ProtobufError::UnknownType(name.to_owned()))?;
        Ok(Self { message })
    }

    /// Decodes one message. Numbers, texts and arrays that are absent have their default; messages
    /// that are absent are no field of the value.
    ///
    /// # Errors
    /// Bytes that do not fit the schema.
    pub fn decode(&self, message: &[u8]) -> Result<Value, ProtobufError> {
        DynamicMessage::decode(self.message.clone(), message)
            .map(|message| fields(&message))
            .map_err(|e| ProtobufError::Bytes(e.to_string()))
    }
}

fn fields(message: &DynamicMessage) -> Value {
    let descriptor = message.descriptor();
    let present = descriptor
        .fields()
        .filter(|field| !field.supports_presence() || message.has_field(field))
        .filter(|field| !field.is_map());
    Value::Message(
        present
            .map(|field| (Rc::from(field.name()), value(&message.get_field(&field))))
            .collect(),
    )
}

fn value(field: &prost_reflect::Value) -> Value {
    use prost_reflect::Value as Field;
    match field {
        Field::Bool(truth) => Value::Int((*truth).into()),
        Field::I32(n) | Field::EnumNumber(n) => Value::Int((*n).into()),
        Field::I64(n) => Value::Int(*n),
        Field::U32(n) => Value::Int((*n).into()),
        Field::U64(n) => i64::try_from(*n).map_or(Value::Float(*n as f64), Value::Int),
        Field::F32(x) => Value::Float((*x).into()),
        Field::F64(x) => Value::Float(*x),
        Field::String(text) => Value::Text(text.clone()),
        Field::Bytes(bytes) => Value::Numbers(bytes.iter().map(|b| f64::from(*b)).collect()),
        Field::Message(message) => fields(message),
        Field::List(items) => array(items),
        Field::Map(_) => Value::Null,
    }
}

fn array(items: &[prost_reflect::Value]) -> Value {
    use prost_reflect::Value as Field;
    let is_number = |item: &Field| {
        !matches!(
            item,
            Field::String(_) | Field::Bytes(_) | Field::Message(_) | Field::List(_) | Field::Map(_)
        )
    };
    if items.iter().all(is_number) {
        Value::Numbers(
            items
                .iter()
                .filter_map(|item| value(item).as_number())
                .collect(),
        )
    } else {
        Value::List(items.iter().map(value).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_descriptors_are_refused_without_a_panic() {
        let seed = include_bytes!("../../../fuzz/corpus/protobuf/nested");
        let descriptors = &seed[2..];
        for place in 0..descriptors.len() {
            for flip in [1, 2, 4, 8, 16, 32, 64, 128] {
                let mut broken = descriptors.to_vec();
                broken[place] ^= flip;
                let _ = Decoder::new("Fuzz", &broken);
                let _ = Decoder::new("Fuzz", &broken[..place]);
            }
        }
    }
    use prost_reflect::prost::Message;
    use prost_reflect::prost_types::field_descriptor_proto::{Label, Type};
    use prost_reflect::prost_types::{
        DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet,
    };

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

    fn descriptors() -> Vec<u8> {
        let scan = DescriptorProto {
            name: Some("Scan".into()),
            field: vec![
                field("frame_id", 1, Type::String, Label::Optional),
                field("start", 2, Type::Double, Label::Optional),
                field("ranges", 3, Type::Double, Label::Repeated),
                field("nanos", 4, Type::Int32, Label::Optional),
                field("inner", 5, Type::Message, Label::Optional),
            ],
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            name: Some("scan.proto".into()),
            package: Some("test".into()),
            message_type: vec![scan],
            syntax: Some("proto3".into()),
            ..FileDescriptorProto::default()
        };
        FileDescriptorSet { file: vec![file] }.encode_to_vec()
    }

    #[test]
    fn what_is_absent_has_its_default_but_for_messages() {
        let decoder = Decoder::new("test.Scan", &descriptors()).unwrap();
        let value = decoder.decode(&[]).unwrap();
        assert_eq!(value.text("frame_id"), Ok(""));
        assert_eq!(value.number("start"), Ok(0.0));
        assert_eq!(value.distances("ranges"), Ok(vec![]));
        assert_eq!(value.get("inner"), None);
    }

    #[test]
    fn a_message_is_read_by_its_own_descriptors() {
        let decoder = Decoder::new("test.Scan", &descriptors()).unwrap();
        let mut message = b"\x0a\x04ring\x1a\x10".to_vec();
        message.extend(1.5_f64.to_le_bytes());
        message.extend(f64::INFINITY.to_le_bytes());
        message.extend(b"\x20\x07\x2a\x02\x20\x08"); // nanos 7, inner.nanos 8
        let value = decoder.decode(&message).unwrap();
        assert_eq!(value.text("frame_id"), Ok("ring"));
        assert_eq!(value.distances("ranges"), Ok(vec![1.5, f64::INFINITY]));
        assert_eq!(value.get("inner.nanos"), Some(&Value::Int(8)));
        for length in [1, 5, 7, 20] {
            assert!(decoder.decode(&message[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn a_schema_that_is_none_is_refused() {
        assert!(Decoder::new("test.Scan", b"\xff\xff").is_err());
        let refused = Decoder::new("test.Other", &descriptors()).unwrap_err();
        assert_eq!(refused, ProtobufError::UnknownType("test.Other".into()));
    }
}
