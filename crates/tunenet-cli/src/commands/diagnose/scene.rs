//! What a manifest entry says of the scene of its object.

use anyhow::Result;
use tunenet_formats::Error;
use tunenet_sim::SimulationFile;
use tunenet_sim::simulation_file::Domain;

use crate::answers::diagnose::Object;
use crate::args::Diagnose;
use crate::files::manifest::{KNOWN_PAYLOAD, Source};

/// The simulation file with what a manifest entry says of the scene.
pub fn in_scene(options: &Diagnose, source: &Source, file: &SimulationFile) -> Result<SimulationFile> {
    let mut file = file.clone();
    let program = source.scene.iter().find(|(key, _)| file.domain() == Domain::Process && key.starts_with("process."));
    if let Some((key, _)) = program {
        // Permission was given to the program of the simulation file, and to no other.
        let message = format!("{}: expected settings and parameters, found `{key}`", source.path.display());
        let hint = "only the simulation file says which program runs, and how";
        return Err(Error::file(options.manifest.clone().unwrap_or_default(), message, hint).into());
    }
    for (key, value) in source.scene.iter().flat_map(|(key, value)| known_payload(key, value)) {
        file.set(&format!("{key}={value}")).map_err(|e| match e {
            // Not the command line's fault.
            Error::Core(tunenet_core::Error::Setting { expected, found, .. }) => {
                let message = format!("{}: expected {expected}, found {found}", source.path.display());
                Error::file(options.manifest.clone().unwrap_or_default(), message, "see docs/files.md for the keys")
            }
            other => other,
        })?;
    }
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

/// Recordings of one object share its scene.
pub fn same_scene(options: &Diagnose, source: &Source, object: &Object) -> Result<()> {
    if source.scene == object.scene {
        return Ok(());
    }
    let listed = |scene: &[(String, String)]| {
        let each: Vec<String> = scene.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        if each.is_empty() { "no keys of the scene".into() } else { each.join(", ") }
    };
    let message = format!(
        "{}: expected {} as for the other recordings of `{}`, found {}",
        source.path.display(),
        listed(&object.scene),
        object.name,
        listed(&source.scene)
    );
    let hint = "give it another `object`, or say the same of all";
    Err(Error::file(options.manifest.clone().unwrap_or_default(), message, hint).into())
}
