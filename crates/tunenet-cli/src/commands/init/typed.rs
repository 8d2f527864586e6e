//! What to type to read a table or a log for the joints of a robot, and the channels of its positions.

use tunenet_core::observation::plain;
use tunenet_formats::{Contents, ReadOptions, shell_word, unit_of_name};
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::robot::Drive;
use tunenet_sim::simulation_file::{RobotStart, command_input};

use super::columns::Columns;
use super::place::Place;
use super::typed_units::{Recorded, command_unit, is_length_or_angle, own_unit, suggested, unit};

/// How columns of times are called.
const CLOCKS: [&str; 6] = ["t", "time", "timestamp", "times", "stamp", "clock"];

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
pub fn flags(recorded: &Recorded, model: &Model, start: &RobotStart, columns: &[Columns]) -> (String, Option<f64>) {
    let mut mapped: Vec<String> = Vec::new();
    let clock = clock(recorded);
    mapped.extend(clock.as_ref().map(|column| format!("t_s={column}")));
    let states = columns.first().and_then(|columns| columns.state.topic.clone());
    let options = ReadOptions {
        columns: clock.iter().map(|column| ("t_s".to_owned(), column.clone())).collect(),
        ..recorded.reading.clone()
    };
    let (suggested, rate_hz) = suggested(recorded, &options, columns);
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
    (words.join(" "), rate_hz)
}

/// The column of times of a table that none is known of.
fn clock(recorded: &Recorded) -> Option<String> {
    let Contents::Table(table) = recorded.contents else { return None };
    if table.columns.iter().any(|column| column.read_as.as_deref() == Some("t_s")) {
        return None;
    }
    let names = || recorded.named.iter().map(|column| column.name.as_str());
    let known = names().find(|name| CLOCKS.contains(&plain(name).as_str()));
    Some(known.map_or_else(|| "COLUMN".to_owned(), str::to_owned))
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
