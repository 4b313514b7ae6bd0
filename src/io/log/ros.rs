//! ROS messages: the bytes of ROS 1 and of CDR, as ROS 2 has it, read by a plan that takes the wanted
//! fields and skips all others.

use std::borrow::Cow;
use std::rc::Rc;

use super::definition::{Count, Dialect, Element, Field, Layout, Number};
use super::value::{NANOSECONDS, SECONDS, Value, behind, time_of};

/// Why a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RosError {
    #[error(
        "its messages are {kind} (encapsulation {0:#06x}), not plain CDR, and are not read; record with XCDR1, \
         which ROS 2 uses unless told otherwise", kind = representation(*.0)
    )]
    Encapsulation(u16),
    #[error("a message ends {0} bytes before its definition does")]
    Short(usize),
    #[error("a message is {0} bytes longer than its definition says")]
    Long(usize),
    #[error("an array claims {claimed} elements with {left} bytes left")]
    ArrayTooLong { claimed: usize, left: usize },
    /// Every middleware encodes it in its own way.
    #[error("it has a field of type wstring, which is not read")]
    WideText,
}

fn representation(encapsulation: u16) -> &'static str {
    match encapsulation {
        2 | 3 => "a parameter list of XCDR1",
        6..=11 => "XCDR2",
        _ => "in an unknown representation",
    }
}

/// Reads the messages of one definition.
#[derive(Debug)]
pub struct Decoder {
    dialect: Dialect,
    plan: Plan,
    wanted: usize,
}

/// What is taken of the messages of a type.
#[derive(Debug)]
struct Plan {
    layout: Rc<Layout>,
    /// One for each field of the layout.
    takes: Vec<Take>,
}

/// What is taken of a field, and for which of the wanted paths.
#[derive(Debug)]
enum Take {
    Nothing,
    /// It itself.
    Whole(Vec<usize>),
    /// That it is there, for the first, and what is in it, for all.
    Inside(Vec<usize>, Plan, Vec<usize>),
}

impl Decoder {
    /// A decoder for what stands at some paths of the messages that are laid out so.
    pub fn new(dialect: Dialect, layout: &Rc<Layout>, paths: &[String]) -> Self {
        let paths = paths.iter().map(String::as_str).enumerate();
        let wanted: Vec<(usize, &str)> = paths.filter(|(_, path)| !path.is_empty()).collect();
        Self {
            dialect,
            plan: Plan::new(layout, &wanted),
            wanted: wanted.last().map_or(0, |(last, _)| last + 1),
        }
    }

    /// What stands at each path of a message.
    ///
    /// # Errors
    /// Bytes that do not fit the definition.
    pub fn decode<'m>(&self, message: &'m [u8]) -> Result<Vec<Value<'m>>, RosError> {
        let (body, big_endian) = match (self.dialect, message.split_first_chunk::<4>()) {
            (Dialect::Ros1, _) => (message, false),
            (Dialect::Ros2, Some(([high, low, ..], body))) => {
                match u16::from_be_bytes([*high, *low]) {
                    0 => (body, true),
                    1 => (body, false),
                    other => return Err(RosError::Encapsulation(other)),
                }
            }
            (Dialect::Ros2, None) => return Err(RosError::Short(4 - message.len())),
        };
        let mut reader = Reader {
            rest: body,
            length: body.len(),
            cdr: self.dialect == Dialect::Ros2,
            big_endian,
        };
        let mut values = vec![Value::Nothing; self.wanted];
        reader.read(&self.plan, &mut values)?;
        match reader.rest.len() {
            left @ 1.. if !reader.cdr => Err(RosError::Long(left)),
            _ => Ok(values), // CDR may end in padding
        }
    }
}

impl Plan {
    fn new(layout: &Rc<Layout>, wanted: &[(usize, &str)]) -> Self {
        let take = |(name, field): &(Rc<str>, Field)| {
            let inside = wanted
                .iter()
                .filter_map(|(slot, path)| Some((*slot, behind(path, name)?)));
            let (itself, inside): (Vec<_>, Vec<_>) = inside.partition(|(_, path)| path.is_empty());
            let slots: Vec<usize> = itself.into_iter().map(|(slot, _)| slot).collect();
            match &field.element {
                _ if slots.is_empty() && inside.is_empty() => Take::Nothing,
                Element::Nested(layout) if !inside.is_empty() => {
                    let mut all = slots.clone();
                    all.extend(inside.iter().map(|(slot, _)| *slot));
                    Take::Inside(slots, Self::new(layout, &inside), all)
                }
                _ => Take::Whole(slots),
            }
        };
        Self {
            layout: Rc::clone(layout),
            takes: layout.fields.iter().map(take).collect(),
        }
    }
}

