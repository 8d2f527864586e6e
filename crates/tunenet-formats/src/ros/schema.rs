//! ROS message definitions: which fields a message has, in order, down to its numbers.
//!
//! Source: the interface definition of ROS 2 (`.msg` files), and their concatenated form `ros2msg` in logs.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::standard;

/// Deepest nesting of messages in messages.
const DEEPEST: usize = 16;

/// Most fields of a message, those of its parts included.
const MOST_FIELDS: usize = 4_000;

/// The fields of a message in the order in which they are written.
pub(crate) type Fields = Arc<Vec<Field>>;

/// One field.
#[derive(Debug, PartialEq)]
pub(crate) struct Field {
    pub name: String,
    pub kind: FieldKind,
    pub shape: Shape,
}

/// What a field holds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FieldKind {
    Number(Number),
    Text,
    Message(Fields),
    /// The header of a message, whose stamp is its time.
    Header(Fields),
}

/// How many of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    One,
    Fixed(u32),
    Sequence,
}

/// A number as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    Bool,
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
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "bool" => Self::Bool,
            "byte" | "char" | "uint8" => Self::U8,
            "int8" => Self::I8,
            "uint16" => Self::U16,
            "int16" => Self::I16,
            "uint32" => Self::U32,
            "int32" => Self::I32,
            "uint64" => Self::U64,
            "int64" => Self::I64,
            "float32" => Self::F32,
            "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Its size, and what it is aligned to, in bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

/// Definitions that a user gives for types that a log does not define: the name of a type without its package, and its fields.
pub(crate) type Given = [(String, String)];

/// The fields of message `name`, which `text` defines with all that it needs; what is not defined there is looked for among the `given`
/// ones and the common ones.
///
/// # Errors
/// Why there are none, to be read after the topic's name.
pub(crate) fn fields(name: &str, text: &str, given: &Given) -> std::result::Result<Fields, Unread> {
    let name = name.replace("/msg/", "/");
    let mut sections: BTreeMap<String, &str> = BTreeMap::new();
    let mut rest = text;
    let mut this = name.clone();
    loop {
        let end = rest.find("\n====").map_or(rest.len(), |at| at + 1);
        let (section, after) = rest.split_at(end);
        if this != name || !section.trim().is_empty() {
            sections.insert(this.clone(), section);
        }
        let after = after.trim_start_matches('=').trim_start();
        let (line, after) = after.split_once('\n').unwrap_or((after, ""));
        match line.trim().strip_prefix("MSG:") {
            Some(named) => this = named.trim().replace("/msg/", "/"),
            None => break,
        }
        rest = after;
    }
    let mut reading = Reading { sections, given, left: MOST_FIELDS };
    reading.message(&name, "", 0)
}

/// Why the messages of a channel are not read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Unread {
    /// Nothing defines this type: `odrive_can/ControllerStatus`.
    Undefined(String),
    /// To be read after the topic's name.
    Other(String),
}

impl std::fmt::Display for Unread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Undefined(name) => write!(f, "carries `{name}`, which the log does not define"),
            Self::Other(why) => f.write_str(why),
        }
    }
}

impl From<String> for Unread {
    fn from(why: String) -> Self {
        Self::Other(why)
    }
}

impl From<&str> for Unread {
    fn from(why: &str) -> Self {
        Self::Other(why.into())
    }
}

struct Reading<'a> {
    sections: BTreeMap<String, &'a str>,
    given: &'a Given,
    left: usize,
}

