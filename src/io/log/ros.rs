//! ROS messages: how a definition (`ros1msg`, `ros2msg`) lays out their bytes, and the bytes of ROS 1 and of CDR,
//! as ROS 2 has it, read by a plan that takes the wanted fields and skips all others.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::rc::Rc;

use super::value::{NANOSECONDS, SECONDS, Value, behind, time_of};

/// Types nested deeper than this are refused.
const MAX_DEPTH: usize = 32;

/// Definitions of ROS 2's standard types, for files that carry none. `Range` is Humble's, which is where
/// Jazzy's begins: without a definition nothing tells whether the variance follows.
const STANDARD: &str = include_str!("schemas/standard.msg");

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// `time` and `duration` are basic, a bare `Header` is `std_msgs/Header`, `byte` has a sign.
    Ros1,
    Ros2,
}

/// Why a definition cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DefinitionError {
    #[error("its definition cannot be read: {0}")]
    Text(#[from] std::str::Utf8Error),
    #[error("its definition cannot be read: `{0}` is no field")]
    Line(String),
    #[error("its definition uses `{0}` and does not contain it")]
    UnknownType(String),
    /// Types that contain themselves, or nest beyond any use.
    #[error("its types are nested more than {MAX_DEPTH} deep")]
    TooDeep,
}

/// A message type with all its references resolved.
#[derive(Debug)]
pub struct Layout {
    /// In the order of their bytes.
    pub fields: Vec<(Rc<str>, Field)>,
    /// Bytes that every message of the type takes at least. 0 for what carries nothing: it must not be
    /// repeated as often as a definition says.
    pub least_bytes: usize,
    /// How deep types are nested in it.
    height: usize,
    /// What each of its fields is of a time, where it is one.
    time: Option<Vec<TimePart>>,
}

/// What a field is of a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TimePart {
    Seconds,
    Nanoseconds,
    Nothing,
}

#[derive(Debug, Clone)]
pub struct Field {
    pub element: Element,
    pub count: Count,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    One,
    Fixed(usize),
    /// As many as the message says.
    Claimed,
}

