//! ROS message definitions (`ros1msg`, `ros2msg`) with all their references resolved: the plan by
//! which a decoder reads the bytes.

use std::collections::BTreeMap;
use std::rc::Rc;

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{
    ArraySize, BuiltInType, ComplexType, MessageSpecification, Type, message_package,
};

/// Types nested deeper than this are refused.
const MAX_DEPTH: usize = 32;

/// What the parser puts into a type without fields.
const PLACEHOLDER: &str = "structure_needs_at_least_one_member";

/// Which of the two definition languages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// `time` and `duration` are basic, a bare `Header` is `std_msgs/Header`, `byte` has a sign.
    Ros1,
    /// As the name says.
    Ros2,
}

/// Why a definition cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SchemaError {
    /// The definition is not one.
    #[error("its definition cannot be read: {0}")]
    Definition(String),
    /// A type that the definition uses and does not contain.
    #[error("its definition uses `{0}` and does not contain it")]
    UnknownType(String),
    /// Types that contain themselves, or nest beyond any use.
    #[error("its types are nested more than {MAX_DEPTH} deep")]
    TooDeep,
}

/// A message type with all its references resolved.
#[derive(Debug)]
pub struct Plan {
    /// Its fields in the order of their bytes.
    pub fields: Vec<(Rc<str>, Kind)>,
    /// Bytes that every message of the type takes at least.
    pub least_bytes: usize,
}

/// What a field holds.
#[derive(Debug)]
pub enum Kind {
    /// One value.
    One(Element),
    /// An array; `None`: of as many elements as the message says.
    Many(Element, Option<usize>),
}

/// One value.
#[derive(Debug)]
pub enum Element {
    /// A number, truth value or text.
    Basic(BuiltInType),
    /// A message.
    Nested(Rc<Plan>),
}

impl Plan {
    /// The plan for messages of type `name`, defined by the text of a schema.
    ///
    /// # Errors
    /// A definition that cannot be read, or that uses what it does not contain.
    pub fn new(dialect: Dialect, name: &str, definition: &[u8]) -> Result<Rc<Self>, SchemaError> {
        let text =
            std::str::from_utf8(definition).map_err(|e| SchemaError::Definition(e.to_string()))?;
        let schema = MessageSchema::parse(&short(name), &fields_only(text))
            .map_err(|e| SchemaError::Definition(format!("{e:#}")))?;
        let mut resolver = Resolver {
            dialect,
            types: schema
                .dependencies
                .iter()
                .map(|spec| (short(&spec.name), spec))
                .collect(),
            done: BTreeMap::new(),
        };
        resolver.plan(&schema.spec, 0)
    }

    fn of(dialect: Dialect, fields: Vec<(Rc<str>, Kind)>) -> Rc<Self> {
        let least_bytes = match (fields.as_slice(), dialect) {
            ([], Dialect::Ros2) => 1, // an empty struct takes one byte
            (fields, _) => fields.iter().fold(0_usize, |sum, (_, kind)| {
                sum.saturating_add(kind.least_bytes())
            }),
        };
        Rc::new(Self {
            fields,
            least_bytes,
        })
    }
}

impl Kind {
    fn least_bytes(&self) -> usize {
        match self {
            Self::One(element) => element.least_bytes(),
            Self::Many(element, Some(count)) => element.least_bytes().saturating_mul(*count),
            Self::Many(_, None) => 4,
        }
    }
}

impl Element {
    /// Bytes that every value takes at least. 0 for what carries nothing: a decoder must not
    /// repeat it as often as a definition says.
    pub fn least_bytes(&self) -> usize {
        match self {
            Self::Nested(plan) => plan.least_bytes,
            Self::Basic(basic) => match basic {
                BuiltInType::Bool
                | BuiltInType::Byte
                | BuiltInType::Char
                | BuiltInType::Int8
                | BuiltInType::UInt8 => 1,
                BuiltInType::Int16 | BuiltInType::UInt16 => 2,
                BuiltInType::Float64 | BuiltInType::Int64 | BuiltInType::UInt64 => 8,
                _ => 4,
            },
        }
    }

