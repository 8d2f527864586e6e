//! What a message says, whatever its encoding.

use super::mcap_read::ChannelInfo;
use super::{json, ros};
use crate::observation::Kind;

/// Why a message of another kind cannot be used.
pub(super) const NOTHING: &str = "carries no positions, joints or bounces";

/// One message of a kind that an observation can be made of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Decoded {
    /// The stamp in its header, in ns.
    pub stamp_ns: Option<i64>,
    pub sample: Sample,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Sample {
    /// x, y, z in m.
    Position([f64; 3]),
    Joints(JointMessage),
    /// The number of an impact; its time is the stamp.
    Bounce(f64),
}

impl Sample {
    pub fn kind(&self) -> Kind {
        match self {
            Self::Position(_) => Kind::Positions,
            Self::Joints(_) => Kind::Joints,
            Self::Bounce(_) => Kind::BounceTimes,
        }
    }
}

/// Joints by name; each array is as long as `name` or empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct JointMessage {
    pub name: Vec<String>,
    /// rad.
    pub position: Vec<f64>,
    /// rad/s.
    pub velocity: Vec<f64>,
    /// N·m.
    pub effort: Vec<f64>,
}

/// How the messages of a channel are decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Decoder {
    Cdr(ros::Type),
    Json,
}

impl Decoder {
    /// For a channel, or why there is none.
    pub fn of(channel: &ChannelInfo) -> std::result::Result<Self, String> {
        match channel.message_encoding.as_str() {
            "cdr" => ros::Type::of(&channel.schema_name).map(Self::Cdr).ok_or_else(|| NOTHING.to_owned()),
            "json" => Ok(Self::Json),
            "" => Err("has no message encoding: expected `cdr` or `json`".into()),
            other => Err(format!("has the message encoding `{other}`: expected `cdr` or `json`")),
        }
    }

    pub fn decode(self, data: &[u8]) -> std::result::Result<Decoded, String> {
        match self {
            Self::Cdr(kind) => ros::decode(kind, data),
            Self::Json => json::decode(data),
        }
    }
}
