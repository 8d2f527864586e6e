//! The pairs that a network learns from, as an MCAP file: written, read, cut into shards and merged.

mod file;
mod fill;
mod merge;
mod message;
mod stream;
#[cfg(test)]
mod tests;

pub use file::{DatasetFile, DatasetReader, DatasetWriter};
pub use fill::{fill, generate};
pub use merge::{merge, missing};
pub use message::DATASET_VERSION;
