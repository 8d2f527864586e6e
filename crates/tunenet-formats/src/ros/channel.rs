//! The channels of a log, and their messages before they are decoded.

use std::sync::Arc;

use super::decoder::{Decoder, Described};
use super::schema::{Given, Unread};

/// A channel of a log, with its schema.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ChannelInfo {
    /// Its number in the file.
    pub id: u16,
    pub topic: String,
    /// `cdr`, `json`, …
    pub message_encoding: String,
    /// Empty where there is no schema.
    pub schema_name: String,
    /// How its messages are decoded, or why they are not.
    pub decoder: std::result::Result<Decoder, Unread>,
}

impl ChannelInfo {
    /// A channel whose messages are of the type that is `described`; `given` defines what the log does not.
    pub fn new(id: u16, topic: String, described: Described<'_>, given: &Given) -> Self {
        let (message_encoding, schema_name) = (described.message_encoding.into(), described.schema_name.into());
        Self { id, topic, message_encoding, schema_name, decoder: Decoder::of(described, given) }
    }
}

/// One message, not decoded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RawMessage {
    pub channel: Arc<ChannelInfo>,
    /// When it was recorded, in ns.
    pub log_time: u64,
    pub data: Vec<u8>,
}
