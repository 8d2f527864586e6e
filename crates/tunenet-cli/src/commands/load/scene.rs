//! What a manifest entry says of the scene of its recording.

use std::path::Path;

use anyhow::Result;
use tunenet_formats::Error;
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use crate::files::manifest::{KNOWN_PAYLOAD, Source};

/// The simulation file with what an entry of `manifest` says of the scene.
pub fn in_scene(manifest: Option<&Path>, source: &Source, file: &SimulationFile) -> Result<SimulationFile> {
    let refuse = |message: String, hint: &str| Error::file(manifest.unwrap_or(Path::new("")), message, hint);
    let program = source.scene.iter().find(|(key, _)| file.domain() == Domain::Process && key.starts_with("process."));
    if let Some((key, _)) = program {
        // Permission was given to the program of the simulation file, and to no other.
        let message = format!("{}: expected settings and parameters, found `{key}`", source.path.display());
        return Err(refuse(message, "only the simulation file says which program runs, and how").into());
    }
    let keys: Vec<(String, String)> = source.scene.iter().flat_map(|(key, value)| known_payload(key, value)).collect();
    let keys: Vec<(&str, &str)> = keys.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
    let mut file = file.clone();
    file.set_all(&keys).map_err(|e| match e {
        // Not the command line's fault.
        Error::Core(tunenet_core::Error::Setting { expected, found, .. }) => {
            let message = format!("{}: expected {expected}, found {found}", source.path.display());
            refuse(message, "see docs/files.md for the keys")
        }
        other => other,
    })?;
    Ok(file)
}

/// A key of the scene; the payload of an arm, where it is known, is a parameter that is not tuned.
fn known_payload(key: &str, value: &str) -> Vec<(String, String)> {
    if key != KNOWN_PAYLOAD {
        return vec![(key.to_owned(), value.to_owned())];
    }
    let of = |field: &str| format!("parameters.payload_mass.{field}");
    vec![(of("value"), value.to_owned()), (of("tune"), "false".to_owned())]
}
