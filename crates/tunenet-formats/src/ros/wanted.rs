//! Which messages of a log are needed.

#[cfg(feature = "logs")]
use super::channel::ChannelInfo;

/// The messages whose bytes are needed. Those of others may come without them: a bag has them in pages of their own, and most of a
/// robot's bag is pictures.
#[derive(Debug, Clone)]
pub(crate) enum Wanted {
    /// The first of each topic.
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
