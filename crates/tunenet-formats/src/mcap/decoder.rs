//! Which decoder reads the messages of a channel.

use super::message::{Decoded, NOTHING};
use super::records::ChannelInfo;
use super::{json, ros};

/// How the messages of a channel are decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Decoder {
    Cdr(ros::Type),
    Json,
}

impl Decoder {
    /// For a channel, or why there is none.
    pub fn of(channel: &ChannelInfo) -> std::result::Result<Self, String> {
        match (channel.message_encoding.as_str(), &channel.contradiction) {
            ("cdr", Some(contradiction)) => Err(contradiction.clone()),
            ("cdr", None) => ros::Type::of(&channel.schema_name).map(Self::Cdr).ok_or_else(|| NOTHING.to_owned()),
            ("json", _) => Ok(Self::Json),
            ("", _) => Err("has no message encoding: expected `cdr` or `json`".into()),
            (other, _) => Err(format!("has the message encoding `{other}`: expected `cdr` or `json`")),
        }
    }

    pub fn decode(self, data: &[u8]) -> std::result::Result<Decoded, String> {
        match self {
            Self::Cdr(kind) => ros::decode(kind, data),
            Self::Json => json::decode(data),
        }
    }
}
