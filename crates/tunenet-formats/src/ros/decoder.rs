//! Which decoder reads the messages of a channel.

use super::message::{Decoded, NOTHING, Sample};
use super::message_definition::contradiction;
use super::numbers::{Numbers, numbers};
use super::schema::{self, Fields, Given, Unread};
use super::{cdr, json};

/// Longest definition that is read, in bytes.
const LONGEST_DEFINITION: usize = 1 << 20;

/// Most bytes of all definitions of types in a log: those of a robot's topics have some hundred thousand. What is read of them takes
/// several times as much memory.
pub(crate) const MOST_DEFINITIONS: usize = 16 << 20;

/// How the messages of a channel are decoded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Decoder {
    /// With its definition, which names its numbers.
    Cdr(cdr::Type, Option<Fields>),
    /// By its definition, for types that are not known.
    Defined(Fields),
    Json,
}

/// What a log says of the type of a channel's messages.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Described<'a> {
    /// `cdr`, `json`, …
    pub message_encoding: &'a str,
    /// Empty where there is no schema.
    pub schema_name: &'a str,
    /// `ros2msg`, …
    pub schema_encoding: &'a str,
    pub definition: &'a [u8],
}

impl Decoder {
    /// For a channel, or why there is none.
    pub fn of(described: Described<'_>, given: &Given) -> std::result::Result<Self, Unread> {
        let Described { message_encoding, schema_name, schema_encoding, definition } = described;
        match message_encoding {
            "cdr" => match contradiction(schema_name, schema_encoding, definition) {
                Some(contradiction) => Err(contradiction.into()),
                None => match cdr::Type::of(schema_name) {
                    Some(kind) => Ok(Self::Cdr(kind, schema::fields(schema_name, "", &[]).ok())),
                    None => Self::defined(described, given),
                },
            },
            "json" => Ok(Self::Json),
            "" => Err("has no message encoding: expected `cdr` or `json`".into()),
            other => Err(format!("has the message encoding `{other}`: expected `cdr` or `json`").into()),
        }
    }

    fn defined(described: Described<'_>, given: &Given) -> std::result::Result<Self, Unread> {
        let Described { schema_name, schema_encoding, definition, .. } = described;
        if schema_name.is_empty() || definition.len() > LONGEST_DEFINITION {
            return Err(NOTHING.into());
        }
        let ours = matches!(schema_encoding, "ros2msg" | "ros1msg");
        let text = if ours { String::from_utf8_lossy(definition) } else { "".into() };
        let fields = schema::fields(schema_name, &text, given)?;
        if schema::holds_numbers(&fields) { Ok(Self::Defined(fields)) } else { Err(NOTHING.into()) }
    }

    /// All numbers of a message, with their names where `named`: one row, or one for each point of a way. None where its type is
    /// not defined.
    pub fn rows(&self, data: &[u8], named: bool) -> std::result::Result<Vec<Numbers>, String> {
        match self {
            Self::Cdr(cdr::Type::JointTrajectory, _) | Self::Json => Ok(self.decode(data, named)?.into_rows()),
            Self::Cdr(_, Some(fields)) | Self::Defined(fields) => Ok(vec![numbers(fields, data, named)?]),
            Self::Cdr(_, None) => Ok(Vec::new()),
        }
    }

    /// What a message says; with the names of its numbers, where it has some and `named`.
    pub fn decode(&self, data: &[u8], named: bool) -> std::result::Result<Decoded, String> {
        match self {
            Self::Cdr(kind, _) => cdr::decode(*kind, data),
            Self::Json => json::decode(data),
            Self::Defined(fields) => {
                let found = numbers(fields, data, named)?;
                Ok(Decoded { stamp_ns: found.stamp_ns, sample: Sample::Numbers(found) })
            }
        }
    }
}
