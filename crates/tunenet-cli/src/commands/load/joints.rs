//! Logs of the joints of an arm, and the run without payload next to one.

use std::path::Path;

use anyhow::{Context, Result};
use tunenet_core::observation::Note;
use tunenet_core::{Error, Origin};
use tunenet_formats::{ReadOptions, Recording, read};
use tunenet_sim::replayed_arm::{ReplayedArm, replays, with_reference};
use tunenet_sim::simulation_file::Domain;
use tunenet_sim::{SimulationFile, findings, observed_robot};

use super::options::reading;
use super::thinned::at_most;
use crate::args::Numbers;
use crate::files::names::file_name;

/// Most samples of a log of joints: torques are averaged, so that more of them are of use, and each costs little.
const MOST_OF_A_LOG: usize = 60_000;

/// A log of the joints of the arm of `file`, matched by name where its messages have names; what its URDF leaves out is noted.
pub fn log(file: &SimulationFile, path: &Path, reading: &Numbers) -> Result<Recording> {
    let arm = ReplayedArm::from_file(file)?;
    let options = ReadOptions { joints: arm.joint_names(), ..self::reading(reading)? };
    at_most(MOST_OF_A_LOG, read(path, &options)?)
}

/// What the URDF of the replayed arm of `file` lacks, of the joints that move.
pub fn lacks(file: &SimulationFile) -> Result<Vec<Note>> {
    if !replays(file) {
        return Ok(Vec::new());
    }
    Ok(ReplayedArm::from_file(file)?.missing_limits())
}

/// What the model of the robot of `file` states and its simulation leaves out, where that may matter.
pub fn left_out(file: &SimulationFile) -> Result<Vec<Note>> {
    if file.domain() != Domain::Robot {
        return Ok(Vec::new());
    }
    let mut notes = observed_robot::notes(file)?;
    notes.retain(|note| [findings::MODEL_LEFT_OUT, findings::MODEL_EFFECTS].contains(&note.kind));
    Ok(notes)
}

/// `recording` with the run without payload at `reference` attached, where there is one.
pub fn attach_reference(
    file: &SimulationFile,
    recording: Recording,
    reference: Option<&Path>,
    reading: &Numbers,
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
