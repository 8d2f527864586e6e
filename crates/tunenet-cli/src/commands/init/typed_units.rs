//! The units of the columns of a table or a log: by names, by the type of a message, by the step of the numbers, or by limits.

use std::collections::BTreeMap;
use std::path::Path;

use tunenet_formats::{Contents, EpisodeColumn, ReadOptions, Result, suggested_units, unit_of_name};
use tunenet_sim::arm::{Joint, JointKind};
use tunenet_sim::robot::Drive;

use super::columns::Columns;
use super::limits::by_limits;
use super::place::Place;

/// What stands where a unit is to be filled in.
const OPEN: &str = "UNIT";
/// How the names of numbers in messages begin that are in SI units by the definition of their type.
const IN_SI: [&str; 3] = ["position.", "velocity.", "effort."];

/// A recording that is one table, or one topic of a log.
pub struct Recorded<'a> {
    pub path: &'a Path,
    pub contents: &'a Contents,
    pub reading: ReadOptions,
}

/// What its columns suggest, by where they stand.
pub type Suggested = BTreeMap<(Option<String>, String), EpisodeColumn>;

pub fn own_unit(joint: &Joint) -> &'static str {
    if joint.kind == JointKind::Prismatic { "m" } else { "rad" }
}

pub fn is_length_or_angle(unit: &str, joint: &Joint) -> bool {
    let known: &[&str] = if joint.kind == JointKind::Prismatic { &["m", "mm", "cm"] } else { &["rad", "deg"] };
    known.contains(&unit)
}

/// The unit of positions: by the type of the message, by the step of the numbers, or by the limits of the joint.
pub fn unit(state: &Place, joint: &Joint, suggested: Option<&EpisodeColumn>) -> String {
    let turns = joint.kind != JointKind::Prismatic;
    if state.is_in_si() {
        return own_unit(joint).into();
    }
    if let Some(unit) = unit_of_name(&state.column).filter(|unit| is_length_or_angle(unit, joint)) {
        return unit.into();
    }
    // The step of a slide's numbers says nothing of angles.
    let by_step = suggested.filter(|_| turns).and_then(|column| column.proposed.clone());
    let left = || by_limits(suggested?.range?, (joint.limits.lower, joint.limits.upper), turns);
    let found = by_step.or_else(left).filter(|unit| is_length_or_angle(unit, joint));
    found.unwrap_or_else(|| OPEN.into())
}

/// The unit of commands that has to be stated: `None` where the name has one, or it is the project's own.
pub fn command_unit(
    joint: &Joint,
    drive: Drive,
    columns: &Columns,
    of_state: Option<&EpisodeColumn>,
) -> Option<String> {
    let command = &columns.command;
    // Numbers of ROS are in SI units (REP 103).
    if command.topic.is_some() || unit_of_name(&command.column).is_some() {
        return None;
    }
    let found = if drive == Drive::Position { unit(&columns.state, joint, of_state) } else { OPEN.to_owned() };
    (found != own_unit(joint)).then_some(found)
}

/// What the positions suggest, and their rate.
///
/// # Errors
/// Where they cannot be read.
pub fn suggested(recorded: &Recorded, options: &ReadOptions, columns: &[Columns]) -> Result<(Suggested, Option<f64>)> {
    let Some(first) = columns.first() else { return Ok(Default::default()) };
    let topic = first.state.topic.clone();
    let names: Vec<String> = columns.iter().map(|columns| columns.state.column.clone()).collect();
    let options = ReadOptions { topic: topic.clone(), ..options.clone() };
    let (found, rate_hz) = suggested_units(recorded.path, &options, &names)?;
    Ok((found.into_iter().map(|column| ((topic.clone(), column.name.clone()), column)).collect(), rate_hz))
}

impl Place {
    pub fn key(&self) -> (Option<String>, String) {
        (self.topic.clone(), self.column.clone())
    }

    /// Whether the type of its message states SI units.
    pub fn is_in_si(&self) -> bool {
        self.topic.is_some() && IN_SI.iter().any(|start| self.column.starts_with(start))
    }
}
