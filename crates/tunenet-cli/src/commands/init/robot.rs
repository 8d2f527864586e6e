//! The simulation file of a robot from its model, and from a recording.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_core::{Error, Origin};
use tunenet_formats::{Contents, ReadOptions, contents_with, read_calibration};
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::findings;
use tunenet_sim::simulation_file::{JointColumns, RobotStart, is_name, position_channel, robot_template, seen_from};

use super::asked::refuse_unnamed;
use super::columns::{Columns, columns};
use super::flags::flags;
use super::place::Place;
use super::typed;
use super::typed_units::Recorded;
use crate::args::Init;
use crate::commands::load::{Stated, definitions, stated};
use crate::view::text::listed;

/// The file of a robot, and what to type next.
pub struct Started {
    pub text: String,
    /// What follows `tunenet diagnose --sim FILE`.
    pub recording: Option<String>,
    /// Where the recording has the numbers of each joint.
    pub columns: Vec<Columns>,
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
    notes.extend(without_actuator(urdf, &model, &start));
    if let Some(from) = &options.from {
        let units = options.calibration.as_ref().map(read_calibration).transpose()?.unwrap_or_default();
        let definitions = definitions(&options.definitions)?;
        let reading = ReadOptions { units, definitions, ..ReadOptions::default() };
        let contents = contents_with(from, &reading)?;
        let named = contents.named_columns();
        refuse_unnamed(from, &reading, &named)?;
        let columns = columns(options, from, (&model, &start), &named)?;
        notes.extend(held(&model, &columns));
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
            Some(JointColumns { joint: joint.name.clone(), channel: channel(joint, columns), command: column, topic })
        };
        start.columns = Some(columns.iter().filter_map(one).collect());
        found = columns;
    }
    let seen = seen_from(out, urdf).map_or_else(|| std::path::absolute(urdf), Ok)?;
    let text = robot_template(&seen.to_string_lossy(), &model, &start);
    Ok(Started { text, recording, columns: found, notes })
}

/// That an MJCF says nothing of what drives its joints.
fn without_actuator(path: &Path, model: &Model, start: &RobotStart) -> Option<Note> {
    let mjcf = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml"));
    let joints = model.joints();
    let lacking = joints.iter().filter(|joint| is_name(&joint.name) && start.motor(&joint.name).is_none());
    let lacking: Vec<&str> = lacking.map(|joint| joint.name.as_str()).collect();
    (mjcf && !lacking.is_empty()).then(|| {
        let text = format!("joints for which the model has no actuator: {}", listed(lacking));
        let remedy = "set `drive` under [joints], where \"position\" is written, and the bounds of its parameters";
        Note::new(findings::MODEL_LEFT_OUT, text, remedy)
    })
}

/// That the names of joints cannot stand in a simulation file.
///
/// # Errors
/// [`Error::Setting`] where no joint of the model has a name that can.
fn unnameable(model: &Model) -> Result<Option<Note>> {
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
fn held(model: &Model, columns: &[Columns]) -> Option<Note> {
    let joints = model.joints();
    let lost = joints.iter().filter(|joint| columns.iter().all(|columns| columns.joint != joint.name));
    let lost: Vec<&str> = lost.map(|joint| joint.name.as_str()).collect();
    (!lost.is_empty()).then(|| {
        let text = format!("joints without a column of positions and one of commands are held at 0: {}", listed(lost));
        Note::new(findings::URDF_HELD, text, "name their columns with `--joints JOINT=COLUMN:COMMAND`")
    })
}
