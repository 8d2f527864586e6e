//! The recordings of a manifest, each with what its entry says of settings and initial states.

use std::path::Path;

use anyhow::Result;
use serde_json::json;
use tunenet_sim::SimulationFile;

use super::listing::Listing;
use super::look_in;
use crate::args::Inspect;
use crate::commands::load::Setups;
use crate::exit_status::Exit;
use crate::files::manifest;

/// Describes them one after the other.
pub fn run(options: &Inspect, manifest: &Path) -> Result<Exit> {
    // Clap asks for one with a manifest.
    let sim = SimulationFile::read(options.sim.as_deref().unwrap_or(Path::new("")))?;
    let entries = manifest::read(manifest)?;
    let mut listing = Listing::new();
    for entry in &entries {
        let setups = || Setups::of(Some(manifest), &sim, &[entry]);
        listing.add(&entry.path, |shown| {
            let setups = setups()?;
            if !entry.scene.is_empty() {
                let keys: Vec<String> = entry.scene.iter().map(|(key, value)| format!("{key} = {value}")).collect();
                shown.row("scene", &keys.join(", "));
            }
            look_in(&entry.path, options, Some(setups.file(0)), shown)
        });
    }
    let Listing { shown, objects, worst } = listing;
    shown.show(
        options.common.json,
        || json!({ "schema": "tunenet.inspect.files/1", "files": objects, "warnings": [] }),
    )?;
    Ok(worst)
}
