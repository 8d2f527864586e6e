//! The channels of a log, and their messages before they are decoded.

use std::collections::BTreeMap;
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
    /// A channel whose messages are of the type that is `described`; `given` defines what the log does not. `known` are the decoders
    /// of the channels before.
    pub fn new(id: u16, topic: String, described: Described<'_>, given: &Given, known: &mut Decoders) -> Self {
        let (message_encoding, schema_name) = (described.message_encoding.to_owned(), described.schema_name.to_owned());
        let decoder = known.entry((message_encoding.clone(), schema_name.clone()));
        let decoder = decoder.or_insert_with(|| Decoder::of(described, given)).clone();
        Self { id, topic, message_encoding, schema_name, decoder }
    }
}

/// How messages are read, by their encoding and the name of their type. Many channels may have the same type, and a definition takes
/// several times its bytes once it is read.
pub(crate) type Decoders = BTreeMap<(String, String), std::result::Result<Decoder, Unread>>;

/// One message, not decoded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RawMessage {
    pub channel: Arc<ChannelInfo>,
    /// When it was recorded, in ns.
    pub log_time: u64,
    pub data: Vec<u8>,
}
