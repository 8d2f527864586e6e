//! MCAP files: logs of messages.

mod decoder;
mod definitions;
mod joints;
mod json;
pub(crate) mod message;
mod message_definition;
pub mod pictures;
pub(crate) mod records;
pub(crate) mod ros;
pub(crate) mod series;
pub(crate) mod stamps;
pub(crate) mod topics;
pub(crate) mod trajectory;
mod whole_chunks;
pub(crate) mod write;
