//! Recordings, as the command line says how to read them.

use std::path::Path;

use anyhow::Result;
use toml_edit::DocumentMut;
use tunenet_core::Origin;
use tunenet_formats::{Error, ReadOptions, Recording, read, read_text};
use tunenet_sim::replayed_arm::replays;
use tunenet_sim::{SimulationFile, declared};

use super::inputs;
use super::joints::log;
use super::options::reading as read_options;
use super::read_inputs::attach;
use super::thinned::{at_most, thinned};
use super::video::positions;
use crate::args::{Numbers, Reading};
use crate::commands::video;
use crate::files::videos::is_video;

/// A recording from a file of numbers, as `tune` and `inspect` alike look at it.
pub fn recording(path: &Path, reading: &Reading) -> Result<Recording> {
    thinned(read(path, &read_options(&reading.numbers)?)?)
}

/// A recording of what `file` simulates in this setup, from a file of numbers or a video, with at most so many samples.
pub fn recording_of(
    file: &SimulationFile,
    setup: usize,
    path: &Path,
    reading: &Reading,
    most: usize,
) -> Result<Recording> {
    no_manifest(path)?;
    if replays(file) {
        return log(file, path, &reading.numbers);
    }
    if file.domain().declares() {
        return of_channels(file, setup, path, &reading.numbers, most);
    }
    if !is_video(path) {
        return at_most(most, read(path, &read_options(&reading.numbers)?)?);
    }
    if !reading.numbers.columns.is_empty() {
        let (expected, found) = ("a CSV file".into(), format!("the video {}", path.display()));
        return Err(tunenet_core::Error::Setting { origin: Origin::Flag, name: "columns", expected, found }.into());
    }
    let asked = video::Asked::default()
        .with("--topic", reading.numbers.topic.as_ref())
        .with("--camera-rate", reading.camera_rate.map(|r| r.to_string()));
    let found = asked.of(file).track(path)?;
    at_most(most, positions(path, &found)?)
}

/// Refuses a manifest where a recording is asked for.
fn no_manifest(path: &Path) -> Result<()> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Ok(());
    }
    let document = read_text(path)?.parse::<DocumentMut>().unwrap_or_default();
    let Some(all) = document.get("observation").and_then(|all| all.as_array_of_tables()) else { return Ok(()) };
    let message = format!("expected a recording, found a manifest of {}", all.len());
    let hint = "give it with `--manifest`";
    Err(Error::file(path, message, hint).into())
}

/// A series on the channels that the program of `file` predicts, with its inputs and in this setup; the program is not run for that.
pub fn of_channels(
    file: &SimulationFile,
    setup: usize,
    path: &Path,
    reading: &Numbers,
    most: usize,
) -> Result<Recording> {
    if is_video(path) {
        let message = "expected a series on the channels of the simulation, found a video";
        let hint = "`tunenet track` makes a CSV file of a ball's positions in it";
        return Err(Error::file(path, message, hint).into());
    }
    let (inputs, input_topics) = (inputs::in_recording(file), inputs::topics(file));
    let alone = ReadOptions { channels: declared::channels(file)?, ..read_options(reading)? };
    let recording = read(path, &ReadOptions { others: inputs, input_topics, ..alone.clone() })?;
    // What drives it is kept whole: only what is fitted is thinned.
    at_most(most, attach(file, path, recording, setup, &alone)?)
}
