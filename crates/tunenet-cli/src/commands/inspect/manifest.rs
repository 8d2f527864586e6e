//! The recordings of a manifest, each with what its entry says of settings and initial states.

use std::path::Path;

use anyhow::Result;
use serde_json::json;
use tunenet_sim::SimulationFile;

use super::{Standing, look_in};
use crate::args::Inspect;
use crate::commands::load::Setups;
use crate::failure::{Exit, sentence};
use crate::files::{manifest, names};
use crate::view::answer::Printout;

/// Describes them one after the other.
pub fn run(options: &Inspect, manifest: &Path) -> Result<Exit> {
    // Clap asks for one with a manifest.
    let sim = SimulationFile::read(options.sim.as_deref().unwrap_or(Path::new("")))?;
    let entries = manifest::read(manifest)?;
    let mut shown = Printout::default();
    let (mut objects, mut worst) = (Vec::new(), Exit::Done);
    for entry in &entries {
        let name = names::file_name(&entry.path);
        shown.row("file", &name);
        let setups = Setups::of(Some(manifest), &sim, &[entry]);
        match setups.and_then(|setups| look_in(&entry.path, options, Some(setups.file(0)), &mut shown)) {
            Ok(found) => {
                if found.standing != Standing::Usable && worst != Exit::Refused {
                    worst = found.standing.exit();
                }
                objects.push(found.object);
            }
            Err(error) => {
                worst = Exit::Refused;
                let text = sentence(&error);
                shown.row("refused", &text);
                objects.push(json!({ "schema": "tunenet.inspect/1", "file": name, "usable": false, "error": text }));
            }
        }
        shown.line("");
    }
    shown.show(
        options.common.json,
        || json!({ "schema": "tunenet.inspect.files/1", "files": objects, "warnings": [] }),
    )?;
    Ok(worst)
}
