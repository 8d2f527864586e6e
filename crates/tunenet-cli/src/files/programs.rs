//! The programs of tunenet, which are installed in one folder.

use std::path::PathBuf;

use anyhow::{Context, Result};

/// The tool itself.
pub const TUNENET: &str = "tunenet";
/// Reads videos.
pub const VIDEO: &str = "tunenet-video";
/// Runs the benchmarks.
pub const BENCH: &str = "tunenet-bench";

/// Where the program `name` must be: next to this one.
///
/// # Errors
/// If the system does not report the path of this program.
pub fn sibling(name: &str) -> Result<PathBuf> {
    let own = std::env::current_exe().context("this program's own path")?;
    Ok(own.with_file_name(format!("{name}{}", std::env::consts::EXE_SUFFIX)))
}
