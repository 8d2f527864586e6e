//! Files by name and contents: what they are called, what they hash to, and what may be written over.

pub mod destination;
pub mod hash;
pub(crate) mod manifest;
pub(crate) mod model_cache;
pub mod names;
pub mod programs;
pub(crate) mod track_csv;
pub(crate) mod videos;