impl<'a> Reading<'a> {
    fn text(&self, name: &str) -> Option<&'a str> {
        let stem = name.rsplit('/').next().unwrap_or(name);
        let by_user = || self.given.iter().find(|(given, _)| given == stem).map(|(_, text)| text.as_str());
        self.sections.get(name).copied().or_else(by_user).or_else(|| standard::fields(name))
    }

    /// The fields of a message, whose type is written `name` in package `package`.
    fn message(&mut self, name: &str, package: &str, depth: usize) -> std::result::Result<Fields, Unread> {
        if depth > DEEPEST {
            return Err(format!("defines messages in messages more than {DEEPEST} deep").into());
        }
        let name = match name.replace("/msg/", "/") {
            bare if !bare.contains('/') && bare == "Header" => "std_msgs/Header".to_owned(),
            bare if !bare.contains('/') => format!("{package}/{bare}"),
            whole => whole,
        };
        let Some(text) = self.text(&name) else {
            return Err(Unread::Undefined(name));
        };
        let package = name.split('/').next().unwrap_or_default().to_owned();
        let mut fields = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default();
            let mut words = line.split_whitespace();
            let (Some(kind), Some(field)) = (words.next(), words.next()) else { continue };
            // A constant has a value behind its name; a default value stands there without `=`.
            if line.contains('=') && !kind.contains("<=") || kind.contains("---") {
                continue;
            }
            self.left = self.left.checked_sub(1).ok_or("defines more fields than are read")?;
            let (kind, shape) = shaped(kind)?;
            let of_header = kind == "Header" || kind.replace("/msg/", "/") == "std_msgs/Header";
            let kind = match Number::of(kind) {
                Some(number) => FieldKind::Number(number),
                None if kind.starts_with("string") || kind.starts_with("wstring") => FieldKind::Text,
                None if of_header => FieldKind::Header(self.message(kind, &package, depth + 1)?),
                None => FieldKind::Message(self.message(kind, &package, depth + 1)?),
            };
            if kind == FieldKind::Text && line.trim_start().starts_with("wstring") {
                return Err(format!("defines `{field}` as wstring: expected numbers and strings").into());
            }
            fields.push(Field { name: field.to_owned(), kind, shape });
        }
        Ok(Arc::new(fields))
    }
}

/// Whether a message with these fields may hold a number besides the stamp of its header.
pub(crate) fn holds_numbers(fields: &Fields) -> bool {
    fields.iter().any(|field| match &field.kind {
        FieldKind::Number(_) => true,
        FieldKind::Message(inner) => holds_numbers(inner),
        FieldKind::Text | FieldKind::Header(_) => false,
    })
}

/// A type without its brackets, and what these say: `float64[]`, `float64[9]`, `float64[<=9]`.
fn shaped(kind: &str) -> std::result::Result<(&str, Shape), String> {
    let Some((base, rest)) = kind.split_once('[') else { return Ok((kind, Shape::One)) };
    let count = rest.strip_suffix(']').ok_or_else(|| format!("defines a field of type `{kind}`"))?;
    if count.is_empty() || count.starts_with("<=") {
        return Ok((base, Shape::Sequence));
    }
    match count.parse::<u32>() {
        Ok(count) => Ok((base, Shape::Fixed(count))),
        Err(_) => Err(format!("defines a field of type `{kind}`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "\
# A motor.
uint8 MODE=3
std_msgs/Header header
float32[<=4] currents 
Axis[2] axes
================================================================================
MSG: odd/Axis
string<=5 label
float64 angle 0.5 # a default
";

    #[test]
    fn a_definition_gives_fields_down_to_the_numbers() {
        let found = fields("odd/msg/Motor", WHOLE, &[]).unwrap();
        let names: Vec<(&str, Shape)> = found.iter().map(|f| (f.name.as_str(), f.shape)).collect();
        assert_eq!(names, [("header", Shape::One), ("currents", Shape::Sequence), ("axes", Shape::Fixed(2))]);
        let FieldKind::Message(axis) = &found[2].kind else { panic!("a message") };
        assert_eq!(axis[0].kind, FieldKind::Text);
        assert_eq!(axis[1].kind, FieldKind::Number(Number::F64));
    }

    #[test]
    fn a_type_is_found_in_the_log_then_in_what_is_given_then_among_common_ones() {
        assert_eq!(fields("std_msgs/msg/Float64", "", &[]).unwrap()[0].kind, FieldKind::Number(Number::F64));
        let unknown = fields("odd/msg/Thing", "", &[]).unwrap_err();
        assert_eq!(unknown.to_string(), "carries `odd/Thing`, which the log does not define");
        let given = [("Thing".to_owned(), "geometry_msgs/Vector3 force\nOther other".to_owned())];
        assert_eq!(fields("odd/msg/Thing", "", &given).unwrap_err(), Unread::Undefined("odd/Other".into()));
        let both = [given[0].clone(), ("Other".to_owned(), "int16 a".to_owned())];
        assert_eq!(fields("odd/msg/Thing", "", &both).unwrap().len(), 2);
    }

    #[test]
    fn a_definition_of_itself_or_of_too_much_is_refused() {
        let again = [("Thing".to_owned(), "Thing a\nThing b".to_owned())];
        assert!(fields("odd/Thing", "", &again).is_err());
        let many = "float64 a\n".repeat(MOST_FIELDS + 1);
        assert_eq!(fields("odd/Thing", &many, &[]).unwrap_err(), Unread::from("defines more fields than are read"));
    }
}