#[derive(Debug, Clone)]
pub enum Element {
    Number(Number),
    Text,
    WideText,
    Nested(Rc<Layout>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Number {
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

impl Element {
    pub fn least_bytes(&self) -> usize {
        match self {
            Self::Number(number) => number.size(),
            Self::Text | Self::WideText => 4,
            Self::Nested(layout) => layout.least_bytes,
        }
    }
}

impl Layout {
    /// The layout of messages of type `name`, defined by the text of a schema.
    ///
    /// # Errors
    /// A definition that cannot be read, or that uses what it does not contain.
    pub fn new(dialect: Dialect, name: &str, text: &[u8]) -> Result<Rc<Self>, DefinitionError> {
        let name = short(name);
        let mut resolver = Resolver {
            dialect,
            lines: BTreeMap::new(),
            done: BTreeMap::new(),
        };
        let mut root = Vec::new();
        let mut lines = &mut root;
        for line in std::str::from_utf8(text)?.lines().map(str::trim) {
            if let Some(name) = line.strip_prefix("MSG:") {
                lines = resolver.lines.entry(short(name.trim())).or_default();
                lines.clear(); // of a type that is defined twice the last counts
            } else if !line.starts_with("===") {
                lines.push(line);
            }
        }
        resolver.layout(&name, &root, 0)
    }

    /// The layout of a ROS 2 type that needs no definition; `None` for a type that is not standard.
    pub fn standard(type_name: &str) -> Option<Result<Rc<Self>, DefinitionError>> {
        let own = standard(&short(type_name))?.join("\n");
        Some(Self::new(Dialect::Ros2, type_name, own.as_bytes()))
    }

    /// Whether a message carries nothing, however deep it is.
    fn is_blank(&self) -> bool {
        self.least_bytes == 0 || self.fields.is_empty()
    }

    fn of(dialect: Dialect, fields: Vec<(Rc<str>, Field)>) -> Result<Rc<Self>, DefinitionError> {
        let least = |field: &Field| match field.count {
            Count::One => field.element.least_bytes(),
            Count::Fixed(count) => field.element.least_bytes().saturating_mul(count),
            Count::Claimed => 4,
        };
        let sum = |sum: usize, (_, field): &(_, Field)| sum.saturating_add(least(field));
        let heights = fields.iter().map(|(_, field)| match &field.element {
            Element::Nested(layout) => layout.height,
            _ => 0,
        });
        let height = 1 + heights.max().unwrap_or(0);
        if height > MAX_DEPTH {
            return Err(DefinitionError::TooDeep);
        }
        Ok(Rc::new(Self {
            least_bytes: match (fields.is_empty(), dialect) {
                (true, Dialect::Ros2) => 1, // an empty struct takes one byte
                _ => fields.iter().fold(0, sum),
            },
            time: time_parts(&fields),
            fields,
            height,
        }))
    }
}

/// The lines of a standard type: drivers leave them out of the definitions that contain it
/// (foxglove/mcap#223).
fn standard(name: &str) -> Option<Vec<&'static str>> {
    let (_, behind) = STANDARD.split_once(&format!("MSG: {name}\n"))?;
    let own = behind.split("===").next().unwrap_or_default();
    Some(own.lines().map(str::trim).collect())
}

/// `package/Type` for `package/msg/Type`, and for `package::msg::dds_::Type_`, as DDS calls it.
pub fn short(name: &str) -> String {
    let dds = name
        .split_once("::msg::dds_::")
        .and_then(|(package, name)| Some((package, name.strip_suffix('_')?)));
    match dds {
        Some((package, name)) => format!("{package}/{name}"),
        None => name.replacen("/msg/", "/", 1),
    }
}

struct Resolver<'a> {
    dialect: Dialect,
    /// The lines of each type.
    lines: BTreeMap<String, Vec<&'a str>>,
    done: BTreeMap<String, Rc<Layout>>,
}

impl<'a> Resolver<'a> {
    /// Resolves a type and all that it contains.
    fn layout(
        &mut self,
        name: &str,
        lines: &[&'a str],
        depth: usize,
    ) -> Result<Rc<Layout>, DefinitionError> {
        if depth > MAX_DEPTH {
            return Err(DefinitionError::TooDeep);
        }
        let package = name.split_once('/').map(|(package, _)| package);
        let mut fields = Vec::new();
        for line in lines {
            if let Some((kind, field)) = declaration(line)? {
                fields.push((Rc::from(field), self.field(kind, package, depth)?));
            }
        }
        Layout::of(self.dialect, fields)
    }

    /// `float64[<=3]`.
    fn field(
        &mut self,
        kind: &str,
        package: Option<&str>,
        depth: usize,
    ) -> Result<Field, DefinitionError> {
        let (element, array) = match kind.split_once('[') {
            Some((element, array)) => (element, Some(array)),
            None => (kind, None),
        };
        let count = match array.map(|array| array.trim_end_matches(']')) {
            None => Count::One,
            Some(size) if size.is_empty() || size.starts_with("<=") => Count::Claimed,
            Some(size) => {
                let size = size.parse();
                Count::Fixed(size.map_err(|_| DefinitionError::Line(kind.to_owned()))?)
            }
        };
        let element = element.split("<=").next().unwrap_or_default();
        Ok(Field {
            element: self.element(element, package, depth)?,
            count,
        })
    }

    fn element(
        &mut self,
        name: &str,
        package: Option<&str>,
        depth: usize,
    ) -> Result<Element, DefinitionError> {
        let ros1 = self.dialect == Dialect::Ros1;
        let number = match name {
            "byte" if ros1 => Number::I8,
            "bool" | "byte" | "char" | "uint8" => Number::U8,
            "int8" => Number::I8,
            "int16" => Number::I16,
            "uint16" => Number::U16,
            "int32" => Number::I32,
            "uint32" => Number::U32,
            "int64" => Number::I64,
            "uint64" => Number::U64,
            "float32" => Number::F32,
            "float64" => Number::F64,
            "string" => return Ok(Element::Text),
            "wstring" => return Ok(Element::WideText),
            "time" if ros1 => return self.time(Number::U32),
            "duration" if ros1 => return self.time(Number::I32),
            _ => {
                let name = match package {
                    _ if name.contains('/') => short(name),
                    _ if ros1 && name == "Header" => "std_msgs/Header".to_owned(),
                    Some(package) => format!("{package}/{name}"),
                    None => name.to_owned(),
                };
                return self.nested(name, depth);
            }
        };
        Ok(Element::Number(number))
    }

    fn nested(&mut self, name: String, depth: usize) -> Result<Element, DefinitionError> {
        if let Some(known) = self.done.get(&name) {
            return Ok(Element::Nested(Rc::clone(known)));
        }
        let own = self.lines.get(&name).cloned();
        let lines = own.or_else(|| standard(&name).filter(|_| self.dialect == Dialect::Ros2));
        let Some(lines) = lines else {
            return Err(DefinitionError::UnknownType(name));
        };
        let layout = self.layout(&name, &lines, depth + 1)?;
        self.done.insert(name, Rc::clone(&layout));
        Ok(Element::Nested(layout))
    }

    /// ROS 1's basic types that have parts.
    fn time(&self, part: Number) -> Result<Element, DefinitionError> {
        let field = |name: &str| {
            let (element, count) = (Element::Number(part), Count::One);
            (Rc::from(name), Field { element, count })
        };
        let layout = Layout::of(self.dialect, vec![field("secs"), field("nsecs")]);
        Ok(Element::Nested(layout?))
    }
}

/// Type and name of the field that a line declares; `None` where it declares none: constants are not in
/// the bytes, and defaults say nothing of them.
fn declaration(line: &str) -> Result<Option<(&str, &str)>, DefinitionError> {
    let code = line.split('#').next().unwrap_or_default().trim();
    if code.is_empty() {
        return Ok(None);
    }
    let (kind, rest) = code.split_once(char::is_whitespace).unwrap_or((code, ""));
    let rest = rest.trim_start();
    let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let (name, value) = rest.split_at(end.unwrap_or(rest.len()));
    if name.is_empty() {
        return Err(DefinitionError::Line(code.to_owned()));
    }
    let is_constant = value.trim_start().starts_with('=');
    Ok((!is_constant).then_some((kind, name)))
}

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
    plan: Vec<Act>,
    wanted: usize,
}

/// What is done with the next bytes of a message; places are those of the wanted paths.
#[derive(Debug)]
enum Act {
    Skip(Field),
    /// A number, for a place.
    Number(Number, usize),
    /// One value, or an array of them, for some places.
    Take(Field, Vec<usize>),
    /// Says that a message is there, which takes no bytes.
    Tell(Vec<usize>),
    /// An array of messages: that they are there for the first places, what is in them for all.
    Columns(Field, Vec<usize>, Vec<Act>, Vec<usize>),
}

impl Decoder {
    /// A decoder for what stands at some paths of the messages that are laid out so.
    pub fn new(dialect: Dialect, layout: &Rc<Layout>, paths: &[String]) -> Self {
        let paths = paths.iter().map(String::as_str).enumerate();
        let wanted: Vec<(usize, &str)> = paths.filter(|(_, path)| !path.is_empty()).collect();
        Self {
            dialect,
            plan: plan(layout, &wanted),
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
        let mut values: Vec<_> = (0..self.wanted).map(|_| Value::Nothing).collect();
        reader.read(&self.plan, &mut values)?;
        match reader.rest.len() {
            left @ 1.. if !reader.cdr => Err(RosError::Long(left)),
            _ => Ok(values), // CDR may end in padding
        }
    }
}

/// What is done with the messages of a type, for the wanted paths. Those in them that are one have their acts in
/// their place: no depth of types is gone through again with every message.
fn plan(layout: &Layout, wanted: &[(usize, &str)]) -> Vec<Act> {
    let mut acts = Vec::new();
    if layout.is_blank() {
        // Of a struct without fields, the byte is taken.
        let element = Element::Number(Number::U8);
        let count = Count::One;
        acts.extend((layout.least_bytes > 0).then_some(Act::Skip(Field { element, count })));
        return acts;
    }
    for (name, field) in &layout.fields {
        let inside = wanted
            .iter()
            .filter_map(|(slot, path)| Some((*slot, behind(path, name)?)));
        let (itself, inside): (Vec<_>, Vec<_>) = inside.partition(|(_, path)| path.is_empty());
        let slots: Vec<usize> = itself.into_iter().map(|(slot, _)| slot).collect();
        match (&field.element, slots.as_slice()) {
            (_, []) if inside.is_empty() => acts.push(Act::Skip(field.clone())),
            (Element::Nested(layout), _) if !inside.is_empty() => {
                let within = plan(layout, &inside);
                if field.count == Count::One {
                    acts.extend(within);
                    acts.push(Act::Tell(slots));
                } else {
                    let mut all = slots.clone();
                    all.extend(inside.iter().map(|(slot, _)| *slot));
                    acts.push(Act::Columns(field.clone(), slots, within, all));
                }
            }
            (Element::Number(number), [slot]) if field.count == Count::One => {
                acts.push(Act::Number(*number, *slot));
            }
            _ => acts.push(Act::Take(field.clone(), slots)),
        }
    }
    acts
}

/// What each field is of a time, where two whole numbers are called as those of a time.
fn time_parts(fields: &[(Rc<str>, Field)]) -> Option<Vec<TimePart>> {
    let part = |(name, _): &(Rc<str>, Field)| match &**name {
        name if SECONDS.contains(&name) => TimePart::Seconds,
        name if NANOSECONDS.contains(&name) => TimePart::Nanoseconds,
        _ => TimePart::Nothing,
    };
    let has = |wanted: TimePart| {
        let mut of = fields.iter().filter(|field| part(field) == wanted);
        of.any(|(_, field)| {
            matches!(field.element, Element::Number(_)) && field.count == Count::One
        })
    };
    (has(TimePart::Seconds) && has(TimePart::Nanoseconds))
        .then(|| fields.iter().map(part).collect())
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
    fn read(&mut self, plan: &[Act], out: &mut [Value<'m>]) -> Result<(), RosError> {
        for act in plan {
            match act {
                Act::Skip(field) => self.skip(field)?,
                Act::Number(number, slot) => {
                    let value = self.number(*number)?;
                    if let Some(place) = out.get_mut(*slot) {
                        *place = value;
                    }
                }
                Act::Take(field, slots) => {
                    let value = self.whole(field)?;
                    put(out, slots, value);
                }
                Act::Tell(slots) => put(out, slots, Value::Message),
                Act::Columns(field, slots, plan, all) => {
                    self.columns(field, plan, slots, all, out)?;
                }
            }
        }
        Ok(())
    }

    /// The elements of an array of messages, a column for each path.
    fn columns(
        &mut self,
        field: &Field,
        plan: &[Act],
        slots: &[usize],
        all: &[usize],
        out: &mut [Value<'m>],
    ) -> Result<(), RosError> {
        let count = self.count(field)?;
        let column = |_: &usize| Vec::with_capacity(count);
        let mut columns: Vec<_> = all.iter().map(column).collect();
        for _ in 0..count {
            self.read(plan, out)?;
            put(out, slots, Value::Message);
            for (column, slot) in columns.iter_mut().zip(all) {
                column.extend(
                    out.get_mut(*slot)
                        .map(|v| std::mem::replace(v, Value::Nothing)),
                );
            }
        }
        for (column, slot) in columns.into_iter().zip(all) {
            put(out, &[*slot], Value::List(column));
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
            Element::Nested(layout) => match &layout.time {
                Some(parts) => self.time(layout, parts),
                None => {
                    self.skip_message(layout)?;
                    Ok(Value::Message)
                }
            },
        }
    }

    fn time(&mut self, layout: &Layout, parts: &[TimePart]) -> Result<Value<'m>, RosError> {
        let (mut seconds, mut nanoseconds) = (0, 0);
        for ((_, field), part) in layout.fields.iter().zip(parts) {
            match part {
                TimePart::Seconds => {
                    seconds = self.one(&field.element)?.as_integer().unwrap_or(0);
                }
                TimePart::Nanoseconds => {
                    nanoseconds = self.one(&field.element)?.as_integer().unwrap_or(0);
                }
                TimePart::Nothing => self.skip(field)?,
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
        if layout.is_blank() {
            return self.take(layout.least_bytes).map(|_| ());
        }
        layout
            .fields
            .iter()
            .try_for_each(|(_, field)| self.skip(field))
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

    /// To a multiple of the size of a number, which is a power of two: every field comes by here, and divisions
    /// take long.
    fn align(&mut self, size: usize) -> Result<(), RosError> {
        let place = self.length - self.rest.len();
        let padding = place.wrapping_neg() & (size - 1);
        if self.cdr && padding > 0 {
            self.take(padding)?;
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

fn put<'m>(out: &mut [Value<'m>], slots: &[usize], value: Value<'m>) {
    let Some((last, others)) = slots.split_last() else {
        return;
    };
    for slot in others {
        if let Some(place) = out.get_mut(*slot) {
            *place = value.clone();
        }
    }
    if let Some(place) = out.get_mut(*last) {
        *place = value;
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

    fn layout(dialect: Dialect, text: &str) -> Result<Rc<Layout>, DefinitionError> {
        Layout::new(dialect, "p/msg/T", text.as_bytes())
    }

    #[test]
    fn constants_defaults_and_comments_are_no_fields() {
        let text = "uint8 MASK=0xff # hexadecimal\nstring NAME = \"a # b\"\nint32 n 7\n\
                    string quote \"\nfloat64[<=3] list [1.0, 2.0]  # why\n\nbool last\n\
                    string<=10[2] names\nwstring<=5 w";
        let layout = layout(Dialect::Ros2, text).unwrap();
        let names: Vec<&str> = layout.fields.iter().map(|(name, _)| &**name).collect();
        assert_eq!(names, ["n", "quote", "list", "last", "names", "w"]);
        assert_eq!(layout.least_bytes, 4 + 4 + 4 + 1 + 8 + 4);
    }

    #[test]
    fn what_is_no_field_is_named() {
        for text in ["string=\"", "float64[x] y", "hello"] {
            let refused = layout(Dialect::Ros2, text).unwrap_err();
            assert!(matches!(refused, DefinitionError::Line(_)), "{text}");
        }
    }

    #[test]
    fn types_of_the_own_package_need_no_prefix() {
        let text = "Inner[2] a\nother/Thing b\n===\nMSG: p/Inner\nfloat64 x\n===\n\
                    MSG: other/msg/Thing\nInner c\n===\nMSG: other/Inner\nuint8 y";
        assert_eq!(layout(Dialect::Ros2, text).unwrap().least_bytes, 17);
    }

    #[test]
    fn ros_1_has_times_and_bare_headers() {
        let text = "Header header\ntime t\nduration[] d\n===\nMSG: std_msgs/Header\nuint32 seq\n\
                    time stamp\nstring frame_id";
        let ros1 = layout(Dialect::Ros1, text).unwrap();
        assert_eq!(ros1.least_bytes, (4 + 8 + 4) + 8 + 4);
        let ros2 = layout(Dialect::Ros2, text).unwrap_err();
        assert_eq!(ros2, DefinitionError::UnknownType("p/Header".into()));
    }

    #[test]
    fn types_of_constants_or_of_nothing_are_types() {
        let text = "Empty e\nKind k\n===\nMSG: p/Empty\n===\nMSG: p/Kind\nuint8 A=1\nuint8 B=2";
        assert_eq!(layout(Dialect::Ros2, text).unwrap().least_bytes, 2);
    }

    #[test]
    fn types_nested_without_end_are_refused() {
        let text = "Loop l\n===\nMSG: p/Loop\nLoop l";
        let refused = layout(Dialect::Ros2, text).unwrap_err();
        assert_eq!(refused, DefinitionError::TooDeep);
        // Each contains the one before, which is known already.
        let mut text = "A0 a0\n".to_owned();
        text.extend((1..40).map(|n| format!("A{n} a{n}\n")));
        text.push_str("===\nMSG: p/A0\nuint8 x\n");
        text.extend((1..40).map(|n| format!("===\nMSG: p/A{n}\nA{} a\n", n - 1)));
        let refused = layout(Dialect::Ros2, &text).unwrap_err();
        assert_eq!(refused, DefinitionError::TooDeep);
    }

    #[test]
    fn every_standard_definition_can_be_read() {
        for name in STANDARD.lines().filter_map(|l| l.strip_prefix("MSG: ")) {
            Layout::standard(name).unwrap().unwrap();
        }
        assert!(Layout::standard("sensor_msgs/msg/Range").is_some());
        assert!(Layout::standard("sensor_msgs/msg/Rang").is_none());
    }
}
