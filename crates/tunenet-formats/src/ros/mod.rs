//! ROS messages, in any file.

pub(crate) mod cdr;
pub(crate) mod channel;
pub(crate) mod decoder;
pub(crate) mod definitions;
pub(crate) mod joints;
mod json;
mod mark;
pub(crate) mod message;
mod message_definition;
pub(crate) mod numbers;
pub(crate) mod schema;
pub(crate) mod stamps;
mod standard;
pub(crate) mod wanted;
