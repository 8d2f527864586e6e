//! Loading what several commands need.

use std::path::Path;

use anyhow::{Context, Result};
use toml_edit::DocumentMut;
use tunenet_core::observation::Note;
use tunenet_core::{Error, Origin};
use tunenet_formats::{ReadOptions, Recording, read, read_text};
use tunenet_sim::process::Permission;
use tunenet_sim::replayed_arm::{ReplayedArm, replays, with_reference};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{Session, SimulationFile, process};

use super::video;
use crate::args::{self, Reading, Simulation};
use crate::files::destination::urdf_beside;
use crate::files::hash;
use crate::files::names::file_name;
use crate::findings;

/// A simulation file with its overrides.
pub fn simulation(options: &Simulation) -> Result<SimulationFile> {
    let mut file = SimulationFile::read(&options.sim)?;
    for assignment in &options.set {
        file.set(assignment)?;
    }
    Ok(file)
}

/// The same, and the session in which the program that it names runs; without permission such a file is refused before anything
/// else is done.
pub fn simulation_with(options: &Simulation, given: args::Permission) -> Result<(SimulationFile, Session)> {
    let (file, session) = (simulation(options)?, session(given));
    if file.domain() == Domain::Process {
        session.require_permission(&file)?;
    }
    Ok((file, session))
}

/// A session with the permission that the command line gives.
pub fn session(given: args::Permission) -> Session {
    Session::new(if given.allow_process { Permission::Granted } else { Permission::Denied })
}

/// Refuses a simulation file of another kind than a command needs.
pub fn of_kind(file: &SimulationFile, needed: Domain) -> Result<()> {
    if file.domain() == needed {
        return Ok(());
    }
    let message = format!("expected `kind = \"{}\"` here, found \"{}\"", needed.name(), file.domain().name());
    Err(Error::file(file.path(), message, format!("`tunenet init {}` writes one to start from", needed.name())).into())
}

/// Most samples of one recording that are looked at and fitted to; more would not sharpen the answer by as much as they
/// cost.
pub const MOST_SAMPLES: usize = 20_000;

/// A recording from a file of numbers, as `tune` and `inspect` alike look at it.
pub fn recording(path: &Path, reading: &Reading) -> Result<Recording> {
    at_most(MOST_SAMPLES, read(path, &self::reading(reading))?)
}

/// The recording with at most so many of its samples.
fn at_most(most: usize, mut recording: Recording) -> Result<Recording> {
    let samples = recording.observation.len();
    if let Some(fewer) = recording.observation.thinned(most)? {
        let text = format!("{} of {samples} samples are used, evenly chosen", fewer.len());
        recording.notes.push(Note::new(findings::SAMPLES_THINNED, text, ""));
        recording.observation = fewer;
    }
    Ok(recording)
}

/// A recording of what `file` simulates, from a file of numbers or a video, with at most so many samples.
pub fn recording_of(file: &SimulationFile, path: &Path, reading: &Reading, most: usize) -> Result<Recording> {
    no_manifest(path)?;
    if replays(file) {
        return log(file, path, reading);
    }
    if file.domain() == Domain::Process {
        return of_channels(file, path, reading, most);
    }
    if !video::is_video(path) {
        return at_most(most, read(path, &self::reading(reading))?);
    }
    if !reading.columns.is_empty() {
        let (expected, found) = ("a CSV file".into(), format!("the video {}", path.display()));
        return Err(Error::Setting { origin: Origin::Flag, name: "columns", expected, found }.into());
    }
    let asked = video::Asked::default()
        .with("--topic", reading.topic.as_ref())
        .with("--camera-rate", reading.camera_rate.map(|r| r.to_string()));
    let found = asked.of(file).track(path)?;
    at_most(most, video::positions(path, &found)?)
}

/// Refuses a manifest where a recording is asked for.
fn no_manifest(path: &Path) -> Result<()> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
        return Ok(());
    }
    let document = read_text(path)?.parse::<DocumentMut>().unwrap_or_default();
    let Some(all) = document.get("observation").and_then(|all| all.as_array_of_tables()) else { return Ok(()) };
    let message = format!("expected a recording, found a manifest of {}", all.len());
    let hint =
        "`tunenet diagnose --manifest` takes it; give `tune` its recordings one by one, each with `--observation`";
    Err(Error::file(path, message, hint).into())
}

/// A series on the channels that the program of `file` predicts; it is not run for that.
pub fn of_channels(file: &SimulationFile, path: &Path, reading: &Reading, most: usize) -> Result<Recording> {
    if video::is_video(path) {
        let message = "expected a series on the channels of the simulation, found a video";
        let hint = "`tunenet track` makes a CSV file of a ball's positions in it";
        return Err(Error::file(path, message, hint).into());
    }
    let options = ReadOptions { channels: process::channels(file)?, ..self::reading(reading) };
    at_most(most, read(path, &options)?)
}

/// Most samples of a log of joints: torques are averaged, so that more of them are of use, and each costs little.
const MOST_OF_A_LOG: usize = 60_000;

/// A log of the joints of the arm of `file`, matched by name where its messages have names; what its URDF leaves out is noted.
fn log(file: &SimulationFile, path: &Path, reading: &Reading) -> Result<Recording> {
    let arm = ReplayedArm::from_file(file)?;
    let options = ReadOptions { joints: arm.joint_names(), ..self::reading(reading) };
    at_most(MOST_OF_A_LOG, read(path, &options)?)
}

/// What the URDF of the replayed arm of `file` lacks, of the joints that move.
pub fn lacks(file: &SimulationFile) -> Result<Vec<Note>> {
    if !replays(file) {
        return Ok(Vec::new());
    }
    Ok(ReplayedArm::from_file(file)?.missing_limits())
}

/// `recording` with the run without payload at `reference` beside it, where there is one.
pub fn beside(
    file: &SimulationFile,
    recording: Recording,
    reference: Option<&Path>,
    reading: &Reading,
) -> Result<Recording> {
    let Some(path) = reference else { return Ok(recording) };
    if !replays(file) {
        let (expected, found) = ("an arm with `motion.kind = \"replay\"`".into(), "another simulation".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--reference", expected, found }.into());
    }
    let bare = log(file, path, reading)?;
    let (observation, note) =
        with_reference(&recording.observation, &bare.observation).with_context(|| file_name(path))?;
    let mut notes = recording.notes;
    notes.extend(
        bare.notes.into_iter().map(|note| Note { text: format!("{}: {}", file_name(path), note.text), ..note }),
    );
    notes.push(note);
    Ok(Recording { observation, notes })
}

/// The command line's say in how files are read.
pub fn reading(reading: &Reading) -> ReadOptions {
    ReadOptions {
        columns: reading.columns.clone(),
        topic: reading.topic.clone(),
        skip_broken: reading.skip_broken,
        ..ReadOptions::default()
    }
}

/// The SHA-256 of the URDF that a simulation names, where it names one that is there.
pub fn urdf_hash(options: &Simulation) -> Result<Option<String>> {
    let named = options.urdf_set().or_else(|| urdf_beside(&options.sim));
    named.filter(|path| path.is_file()).map(|path| hash::sha256(&path)).transpose()
}
