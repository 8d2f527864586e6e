//! MCAP files: logs of messages.

pub mod pictures;
pub(crate) mod reader;
pub(crate) mod trajectory;
mod whole_chunks;
pub(crate) mod write;
