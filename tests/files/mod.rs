//! Files: what is refused, what is never written over, and what has the same bytes again.

mod bad_files;
mod bad_input;
mod fuzzed;
mod hostile;
#[cfg(feature = "logs")]
mod logs;
mod overwriting;
mod resume;
mod same_bytes;
mod shards;