/// Whether a message is a time: of two whole numbers that are called so.
fn is_time(layout: &Layout) -> bool {
    let has = |names: &[&str]| {
        layout.fields.iter().any(|(name, field)| {
            let is_number = matches!(field.element, Element::Number(_));
            names.contains(&&**name) && is_number && field.count == Count::One
        })
    };
    has(&SECONDS) && has(&NANOSECONDS)
}

struct Reader<'m> {
    rest: &'m [u8],
    /// Of all from which places count.
    length: usize,
    /// Numbers lie at multiples of their size, and a text ends in a zero byte.
    cdr: bool,
    big_endian: bool,
}

impl<'m> Reader<'m> {
    fn read(&mut self, plan: &Plan, out: &mut [Value<'m>]) -> Result<(), RosError> {
        if self.is_blank(&plan.layout)? {
            return Ok(());
        }
        for ((_, field), take) in plan.layout.fields.iter().zip(&plan.takes) {
            match take {
                Take::Nothing => self.skip(field)?,
                Take::Whole(slots) => {
                    let value = self.whole(field)?;
                    put(out, slots, &value);
                }
                Take::Inside(slots, plan, _) if field.count == Count::One => {
                    self.read(plan, out)?;
                    put(out, slots, &Value::Message);
                }
                Take::Inside(slots, plan, all) => self.columns(field, plan, slots, all, out)?,
            }
        }
        Ok(())
    }

    /// The elements of an array of messages, a column for each path.
    fn columns(
        &mut self,
        field: &Field,
        plan: &Plan,
        slots: &[usize],
        all: &[usize],
        out: &mut [Value<'m>],
    ) -> Result<(), RosError> {
        let count = self.count(field)?;
        let mut columns = vec![Vec::with_capacity(count); all.len()];
        for _ in 0..count {
            self.read(plan, out)?;
            put(out, slots, &Value::Message);
            for (column, slot) in columns.iter_mut().zip(all) {
                column.extend(
                    out.get_mut(*slot)
                        .map(|v| std::mem::replace(v, Value::Nothing)),
                );
            }
        }
        for (column, slot) in columns.into_iter().zip(all) {
            put(out, &[*slot], &Value::List(column));
        }
        Ok(())
    }

    /// One value, or an array of them.
    fn whole(&mut self, field: &Field) -> Result<Value<'m>, RosError> {
        if field.count == Count::One {
            return self.one(&field.element);
        }
        let count = self.count(field)?;
        if let Element::Number(Number::U8) = field.element {
            return Ok(Value::Bytes(self.take(count)?));
        }
        let items = (0..count).map(|_| self.one(&field.element));
        if let Element::Number(_) = field.element {
            let numbers = items.map(|item| Ok(item?.as_number().unwrap_or(f64::NAN)));
            return Ok(Value::Numbers(numbers.collect::<Result<_, RosError>>()?));
        }
        Ok(Value::List(items.collect::<Result<_, _>>()?))
    }

    fn one(&mut self, element: &Element) -> Result<Value<'m>, RosError> {
        match element {
            Element::Number(number) => self.number(*number),
            Element::Text => Ok(Value::Text(self.text()?)),
            Element::WideText => Err(RosError::WideText),
            Element::Nested(layout) if is_time(layout) => self.time(layout),
            Element::Nested(layout) => {
                self.skip_message(layout)?;
                Ok(Value::Message)
            }
        }
    }

