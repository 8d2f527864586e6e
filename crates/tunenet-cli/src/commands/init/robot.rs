//! The simulation file of a robot from its model, and from a recording.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_formats::{Contents, ReadOptions, contents_with, read_calibration};
use tunenet_sim::arm::Joint;
use tunenet_sim::simulation_file::{JointColumns, LogColumn, position_channel, robot_template, seen_from};

use super::asked::refuse_unnamed;
use super::columns::{Columns, columns};
use super::flags::flags;
use super::joint_notes::{held, in_other_messages, unnameable, without_actuator};
use super::messages::in_one_message;
use super::place::Place;
use super::switch::switch;
use super::typed;
use super::typed_units::Recorded;
use crate::args::Init;
use crate::commands::load::{Stated, definitions, stated};

/// The file of a robot, and what to type next.
pub struct Started {
    pub text: String,
    /// What follows `tunenet diagnose --sim FILE`.
    pub recording: Option<String>,
    /// Where the recording has the numbers of each joint.
    pub columns: Vec<Columns>,
    /// The column that says whether motors are on.
    pub switch: Option<LogColumn>,
    pub notes: Vec<Note>,
}

/// The file of the robot whose model `urdf` is.
///
/// # Errors
/// Where the model or the recording cannot be used, or have no joint in common.
pub fn started(options: &Init, urdf: &Path, out: &Path) -> Result<Started> {
    let Stated { model, mut start, mut notes } = stated(urdf)?;
    let (mut recording, mut found) = (None, Vec::new());
    notes.extend(unnameable(&model)?);
    notes.extend(without_actuator(&model, &start));
    if let Some(from) = &options.from {
        let units = options.calibration.as_ref().map(read_calibration).transpose()?.unwrap_or_default();
        let definitions = definitions(&options.definitions)?;
        let reading = ReadOptions { units, definitions, ..ReadOptions::default() };
        let contents = contents_with(from, &reading)?;
        let named = contents.named_columns();
        refuse_unnamed(from, &reading, &named)?;
        let columns = columns(options, from, (&model, &start), &named)?;
        let (columns, apart) = in_one_message(columns, &contents);
        notes.extend(held(&model, &columns, &apart));
        notes.extend(in_other_messages(&apart));
        match &contents {
            Contents::Episodes(found) => {
                notes.extend(found.notes.iter().cloned());
                recording = Some(flags(from, options, (&model, &start), (found, &columns)));
                start.rate_hz = found.rate_hz.filter(|rate| *rate > 0.0);
            }
            Contents::Table(_) | Contents::Log(_) => {
                let recorded = Recorded { path: from, contents: &contents, reading };
                let (typed, rate_hz) = typed::flags(&recorded, &model, &start, &columns)?;
                (recording, start.rate_hz) = (Some(typed), rate_hz);
            }
        }
        let channel = |joint: &Joint, columns: &Columns| match &contents {
            Contents::Episodes(_) => position_channel(joint, Some(&columns.state.column)),
            Contents::Table(_) | Contents::Log(_) => typed::channel(joint, &columns.state),
        };
        let joints = model.joints();
        let one = |columns: &Columns| {
            let joint = joints.iter().find(|joint| joint.name == columns.joint)?;
            let Place { column, topic } = columns.command.clone();
            let command = LogColumn { column, topic };
            Some(JointColumns { joint: joint.name.clone(), channel: channel(joint, columns), command })
        };
        start.switch = switch(&named);
        start.columns = Some(columns.iter().filter_map(one).collect());
        found = columns;
    }
    let seen = seen_from(out, urdf).map_or_else(|| std::path::absolute(urdf), Ok)?;
    let text = robot_template(&seen.to_string_lossy(), &model, &start);
    Ok(Started { text, recording, columns: found, switch: start.switch, notes })
}
