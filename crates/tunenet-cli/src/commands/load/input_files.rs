//! Inputs in files of their own: which files these are, seen from the recordings that they drive.

use std::path::{Path, PathBuf};

use tunenet_sim::{SimulationFile, scene};

use super::scene::in_scene;
use crate::args::Simulation;
use crate::files::manifest::Source;

/// The file of its own in which an input of the recording at `path` stands.
pub fn own_file(input: &scene::Input, path: &Path) -> Option<PathBuf> {
    input.file.as_ref().map(|other| path.parent().unwrap_or(Path::new("")).join(other))
}

/// The files of their own in which the inputs of the recording at `path` stand, each once.
pub fn own_files(file: &SimulationFile, path: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = Vec::new();
    for own in file.inputs().filter_map(|(_, input)| own_file(input, path)) {
        if !found.contains(&own) {
            found.push(own);
        }
    }
    found
}

/// The same of each of `sources`, simulated as a command line and a manifest say. What cannot be read holds none: the command that
/// reads it refuses it.
pub fn own_files_of(simulation: &Simulation, manifest: Option<&Path>, sources: &[Source]) -> Vec<Vec<PathBuf>> {
    let file = super::simulation(simulation).ok();
    let one =
        |source: &Source| in_scene(manifest, source, file.as_ref()?).ok().map(|file| own_files(&file, &source.path));
    sources.iter().map(|source| one(source).unwrap_or_default()).collect()
}
