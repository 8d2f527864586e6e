//! What is to be known of the joints of a model before its file is used.

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_core::{Error, Origin};
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::findings;
use tunenet_sim::simulation_file::{RobotStart, is_name};

use super::columns::Columns;
use crate::view::text::listed;

/// That a model which states motors states none for some joints, or several for one.
pub fn without_actuator(model: &Model, start: &RobotStart) -> Option<Note> {
    let joints = model.joints();
    let lacking = joints.iter().filter(|joint| is_name(&joint.name) && start.lacks_actuator(&joint.name));
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

/// That joints of the model are not in the recording; of those in `apart`, [`in_other_messages`] speaks.
pub fn held(model: &Model, columns: &[Columns], apart: &[Columns]) -> Option<Note> {
    let joints = model.joints();
    let known = |joint: &Joint| columns.iter().chain(apart).any(|columns| columns.joint == joint.name);
    let lost = joints.iter().filter(|joint| !known(joint));
    let lost: Vec<&str> = lost.map(|joint| joint.name.as_str()).collect();
    (!lost.is_empty()).then(|| {
        let text = format!(
            "joints for which no column of positions with one of commands for their drive was found are held at 0: {}",
            listed(lost)
        );
        Note::new(findings::URDF_HELD, text, "name their columns with `--joints JOINT=COLUMN:COMMAND`")
    })
}

/// That joints are published in messages of their own.
pub fn in_other_messages(apart: &[Columns]) -> Option<Note> {
    let topic = apart.first()?.state.topic.as_deref()?;
    let names = listed(apart.iter().map(|one| one.joint.as_str()));
    let text = format!("joints that stand in other messages of {topic} than most are held at 0: {names}");
    Some(Note::new(
        findings::URDF_HELD,
        text,
        "publish all joints in one message, as one `joint_state_broadcaster` does",
    ))
}
