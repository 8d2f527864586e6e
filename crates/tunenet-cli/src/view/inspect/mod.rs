//! What `inspect` says of each kind of file, in words and as JSON.

pub mod declared;
pub mod described;
pub mod episodes;
pub mod joints;
pub mod learned;
pub mod log;
pub mod motion;
pub mod table;
