//! How `inspect` reads a file.

use std::path::Path;

use anyhow::Result;
use tunenet_ball::preflight::Expected;
use tunenet_core::observation::Channel;
use tunenet_formats::{ReadOptions, Recording, read};
use tunenet_sim::{SimulationFile, declared};

use crate::args::Inspect;
use crate::commands::load;

/// How files are read; where a program simulates, by its channels.
///
/// # Errors
/// Where its channels cannot be read.
pub fn options(options: &Inspect, sim: Option<&SimulationFile>) -> Result<ReadOptions> {
    let mut reading = load::reading(&options.reading.numbers)?;
    if let Some(file) = sim.filter(|file| file.domain().declares()) {
        reading.channels = declared::channels(file)?;
        reading.others = load::inputs::in_recording(file);
        reading.input_topics = load::inputs::topics(file);
    }
    Ok(reading)
}

/// Gravity, as the checks of a ball expect it: that of the simulation file, where it is a ball's.
pub fn expected(sim: Option<&SimulationFile>) -> Expected {
    let usual = Expected::default();
    let gravity = sim.and_then(|file| file.ball().ok()).map(|ball| ball.world.gravity_m_s2);
    Expected { gravity_m_s2: gravity.unwrap_or(usual.gravity_m_s2), ..usual }
}

/// The recording in a file, as `tune` looks at it.
pub fn recording(path: &Path, options: &Inspect, sim: Option<&SimulationFile>) -> Result<Recording> {
    match sim.filter(|file| file.domain().declares()) {
        Some(sim) => load::of_channels(sim, 0, path, &options.reading.numbers, load::MOST_SAMPLES),
        None => load::recording(path, &options.reading),
    }
}

/// The recording in a table whose columns are these channels of a simulation of one's own.
pub fn on_channels(path: &Path, options: &Inspect, channels: Vec<Channel>) -> Result<Recording> {
    let reading = load::reading(&options.reading.numbers)?;
    load::thinned(read(path, &ReadOptions { channels, ..reading })?)
}
