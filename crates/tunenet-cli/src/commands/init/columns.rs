//! Which column of a recording is which joint of a model.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_formats::NamedColumn;
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::simulation_file::RobotStart;

use super::asked::{asked, is_called, refuse, without_commands};
use super::place::{Place, position};
use super::topics::{commands, measured};
use crate::args::Init;
use crate::view::text::listed;

/// What stands before the name of a joint where a column has its command.
pub const ACTION: &str = "action.";

/// Where the recording has the numbers of a joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    /// Name of the joint in the model.
    pub joint: String,
    /// The column of its positions.
    pub state: Place,
    /// The column of its commands.
    pub command: Place,
}

impl Columns {
    /// In words: `elbow: position.elbow of /joint_states, commands position.elbow of /commands`.
    pub fn described(&self) -> String {
        format!("{}: {}, commands {}", self.joint, self.state.described(), self.command.described())
    }

    /// As an object.
    pub fn object(&self) -> Value {
        let Self { joint, state, command } = self;
        json!({ "joint": joint, "column": state.column, "topic": state.topic,
            "command": { "column": command.column, "topic": command.topic } })
    }
}

/// The columns of every joint that the recording has, in the order of the model.
///
/// # Errors
/// [`Setting`](tunenet_core::Error::Setting) where no joint of the model is in the recording, or `--joints` names what is not there.
pub fn columns(
    options: &Init,
    from: &Path,
    (model, start): (&Model, &RobotStart),
    found: &[NamedColumn],
) -> Result<Vec<Columns>> {
    let joints = model.joints();
    let asked = asked(options, &joints, found)?;
    let of_asked = |joint: &Joint| asked.iter().find(|(name, _)| is_called(joint, name)).map(|(_, column)| *column);
    let states = measured(options, found, &joints.iter().map(|joint| joint.name.as_str()))?;
    let one = |joint: &&Joint| -> Result<Option<(String, Place, Option<Place>)>> {
        let drive = start.drive(&joint.name);
        let given = of_asked(joint);
        let state = match given {
            Some((state, _)) => found.iter().find(|column| column.name == state && is_in(column, states.as_deref())),
            None => position(&joint.name, &found.iter().filter(|column| is_in(column, states.as_deref()))),
        };
        let Some(state) = state else { return Ok(None) };
        let command = match given {
            Some((_, Some(command))) => Some(Place::parse(command, found, &joint.name)),
            // Of a column that is named, the command is called after it.
            Some((column, None)) => {
                let own = format!("{ACTION}{column}");
                match found.iter().find(|known| known.name == own) {
                    Some(own) => Some(Place::of(own)),
                    None => commands(&[&joint.name, column], drive, found, states.as_deref())?,
                }
            }
            None => commands(&[&joint.name], drive, found, states.as_deref())?,
        };
        Ok(Some((joint.name.clone(), Place::of(state), command)))
    };
    let seen: Vec<Option<(String, Place, Option<Place>)>> = joints.iter().map(one).collect::<Result<_>>()?;
    let seen: Vec<(String, Place, Option<Place>)> = seen.into_iter().flatten().collect();
    let commanded = |(joint, state, command): &(String, Place, Option<Place>)| {
        Some(Columns { joint: joint.clone(), state: state.clone(), command: command.clone()? })
    };
    let all: Vec<Columns> = seen.iter().filter_map(commanded).collect();
    if all.is_empty() && !seen.is_empty() {
        let seen: Vec<(&str, &Place)> = seen.iter().map(|(joint, state, _)| (joint.as_str(), state)).collect();
        return Err(without_commands(from, &seen, found).into());
    }
    if all.is_empty() {
        let names = listed(joints.iter().map(|joint| joint.name.as_str()));
        let columns = listed(found.iter().map(|column| column.name.as_str()));
        let expected = format!(
            "which column is which joint of the model ({names}), each with its command `{ACTION}COLUMN` or as JOINT=COLUMN:COMMAND"
        );
        return refuse(expected, format!("no names in common with the columns {columns}"));
    }
    Ok(all)
}

fn is_in(column: &NamedColumn, topic: Option<&str>) -> bool {
    column.topic.as_deref() == topic
}
