//! What to type to read a table or a log for the joints of a robot, and the channels of its positions.

use tunenet_core::observation::plain;
use tunenet_formats::{Contents, Result, shell_word, unit_of_name};
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::robot::Drive;
use tunenet_sim::simulation_file::{RobotStart, command_input};

use super::columns::Columns;
use super::place::Place;
use super::typed_clock::{Read, clock, read};
use super::typed_units::{Recorded, command_unit, is_length_or_angle, own_unit, unit};

/// The channel of a joint's positions: in a table, the name of the column in the project's own unit, so that it is found there.
pub fn channel(joint: &Joint, state: &Place) -> String {
    let unit = own_unit(joint);
    let of_column = unit_of_name(&state.column).filter(|_| state.topic.is_none()).and_then(|theirs| {
        let name = plain(&state.column);
        let stem = name.strip_suffix(theirs)?.to_owned();
        is_length_or_angle(theirs, joint).then(|| format!("{stem}{unit}"))
    });
    of_column.unwrap_or_else(|| format!("{}_{unit}", plain(&joint.name)))
}

/// What follows the path of the recording on the command line, and how many rows it has in a second, where that is known.
///
/// # Errors
/// Where the recording cannot be read.
pub fn flags(
    recorded: &Recorded,
    model: &Model,
    start: &RobotStart,
    columns: &[Columns],
) -> Result<(String, Option<f64>)> {
    let mut mapped: Vec<String> = Vec::new();
    let Read { clock, suggested, rate_hz } = read(recorded, columns, clock(recorded))?;
    mapped.extend(clock.map(|(ours, theirs)| format!("{ours}={theirs}")));
    let states = columns.first().and_then(|columns| columns.state.topic.clone());
    let joints = model.joints();
    for columns in columns {
        let Some(joint) = joints.iter().find(|joint| joint.name == columns.joint) else { continue };
        let of_state = suggested.get(&columns.state.key());
        if !is_found(joint, columns) {
            mapped.push(format!(
                "{}_{}={}",
                plain(&joint.name),
                unit(&columns.state, joint, of_state),
                columns.state.column
            ));
        }
        let drive = start.drive(&joint.name);
        let own = command_input(joint, drive);
        if let Some(unit) = command_unit(joint, drive, columns, of_state)
            && let Some(stem) = own.strip_suffix(&input_unit(&own, joint, drive))
        {
            mapped.push(format!("{stem}{unit}={}", columns.command.column));
        }
    }
    let mut words = vec![shell_word(&recorded.path.to_string_lossy())];
    if let (Some(topic), Contents::Log(log)) = (&states, recorded.contents)
        && log.topics.len() > 1
    {
        words.extend(["--topic".into(), shell_word(topic)]);
    }
    if !mapped.is_empty() {
        words.extend(["--columns".into(), shell_word(&mapped.join(","))]);
    }
    Ok((words.join(" "), rate_hz))
}

/// Whether the positions are found by the names of their column and their joint.
fn is_found(joint: &Joint, columns: &Columns) -> bool {
    let state = &columns.state;
    match state.topic {
        None => channel(joint, state) != format!("{}_{}", plain(&joint.name), own_unit(joint)) || by_name(joint, state),
        Some(_) => plain(&state.column) == format!("position_{}", plain(&joint.name)),
    }
}

/// Whether a column has the joint's own name and a unit.
fn by_name(joint: &Joint, state: &Place) -> bool {
    let unit = unit_of_name(&state.column).filter(|unit| is_length_or_angle(unit, joint));
    unit.is_some_and(|unit| plain(&state.column) == format!("{}_{unit}", plain(&joint.name)))
}

/// How the name of the input ends.
fn input_unit(input: &str, joint: &Joint, drive: Drive) -> String {
    match drive {
        Drive::Velocity => format!("{}_s", own_unit(joint)),
        Drive::Torque => input.rsplit('_').next().unwrap_or_default().to_owned(),
        Drive::Position | Drive::Voltage => own_unit(joint).to_owned(),
    }
}
