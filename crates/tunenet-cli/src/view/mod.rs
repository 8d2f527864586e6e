//! What people and machines see of an answer.

pub mod answer;
pub mod html;
pub(crate) mod inspect;
pub mod json;
pub(crate) mod sentence;
pub mod shard;
pub mod text;
pub mod toml;
