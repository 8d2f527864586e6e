//! What a manifest says of the recordings that are tuned to.

use anyhow::Result;
use tunenet_formats::Error;
use tunenet_sim::SimulationFile;

use crate::args::Tune;
use crate::commands::load::Setups;
use crate::files::manifest::{Source, read};

/// The entries that are fitted to, in their order; empty without a manifest.
pub fn entries(options: &Tune) -> Result<Vec<Source>> {
    let Some(path) = &options.manifest else { return Ok(Vec::new()) };
    let entries: Vec<Source> = read(path)?.into_iter().filter(|entry| !entry.held_out).collect();
    if entries.is_empty() {
        let message = "expected at least one recording to fit to, found only held-out ones";
        return Err(Error::file(path, message, "leave `held_out = true` out of those that are to be fitted").into());
    }
    Ok(entries)
}

/// The setups of the recordings, which all have to be of one object.
pub fn setups(options: &Tune, file: &SimulationFile, entries: &[Source]) -> Result<Setups> {
    let Some(path) = &options.manifest else { return Ok(Setups::alike(file, options.observation.len())) };
    if let Some(other) = entries.iter().find(|entry| entry.object != entries[0].object) {
        let message =
            format!("expected recordings of one object, found `{}` and `{}`", entries[0].object, other.object);
        let hint = "tune to each separately with `--each`, or ask `tunenet diagnose`, which takes several objects";
        return Err(Error::file(path, message, hint).into());
    }
    Setups::of(Some(path), file, &entries.iter().collect::<Vec<_>>())
}
