//! The models of a robot.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_core::text::visible;
use tunenet_formats::shown_path;
use tunenet_models::edit::Left;
use tunenet_models::export::{BamServo, Whole, bam, isaac_lab};
use tunenet_models::{Change, Quantity};
use tunenet_sim::SimulationFile;
use tunenet_sim::arm::model_file::edited;
use tunenet_sim::observed_robot::model_path;
use tunenet_sim::robot::Drive;
use tunenet_sim::robot_changes::{Intervals, RobotChanges, robot_changes};

use super::{put, sidecar};
use crate::args::Models;
use crate::files::names::in_one_folder;
use crate::view::text::stage;

/// Writes the models of a robot with the numbers of its simulation.
///
/// # Errors
/// As [`super::write`].
pub fn write(options: &Models, file: &SimulationFile, intervals: Intervals) -> Result<()> {
    let found = robot_changes(file, intervals)?;
    for note in &found.notes {
        stage("note", note);
    }
    if let Some(out) = &options.out_model {
        write_model(out, options, file, &found)?;
    }
    if let Some(out) = &options.out_bam {
        let actuator = options.bam_actuator.clone().unwrap_or_default();
        let (text, left) = of_servos(&found, &actuator);
        put(out, &format!("{text:#}\n"))?;
        let rest = listed(&left, &found.whole);
        let rest = if rest.is_empty() { rest } else { format!(": BAM cannot express {rest}") };
        stage("bam", &format!("{}{rest}", shown_path(out)));
        stage("note", "`vin` is `supply_v` of the joint, 12 V where the simulation file does not state it");
        let others = file.robot()?.joints.iter().filter(|(_, joint)| joint.drive != Drive::Position);
        let others: Vec<String> = others.map(|(name, _)| format!("`{}`", visible(name))).collect();
        if !others.is_empty() {
            stage("note", &format!("BAM's servos follow positions, which these joints do not: {}", others.join(", ")));
        }
    }
    if let Some(out) = &options.out_isaac {
        put(out, &isaac_lab(&of_model(&found), &found.whole, options.isaac_step))?;
        stage("isaac", &shown_path(out));
    }
    Ok(())
}

/// The numbers that formats of models know: they have the stall torque as the limit of the torque.
fn of_model(found: &RobotChanges) -> Vec<Change> {
    found.changes.iter().filter(|change| change.quantity != Quantity::StallTorque).cloned().collect()
}

fn write_model(out: &Path, options: &Models, file: &SimulationFile, found: &RobotChanges) -> Result<()> {
    let model = model_path(file)?;
    let (text, done) = edited(&model, &of_model(found))?;
    put(out, &text)?;
    stage("model", &shown_path(out));
    let left: Vec<Left> = found.left.iter().chain(&done.left).cloned().collect();
    let rest = tunenet_models::export::sidecar(out, &left, &found.whole);
    sidecar::write(options, &rest, &listed(&left, &found.whole))?;
    for note in &done.notes {
        stage("note", note);
    }
    if !file.robot()?.loads.is_empty() {
        stage("note", "loads of the simulation file are not in the model");
    }
    if !in_one_folder(out, &model) {
        let text = "the copy is in another folder than the model: meshes and other files that it names are looked for from there";
        stage("note", text);
    }
    Ok(())
}

/// `speed_limit` of `elbow`, `wrist`; `time_delay`.
fn listed(left: &[Left], whole: &[Whole]) -> String {
    let mut quantities: Vec<(&str, Vec<String>)> = Vec::new();
    for one in left {
        let (name, joint) = (one.change.quantity.name(), format!("`{}`", visible(&one.change.joint)));
        match quantities.iter_mut().find(|(known, _)| *known == name) {
            Some((_, joints)) => joints.push(joint),
            None => quantities.push((name, vec![joint])),
        }
    }
    let of_joints = quantities.iter().map(|(name, joints)| format!("{name} of {}", joints.join(", ")));
    of_joints.chain(whole.iter().map(|one| one.effect.clone())).collect::<Vec<_>>().join("; ")
}

/// The parameters of BAM, of a single servo its own object, of several one for each joint; and what BAM does not have.
fn of_servos(found: &RobotChanges, actuator: &str) -> (Value, Vec<Left>) {
    let one = |joint: &str, servo: &BamServo| {
        bam(joint, &found.changes, &BamServo { actuator: actuator.to_owned(), ..servo.clone() })
    };
    let all: Vec<_> = found.servos.iter().map(|(joint, servo)| (joint, one(joint, servo))).collect();
    let text = match all.as_slice() {
        [(_, only)] => only.json.clone(),
        several => {
            let mut text = json!({});
            for (joint, bam) in several {
                text[joint.as_str()] = bam.json.clone();
            }
            text
        }
    };
    // The gain is in `error_gain`, the torque limit in the motor's own.
    let own = |left: &Left| !matches!(left.change.quantity, Quantity::PositionGain | Quantity::TorqueLimit);
    (text, all.into_iter().flat_map(|(_, bam)| bam.left).filter(own).collect())
}
