//! The simulation file of a robot from its model, and from a recording in episodes.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_formats::{Contents, Episodes, ReadOptions, contents_with, read_calibration, shell_word};
use tunenet_sim::arm::{JointKind, Model, model_file};
use tunenet_sim::robot::{stated_gravity, stated_motors};
use tunenet_sim::simulation_file::{JointColumns, RobotStart, position_channel, robot_template};

use super::columns::{columns, held, unnameable};
use super::limits::by_limits;
use crate::args::Init;
use crate::files::names::in_one_folder;

/// The file of a robot, and what to type next.
pub struct Started {
    pub text: String,
    /// What follows `tunenet diagnose --sim FILE`.
    pub recording: Option<String>,
    pub notes: Vec<Note>,
}

/// The file of the robot whose model `urdf` is.
///
/// # Errors
/// Where the model or the recording cannot be used, or have no joint in common.
pub fn started(options: &Init, urdf: &Path, out: &Path) -> Result<Started> {
    let (model, robot) = model_file::read_driven(urdf)?;
    let motors = robot.as_ref().map(stated_motors).unwrap_or_default();
    let gravity = robot.as_ref().and_then(stated_gravity);
    let mut start = RobotStart { motors, gravity, ..RobotStart::default() };
    let (mut recording, mut notes) = (None, model.notes.clone());
    notes.extend(unnameable(&model)?);
    if let Some(from) = &options.from {
        let found = episodes(from, options)?;
        let columns = columns(options, &model, &found)?;
        notes.extend(held(&model, &columns));
        notes.extend(found.notes.iter().cloned());
        recording = Some(flags(from, options, &model, (&found, &columns)));
        start.columns = Some(columns);
        start.rate_hz = found.rate_hz.filter(|rate| *rate > 0.0);
    }
    let text = robot_template(&seen_from(out, urdf)?.to_string_lossy(), &model, &start);
    Ok(Started { text, recording, notes })
}

/// Next to the file the model's name does; else its whole path.
fn seen_from(out: &Path, model: &Path) -> Result<PathBuf> {
    Ok(match model.file_name().filter(|_| in_one_folder(out, model)) {
        Some(name) => name.into(),
        None => std::path::absolute(model)?,
    })
}

fn episodes(from: &Path, options: &Init) -> Result<Episodes> {
    let units = options.calibration.as_ref().map(read_calibration).transpose()?.unwrap_or_default();
    match contents_with(from, &ReadOptions { units, ..ReadOptions::default() })? {
        Contents::Episodes(found) => Ok(found),
        Contents::Table(_) | Contents::Log(_) => {
            let message = "expected a recording in episodes (LeRobot, HDF5), found another one";
            let hint =
                "leave `--from` out, and name its columns in the file: `column` of the inputs, `observe` of the joints";
            Err(tunenet_formats::Error::file(from, message, hint).into())
        }
    }
}

/// The recording as an argument, with what it has to be read with. Units are proposed, never taken as known.
fn flags(from: &Path, options: &Init, model: &Model, (found, columns): (&Episodes, &[JointColumns])) -> String {
    let mut words = vec![shell_word(&from.to_string_lossy())];
    let joints = model.joints();
    let mapped = columns.iter().filter_map(|columns| {
        let joint = joints.iter().find(|joint| joint.name == columns.joint)?;
        let channel = position_channel(joint, Some(&columns.state));
        (!channel.starts_with(&format!("{}_", columns.state))).then(|| format!("{channel}={}", columns.state))
    });
    let mapped: Vec<String> = mapped.collect();
    if !mapped.is_empty() {
        words.extend(["--columns".into(), shell_word(&mapped.join(","))]);
    }
    let open = |columns: &&JointColumns| {
        let column = found.columns.iter().find(|column| column.name == columns.state);
        column.is_some_and(|column| column.unit.is_none())
    };
    if let Some(file) = &options.calibration {
        words.extend(["--calibration".into(), shell_word(&file.to_string_lossy())]);
    }
    // A column whose numbers suggest nothing, nor the limits of its joint, gets a place to fill in.
    let unit = |columns: &JointColumns| {
        let column = found.columns.iter().find(|column| column.name == columns.state);
        let joint = joints.iter().find(|joint| joint.name == columns.joint);
        let turns = joint.is_none_or(|joint| joint.kind != JointKind::Prismatic);
        let left = || by_limits(column?.range?, joint.map(|joint| (joint.limits.lower, joint.limits.upper))?, turns);
        // The step of a slide's numbers says nothing of angles.
        let by_step = column.filter(|_| turns).and_then(|column| column.proposed.clone());
        let proposed = by_step.or_else(left);
        format!("{}={}", columns.state, proposed.unwrap_or_else(|| "UNIT".into()))
    };
    let units: Vec<String> = columns.iter().filter(open).map(unit).collect();
    if !units.is_empty() {
        words.extend(["--units".into(), shell_word(&units.join(","))]);
    }
    words.join(" ")
}
