//! The command line's say in how files are read.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_formats::{ReadOptions, read_calibration, read_text};

use crate::args::Numbers;

/// The command line's say in how files are read.
///
/// # Errors
/// Where the definition of a message or a calibration file cannot be read.
pub fn reading(reading: &Numbers) -> Result<ReadOptions> {
    let mut units = reading.calibration.as_ref().map(read_calibration).transpose()?.unwrap_or_default();
    // The last rule about a column counts: what is typed is more than what a file says.
    units.extend(reading.units.iter().cloned());
    Ok(ReadOptions {
        columns: reading.columns.clone(),
        topic: reading.topic.clone(),
        skip_broken: reading.skip_broken,
        definitions: definitions(&reading.definitions)?,
        units,
        rate_hz: reading.rate_hz,
        ..ReadOptions::default()
    })
}

/// The definitions of messages in these files.
///
/// # Errors
/// Where one cannot be read.
pub fn definitions(paths: &[PathBuf]) -> Result<Vec<(String, String)>> {
    paths.iter().map(|path| definition(path)).collect()
}

/// The name of a message's type, which its file is called after, and its fields.
fn definition(path: &Path) -> Result<(String, String)> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok((name, read_text(path)?))
}
