//! ROS message definitions (`ros1msg`, `ros2msg`): how the bytes of a message are laid out.

use std::collections::BTreeMap;
use std::rc::Rc;

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
        let head = format!("MSG: {}\n", short(type_name));
        let (_, behind) = STANDARD.split_once(&head)?;
        let own = behind.split("===").next().unwrap_or_default();
        let text = format!("{own}===\n{STANDARD}");
        Some(Self::new(Dialect::Ros2, type_name, text.as_bytes()))
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
            fields,
            height,
        }))
    }
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
        let Some(lines) = self.lines.get(&name).cloned() else {
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

#[cfg(test)]
mod tests {
    use super::*;

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
