//! How `inspect` reads a file.

use std::path::Path;

use anyhow::Result;
use tunenet_formats::{ReadOptions, Recording};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, process};

use crate::args::Inspect;
use crate::commands::load;

/// How files are read; where a program simulates, by its channels.
pub fn options(options: &Inspect, sim: Option<&SimulationFile>) -> Result<ReadOptions> {
    let mut reading = load::reading(&options.reading);
    if let Some(file) = sim {
        load::of_kind(file, Domain::Process)?;
        reading.channels = process::channels(file)?;
        reading.others = load::inputs::in_recording(file);
    }
    Ok(reading)
}

/// The recording in a file, as `tune` looks at it.
pub fn recording(path: &Path, options: &Inspect, sim: Option<&SimulationFile>) -> Result<Recording> {
    match sim {
        Some(sim) => load::of_channels(sim, 0, path, &options.reading, load::MOST_SAMPLES),
        None => load::recording(path, &options.reading),
    }
}
