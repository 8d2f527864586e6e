//! Data sets in a list of recordings: each of their episodes is a recording.

use std::path::PathBuf;

use anyhow::Result;
use tunenet_formats::{Selection, episodes};

/// `paths` with every data set of several episodes replaced by those of `chosen`, or by all.
///
/// # Errors
/// Where a data set cannot be used, or none of the chosen ones is there.
pub fn each(paths: &[PathBuf], chosen: Option<&Selection>) -> Result<Vec<PathBuf>> {
    let mut all = Vec::with_capacity(paths.len());
    for path in paths {
        // What is not there is refused by whoever reads it; an episode is one already.
        match if path.exists() { episodes(path, chosen)? } else { None } {
            Some(mut several) => all.append(&mut several),
            None => all.push(path.clone()),
        }
    }
    Ok(all)
}