    fn time(&mut self, layout: &Layout) -> Result<Value<'m>, RosError> {
        let (mut seconds, mut nanoseconds) = (0, 0);
        for (name, field) in &layout.fields {
            if SECONDS.contains(&&**name) {
                seconds = self.one(&field.element)?.as_integer().unwrap_or(0);
            } else if NANOSECONDS.contains(&&**name) {
                nanoseconds = self.one(&field.element)?.as_integer().unwrap_or(0);
            } else {
                self.skip(field)?;
            }
        }
        Ok(Value::Time(time_of(seconds, nanoseconds)))
    }

    fn skip(&mut self, field: &Field) -> Result<(), RosError> {
        let count = self.count(field)?;
        if let (Element::Number(number), 1..) = (&field.element, count) {
            self.align(number.size())?;
            return self.take(count.saturating_mul(number.size())).map(|_| ());
        }
        for _ in 0..count {
            match &field.element {
                Element::Nested(layout) => self.skip_message(layout)?,
                element => self.one(element).map(|_| ())?,
            }
        }
        Ok(())
    }

    fn skip_message(&mut self, layout: &Layout) -> Result<(), RosError> {
        if self.is_blank(layout)? {
            return Ok(());
        }
        layout
            .fields
            .iter()
            .try_for_each(|(_, field)| self.skip(field))
    }

    /// Whether a message carries nothing, however deep it is; of a struct without fields, the byte is taken.
    fn is_blank(&mut self, layout: &Layout) -> Result<bool, RosError> {
        if layout.fields.is_empty() {
            self.take(layout.least_bytes)?;
        }
        Ok(layout.least_bytes == 0 || layout.fields.is_empty())
    }

    /// How many elements follow, held against the bytes that are left before anything is reserved. Of what
    /// carries nothing it is none.
    fn count(&mut self, field: &Field) -> Result<usize, RosError> {
        let claimed = match field.count {
            Count::One => 1,
            Count::Fixed(count) => count,
            Count::Claimed => self.length()?,
        };
        let least = field.element.least_bytes();
        if claimed.saturating_mul(least) > self.rest.len() && field.count != Count::One {
            let left = self.rest.len();
            return Err(RosError::ArrayTooLong { claimed, left });
        }
        Ok(if least == 0 { 0 } else { claimed })
    }

    fn number(&mut self, number: Number) -> Result<Value<'m>, RosError> {
        Ok(match number {
            Number::U8 => Value::Int(u8::from_le_bytes(self.bytes()?).into()),
            Number::I8 => Value::Int(i8::from_le_bytes(self.bytes()?).into()),
            Number::U16 => Value::Int(u16::from_le_bytes(self.bytes()?).into()),
            Number::I16 => Value::Int(i16::from_le_bytes(self.bytes()?).into()),
            Number::U32 => Value::Int(u32::from_le_bytes(self.bytes()?).into()),
            Number::I32 => Value::Int(i32::from_le_bytes(self.bytes()?).into()),
            Number::I64 => Value::Int(i64::from_le_bytes(self.bytes()?)),
            Number::U64 => {
                let n = u64::from_le_bytes(self.bytes()?);
                i64::try_from(n).map_or(Value::Float(n as f64), Value::Int)
            }
            Number::F32 => Value::Float(f32::from_le_bytes(self.bytes()?).into()),
            Number::F64 => Value::Float(f64::from_le_bytes(self.bytes()?)),
        })
    }

    fn text(&mut self) -> Result<Cow<'m, str>, RosError> {
        let length = self.length()?;
        let text = self.take(length)?;
        let text = match text.strip_suffix(&[0]) {
            Some(text) if self.cdr => text,
            _ => text,
        };
        Ok(String::from_utf8_lossy(text))
    }

    fn length(&mut self) -> Result<usize, RosError> {
        let length = u32::from_le_bytes(self.bytes()?);
        Ok(usize::try_from(length).unwrap_or(usize::MAX))
    }

    /// The bytes of a number, the lowest first.
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], RosError> {
        self.align(N)?;
        let missing = N.saturating_sub(self.rest.len());
        let (taken, rest) = self
            .rest
            .split_first_chunk()
            .ok_or(RosError::Short(missing))?;
        self.rest = rest;
        let mut bytes = *taken;
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn align(&mut self, size: usize) -> Result<(), RosError> {
        let place = self.length - self.rest.len();
        if self.cdr && !place.is_multiple_of(size) {
            self.take(size - place % size)?;
        }
        Ok(())
    }

    fn take(&mut self, count: usize) -> Result<&'m [u8], RosError> {
        let missing = count.saturating_sub(self.rest.len());
        let (taken, rest) = (self.rest.split_at_checked(count)).ok_or(RosError::Short(missing))?;
        self.rest = rest;
        Ok(taken)
    }
}