    /// Whether it is a number or a truth value.
    pub fn is_number(&self) -> bool {
        !matches!(
            self,
            Self::Nested(_) | Self::Basic(BuiltInType::String(_) | BuiltInType::WString(_))
        )
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

/// Drops what is not in the bytes, constants and defaults: not all of their forms can be parsed.
fn fields_only(text: &str) -> String {
    let field = |line: &str| {
        let code = line.split('#').next().unwrap_or_default();
        let mut words = code.trim().splitn(2, char::is_whitespace);
        let (kind, rest) = (words.next()?, words.next().unwrap_or_default().trim_start());
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '/');
        let (name, value) = rest.split_at(end.unwrap_or(rest.len()));
        let is_constant = !name.is_empty() && value.trim_start().starts_with('=');
        (!is_constant).then(|| format!("{kind} {name}"))
    };
    let lines = text.lines().filter_map(|line| {
        if line.trim_start().starts_with("===") {
            Some(line.to_owned())
        } else if line.trim_start().starts_with("MSG:") {
            // The parser passes over a definition without lines; a comment is one.
            Some(format!("{line}\n#"))
        } else {
            field(line)
        }
    });
    // What is left needs no quotes, and the parser stumbles over one that stands alone.
    lines
        .collect::<Vec<_>>()
        .join("\n")
        .replace(['"', '\''], "")
}

struct Resolver<'a> {
    dialect: Dialect,
    types: BTreeMap<String, &'a MessageSpecification>,
    done: BTreeMap<String, Rc<Plan>>,
}

impl Resolver<'_> {
    /// Resolves a type and all that it contains.
    fn plan(&mut self, spec: &MessageSpecification, depth: usize) -> Result<Rc<Plan>, SchemaError> {
        if depth > MAX_DEPTH {
            return Err(SchemaError::TooDeep);
        }
        let mut fields = Vec::with_capacity(spec.fields.len());
        for field in spec.fields.iter().filter(|f| f.name != PLACEHOLDER) {
            let kind = match &field.ty {
                Type::Array { ty, size } => {
                    let count = match size {
                        ArraySize::Fixed(count) => Some(*count),
                        ArraySize::Bounded(_) | ArraySize::Unbounded => None,
                    };
                    Kind::Many(self.element(spec, ty, depth)?, count)
                }
                single => Kind::One(self.element(spec, single, depth)?),
            };
            fields.push((Rc::from(field.name.as_str()), kind));
        }
        Ok(Plan::of(self.dialect, fields))
    }

    fn element(
        &mut self,
        scope: &MessageSpecification,
        ty: &Type,
        depth: usize,
    ) -> Result<Element, SchemaError> {
        match (ty, self.dialect) {
            (Type::BuiltIn(BuiltInType::Byte), Dialect::Ros1) => {
                Ok(Element::Basic(BuiltInType::Int8))
            }
            (Type::BuiltIn(basic), _) => Ok(Element::Basic(basic.clone())),
            (Type::Complex(complex), _) => {
                let name = self.full_name(scope, complex);
                if let Some(known) = self.done.get(&name) {
                    return Ok(Element::Nested(Rc::clone(known)));
                }
                let plan = match self.types.get(&name) {
                    Some(inner) => self.plan(inner, depth + 1)?,
                    None => self
                        .basic_message(&name)
                        .ok_or_else(|| SchemaError::UnknownType(name.clone()))?,
                };
                self.done.insert(name, Rc::clone(&plan));
                Ok(Element::Nested(plan))
            }
            (Type::Array { .. }, _) => {
                Err(SchemaError::Definition("an array of arrays".to_owned()))
            }
        }
    }

    /// The full name of a type that `scope` refers to.
    fn full_name(&self, scope: &MessageSpecification, complex: &ComplexType) -> String {
        match (complex, self.dialect) {
            (ComplexType::Absolute { package, name }, _) => short(&format!("{package}/{name}")),
            (ComplexType::Relative { name }, Dialect::Ros1)
                if matches!(name.as_str(), "time" | "duration") =>
            {
                name.clone()
            }
            (ComplexType::Relative { name }, Dialect::Ros1) if name == "Header" => {
                "std_msgs/Header".to_owned()
            }
            (ComplexType::Relative { name }, _) => match message_package(&scope.name) {
                Some(package) => format!("{package}/{name}"),
                None => name.clone(),
            },
        }
    }

    /// ROS 1's basic types that have parts.
    fn basic_message(&self, name: &str) -> Option<Rc<Plan>> {
        let part = match (self.dialect, name) {
            (Dialect::Ros1, "time") => BuiltInType::UInt32,
            (Dialect::Ros1, "duration") => BuiltInType::Int32,
            _ => return None,
        };
        let field = |name: &str| (Rc::from(name), Kind::One(Element::Basic(part.clone())));
        Some(Plan::of(self.dialect, vec![field("secs"), field("nsecs")]))
    }
}

#[cfg(test)]
mod tests;
