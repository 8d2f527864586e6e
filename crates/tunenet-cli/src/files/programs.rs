//! The programs of tunenet, which lie beside each other in one folder.

use std::path::PathBuf;

use anyhow::{Context, Result};

/// The tool itself.
pub const TUNENET: &str = "tunenet";
/// Reads videos.
pub const VIDEO: &str = "tunenet-video";
/// Runs the benchmarks.
pub const BENCH: &str = "tunenet-bench";

/// Where the program `name` must lie: beside this one.
///
/// # Errors
/// Where the system does not say where this one lies.
pub fn beside(name: &str) -> Result<PathBuf> {
    let own = std::env::current_exe().context("this program's own path")?;
    Ok(own.with_file_name(format!("{name}{}", std::env::consts::EXE_SUFFIX)))
}
