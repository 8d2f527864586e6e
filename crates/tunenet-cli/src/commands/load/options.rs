//! The command line's say in how files are read.

use tunenet_formats::ReadOptions;

use crate::args::Reading;

/// The command line's say in how files are read.
pub fn reading(reading: &Reading) -> ReadOptions {
    ReadOptions {
        columns: reading.columns.clone(),
        topic: reading.topic.clone(),
        skip_broken: reading.skip_broken,
        ..ReadOptions::default()
    }
}
