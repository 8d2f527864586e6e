//! The simulation file of a robot from its model, and from a recording in episodes.

use std::path::Path;

use anyhow::Result;
use tunenet_core::observation::Note;
use tunenet_core::{Error, Origin};
use tunenet_formats::{Contents, Episodes, ReadOptions, contents_with, read_calibration};
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::findings;
use tunenet_sim::simulation_file::{is_name, robot_template, seen_from};

use super::columns::{columns, held, listed};
use super::flags::flags;
use super::stated::{Stated, stated};
use crate::args::Init;

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
    let Stated { model, mut start, mut notes } = stated(urdf)?;
    let mut recording = None;
    notes.extend(unnameable(&model)?);
    if let Some(from) = &options.from {
        let found = episodes(from, options)?;
        let columns = columns(options, &model, &found)?;
        notes.extend(held(&model, &columns));
        notes.extend(found.notes.iter().cloned());
        recording = Some(flags(from, options, (&model, &start), (&found, &columns)));
        start.columns = Some(columns);
        start.rate_hz = found.rate_hz.filter(|rate| *rate > 0.0);
    }
    let seen = seen_from(out, urdf).map_or_else(|| std::path::absolute(urdf), Ok)?;
    let text = robot_template(&seen.to_string_lossy(), &model, &start);
    Ok(Started { text, recording, notes })
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
