//! `tunenet simulate` of the scenes that a manifest describes: a built-in world needs no recording to be driven by.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Observation;
use tunenet_sim::SimulationFile;

use super::built_in;
use crate::args::Simulate;
use crate::commands::load::Setups;
use crate::files::manifest::listed;

/// What a recording of each entry would hold, under the name of its file, which need not be there.
pub fn simulated(options: &Simulate, file: &SimulationFile, manifest: &Path) -> Result<Vec<(String, Observation)>> {
    let entries = listed(manifest)?;
    let one = |entry| {
        let mut scene = Setups::of(Some(manifest), file, &[entry])?.file(0).clone();
        let name = entry.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok((name, built_in(options, &mut scene)?))
    };
    entries.iter().map(one).collect()
}
