//! What to type to read a recording in episodes for the joints of a robot.

use std::path::Path;

use tunenet_formats::{Episodes, shell_word};
use tunenet_sim::arm::{JointKind, Model};
use tunenet_sim::robot::Drive;
use tunenet_sim::simulation_file::{RobotStart, position_channel};

use super::columns::{ACTION, Columns};
use super::limits::by_limits;
use crate::args::Init;

/// How columns of times are called.
const CLOCKS: [&str; 4] = ["t", "time", "timestamp", "times"];

/// The recording as an argument, with what it has to be read with. Units are proposed, never taken as known.
pub fn flags(
    from: &Path,
    options: &Init,
    (model, start): (&Model, &RobotStart),
    (found, columns): (&Episodes, &[Columns]),
) -> String {
    let mut words = vec![shell_word(&from.to_string_lossy())];
    let joints = model.joints();
    let mapped = columns.iter().filter_map(|columns| {
        let joint = joints.iter().find(|joint| joint.name == columns.joint)?;
        let state = &columns.state.column;
        let channel = position_channel(joint, Some(state));
        (!channel.starts_with(&format!("{state}_"))).then(|| format!("{channel}={state}"))
    });
    let time = found.columns.iter().find(|column| CLOCKS.contains(&column.name.to_lowercase().as_str()));
    let time = time.filter(|_| found.lacks_clock).map(|column| format!("t_s={}", column.name));
    if found.lacks_clock && time.is_none() {
        words.extend(["--rate".into(), "HZ".into()]);
    }
    let mapped: Vec<String> = time.into_iter().chain(mapped).collect();
    if !mapped.is_empty() {
        words.extend(["--columns".into(), shell_word(&mapped.join(","))]);
    }
    let open = |columns: &&Columns| {
        let column = found.columns.iter().find(|column| column.name == columns.state.column);
        column.is_some_and(|column| column.unit.is_none())
    };
    if let Some(file) = &options.calibration {
        words.extend(["--calibration".into(), shell_word(&file.to_string_lossy())]);
    }
    // A column whose numbers suggest nothing, nor the limits of its joint, gets a place to fill in.
    let unit = |columns: &Columns| {
        let column = found.columns.iter().find(|column| column.name == columns.state.column);
        let joint = joints.iter().find(|joint| joint.name == columns.joint);
        let turns = joint.is_none_or(|joint| joint.kind != JointKind::Prismatic);
        let left = || by_limits(column?.range?, joint.map(|joint| (joint.limits.lower, joint.limits.upper))?, turns);
        // The step of a slide's numbers says nothing of angles.
        let by_step = column.filter(|_| turns).and_then(|column| column.proposed.clone());
        let proposed = by_step.or_else(left);
        format!("{}={}", columns.state.column, proposed.unwrap_or_else(|| "UNIT".into()))
    };
    // What is said of a joint holds for its command where that has its name.
    let of_command = |columns: &Columns| {
        let drive = start.drive(&columns.joint);
        let own = columns.command.column != format!("{ACTION}{}", columns.state.column) || drive != Drive::Position;
        let column = found.columns.iter().find(|column| own && column.name == columns.command.column)?;
        let slides = joints.iter().any(|joint| joint.name == columns.joint && joint.kind == JointKind::Prismatic);
        let said = match (drive, slides) {
            (Drive::Position, _) => unit(columns).split_once('=')?.1.to_owned(),
            (Drive::Velocity, false) => "rad_s".into(),
            (Drive::Velocity, true) => "m_s".into(),
            (Drive::Torque, false) => "nm".into(),
            (Drive::Torque, true) => "n".into(),
            (Drive::Voltage, _) => "v".into(),
        };
        column.unit.is_none().then(|| format!("{}={said}", columns.command.column))
    };
    let units: Vec<String> =
        columns.iter().filter(open).map(unit).chain(columns.iter().filter_map(of_command)).collect();
    if !units.is_empty() {
        words.extend(["--units".into(), shell_word(&units.join(","))]);
    }
    words.join(" ")
}
