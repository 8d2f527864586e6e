//! What is to be known of the joints of a model before its file is used.

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_core::{Error, Origin};
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::findings;
use tunenet_sim::robot::Drive;
use tunenet_sim::simulation_file::{RobotStart, is_name};

use super::columns::Columns;
use crate::view::text::listed;

/// That a model which states motors states none for some joints, or several for one.
pub fn without_actuator(model: &Model, start: &RobotStart) -> Option<Note> {
    let joints = model.joints();
    let undriven = |joint: &Joint| {
        start.motor(&joint.name).is_some_and(|motor| motor.gain.is_none() && motor.drive == Drive::Position)
    };
    let lacking = joints.iter().filter(|joint| is_name(&joint.name) && undriven(joint));
    let lacking: Vec<&str> = lacking.map(|joint| joint.name.as_str()).collect();
    (!lacking.is_empty()).then(|| {
        let text = format!("joints for which the model has no actuator, or no single one: {}", listed(lacking));
        let remedy = "set `drive` under [joints], where \"position\" is written, and the bounds of its parameters";
        Note::new(findings::MODEL_LEFT_OUT, text, remedy)
    })
}

/// That the names of joints cannot stand in a simulation file.
///
/// # Errors
/// [`Error::Setting`] where no joint of the model has a name that can.
pub fn unnameable(model: &Model) -> Result<Option<Note>> {
    let joints = model.joints();
    let (named, others): (Vec<&Joint>, Vec<&Joint>) = joints.into_iter().partition(|joint| is_name(&joint.name));
    if others.is_empty() {
        return Ok(None);
    }
    let names = listed(others.iter().map(|joint| joint.name.as_str()));
    if named.is_empty() {
        let expected =
            "joints whose names differ in Latin letters, digits and `_` (rename them in a copy of the model)".into();
        return Err(Error::Setting { origin: Origin::Flag, name: "--model", expected, found: names }.into());
    }
    let text =
        format!("joints whose names become the same key of a file (letters, digits and `_`) are held at 0: {names}");
    Ok(Some(Note::new(findings::URDF_HELD, text, "rename them in a copy of the model")))
}

/// That joints of the model are not in the recording.
pub fn held(model: &Model, columns: &[Columns]) -> Option<Note> {
    let joints = model.joints();
    let lost = joints.iter().filter(|joint| columns.iter().all(|columns| columns.joint != joint.name));
    let lost: Vec<&str> = lost.map(|joint| joint.name.as_str()).collect();
    (!lost.is_empty()).then(|| {
        let text = format!("joints without a column of positions and one of commands are held at 0: {}", listed(lost));
        Note::new(findings::URDF_HELD, text, "name their columns with `--joints JOINT=COLUMN:COMMAND`")
    })
}