fn put<'m>(out: &mut [Value<'m>], slots: &[usize], value: &Value<'m>) {
    for slot in slots {
        if let Some(place) = out.get_mut(*slot) {
            *place = value.clone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoder(dialect: Dialect, text: &str, paths: &[&str]) -> Decoder {
        let paths: Vec<String> = paths.iter().map(|path| (*path).to_owned()).collect();
        let layout = Layout::new(dialect, "p/msg/T", text.as_bytes()).unwrap();
        Decoder::new(dialect, &layout, &paths)
    }

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
    fn the_fields_of_ros_1_are_packed_without_gaps() {
        let paths = [
            "header.stamp",
            "b",
            "header.frame_id",
            "ranges",
            "names",
            "d",
            "header",
            "b.x",
        ];
        let decoder = decoder(Dialect::Ros1, DEFINITION, &paths);
        let expected = [
            Value::Time(3_500_000_000),
            Value::Int(-1),
            Value::Text("/f".into()),
            Value::Numbers(vec![1.5, f64::INFINITY]),
            Value::List(vec![Value::Text("ab".into()), Value::Text("".into())]),
            Value::Time(-999_999_993),
            Value::Message,
            Value::Nothing,
        ];
        assert_eq!(decoder.decode(&message()).unwrap(), expected);
    }

    #[test]
    fn no_cut_of_a_message_is_read() {
        for paths in [&["d"][..], &["b"], &[]] {
            let decoder = decoder(Dialect::Ros1, DEFINITION, paths);
            let message = message();
            for length in 0..message.len() {
                assert!(decoder.decode(&message[..length]).is_err(), "{length}");
            }
            let longer = [&message[..], &[0]].concat();
            assert_eq!(decoder.decode(&longer), Err(RosError::Long(1)));
        }
    }

    #[test]
    fn an_array_of_messages_is_read_in_columns() {
        let text = "Echo[] e\nuint8 n\n===\nMSG: p/Echo\nuint8 x\nfloat64 range\nuint8[] raw";
        let decoder = decoder(Dialect::Ros2, text, &["e[].range", "n", "e", "e.raw"]);
        for big_endian in [false, true] {
            let mut message = vec![0, u8::from(!big_endian), 0, 0];
            let put = |message: &mut Vec<u8>, bytes: &[u8]| {
                while !(message.len() - 4).is_multiple_of(bytes.len()) {
                    message.push(0xee);
                }
                let start = message.len();
                message.extend(bytes);
                if big_endian {
                    message[start..].reverse();
                }
            };
            put(&mut message, &2_u32.to_le_bytes());
            for range in [1.5_f64, 2.5] {
                put(&mut message, &[9]);
                put(&mut message, &range.to_le_bytes());
                put(&mut message, &1_u32.to_le_bytes());
                put(&mut message, &[range as u8]);
            }
            put(&mut message, &[7]);
            let expected = [
                Value::List(vec![Value::Float(1.5), Value::Float(2.5)]),
                Value::Int(7),
                Value::List(vec![Value::Message; 2]),
                Value::List(vec![Value::Bytes(&[1]), Value::Bytes(&[2])]),
            ];
            assert_eq!(decoder.decode(&message).unwrap(), expected);
        }
    }

    #[test]
    fn a_claimed_length_is_held_against_the_bytes() {
        for paths in [&["x"][..], &[]] {
            let decoder = decoder(Dialect::Ros2, "float64[] x", paths);
            let message = [&[0, 1, 0, 0][..], &1000_u32.to_le_bytes(), &[0; 8]].concat();
            let (claimed, left) = (1000, 8);
            assert_eq!(
                decoder.decode(&message),
                Err(RosError::ArrayTooLong { claimed, left })
            );
        }
    }

    #[test]
    fn what_carries_nothing_is_not_repeated() {
        // Three levels of a million elements that take no byte.
        let text = "A[1000000] a\nuint8 n\n===\nMSG: p/A\nB[1000000] b\n===\nMSG: p/B\nuint8[0] x";
        let decoder = decoder(Dialect::Ros2, text, &["n", "a.b.x"]);
        let values = decoder.decode(&[0, 1, 0, 0, 7]).unwrap();
        assert_eq!(values[0], Value::Int(7));
    }

    #[test]
    fn other_representations_are_named() {
        let decoder = decoder(Dialect::Ros2, "uint8 n", &["n"]);
        let refused = decoder.decode(&[0, 7, 0, 0, 7]).unwrap_err().to_string();
        assert!(
            refused.contains("XCDR2") && refused.contains("0x0007"),
            "{refused}"
        );
        let wide = self::decoder(Dialect::Ros2, "wstring w\nuint8 n", &["n"]);
        assert_eq!(
            wide.decode(&[0, 1, 0, 0, 0, 0, 0, 0, 7]),
            Err(RosError::WideText)
        );
    }
}
