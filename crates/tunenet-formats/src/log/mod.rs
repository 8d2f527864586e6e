//! Logs of messages: their files, their topics, and the observation that one of them makes.

mod choice;
pub(crate) mod columns;
pub(crate) mod files;
pub(crate) mod series;
mod source;
pub(crate) mod topics;
