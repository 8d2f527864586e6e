//! Which messages of a log are needed.

use super::cdr::Type;
#[cfg(feature = "logs")]
use super::channel::ChannelInfo;

/// Messages of joints that are looked into first: several programs may publish on one topic, each its own joints.
const FIRST_OF_JOINTS: u64 = 32;

/// How many messages of a topic of this type and encoding are looked into first.
pub(crate) fn first_of(schema: &str, encoding: &str) -> u64 {
    if encoding == "json" {
        return FIRST_OF_JOINTS;
    }
    match Type::of(schema) {
        Some(Type::JointState | Type::JointTrajectory) => FIRST_OF_JOINTS,
        _ => 1,
    }
}

/// The messages whose bytes are needed. Those of others may come without them: a bag has them in pages of their own, and most of a
/// robot's bag is pictures.
#[derive(Debug, Clone)]
pub(crate) enum Wanted {
    /// The [first](first_of) of each topic.
    First,
    /// All of a topic.
    #[cfg_attr(not(feature = "logs"), expect(dead_code, reason = "only bags leave bytes unread"))]
    Topic { name: String, schema: String, encoding: String },
}

impl Wanted {
    /// Whether all messages of a channel are needed.
    #[cfg(feature = "logs")]
    pub fn all_of(&self, channel: &ChannelInfo) -> bool {
        match self {
            Self::First => false,
            Self::Topic { name, schema, encoding } => {
                *name == channel.topic && *schema == channel.schema_name && *encoding == channel.message_encoding
            }
        }
    }
}
