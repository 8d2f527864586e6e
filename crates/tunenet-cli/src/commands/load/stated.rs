//! What the model of a robot states, as far as a simulation file starts from it.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_sim::arm::{Model, model_file};
use tunenet_sim::robot::{scaled_commands, stated_drives, stated_gravity, stated_motors};
use tunenet_sim::simulation_file::RobotStart;

use super::interfaces;

/// A robot by its model. Its joints have the names of a simulation file.
pub struct Stated {
    pub model: Model,
    /// Motors, drives and gravity.
    pub start: RobotStart,
    /// What is left out of the model.
    pub notes: Vec<Note>,
}

/// What the model file at `path` states.
///
/// # Errors
/// Where it cannot be used.
pub fn stated(path: &Path) -> Result<Stated> {
    let (model, robot) = model_file::read_driven(path)?;
    let mut motors = robot.as_ref().map(stated_motors).unwrap_or_default();
    let commands = model_file::commands(path)?;
    let mut drives = stated_drives(&commands);
    let names: Vec<String> = model.joints().into_iter().map(|joint| joint.name.clone()).collect();
    let model = model_file::keyed(model);
    for (joint, name) in model.joints().into_iter().zip(&names) {
        motors.iter_mut().filter(|motor| motor.joint == *name).for_each(|motor| motor.joint.clone_from(&joint.name));
        drives.iter_mut().filter(|drive| drive.joint == *name).for_each(|drive| drive.joint.clone_from(&joint.name));
    }
    let gravity = robot.as_ref().and_then(stated_gravity);
    let of_model = model.notes.iter().cloned().chain(scaled_commands(&motors));
    let notes = of_model.chain(interfaces::notes(&commands)).collect();
    Ok(Stated { model, start: RobotStart { motors, drives, gravity, ..RobotStart::default() }, notes })
}
