//! What `--joints` says, and joints in messages.

use std::path::Path;

use anyhow::Result;
use tunenet_core::text::visible;
use tunenet_core::{Error, Origin};
use tunenet_formats::{Error as FileError, NamedColumn, ReadOptions, read, shell_word};
use tunenet_sim::arm::Joint;
use tunenet_sim::arm::model_file::key_of;

use super::place::Place;
use crate::args::Init;
use crate::view::text::listed;

/// What `--joints` says of a joint: its column, and that of its command where it is said.
pub type Asked<'a> = (&'a str, (&'a str, Option<&'a str>));

/// What `--joints` says, where all of it is there.
pub fn asked<'a>(options: &'a Init, joints: &[&Joint], found: &[NamedColumn]) -> Result<Vec<Asked<'a>>> {
    let there = |name: &str| found.iter().any(|column| column.name == name);
    let all: Vec<Asked> = options
        .joints
        .iter()
        .map(|(joint, column)| match column.split_once(':') {
            Some((state, command)) => (joint.as_str(), (state, Some(command))),
            None => (joint.as_str(), (column.as_str(), None)),
        })
        .collect();
    for (joint, (state, command)) in &all {
        if !joints.iter().any(|known| is_called(known, joint)) {
            let names = listed(joints.iter().map(|joint| joint.name.as_str()));
            return refuse(format!("a joint of the model ({names})"), format!("`{}`", visible(joint)));
        }
        let absent = |name: &&str| !there(name);
        let lost = Some(*state).filter(absent).or(command.filter(|command| !Place::is_in(command, found)));
        if let Some(lost) = lost {
            let names = listed(found.iter().map(|column| column.name.as_str()));
            return refuse(format!("a column of the recording ({names})"), format!("`{}`", visible(lost)));
        }
    }
    let mut given: Vec<&str> = all.iter().map(|(_, (state, _))| *state).collect();
    given.sort_unstable();
    if let Some(two) = given.windows(2).find(|two| two[0] == two[1]) {
        return refuse("each column for one joint".into(), format!("`{}` for several", visible(two[0])));
    }
    Ok(all)
}

pub fn refuse<T>(expected: String, found: String) -> Result<T> {
    Err(Error::Setting { origin: Origin::Flag, name: "--joints", expected, found }.into())
}

/// Whether a name is that of the joint, or what the model calls it.
pub fn is_called(joint: &Joint, name: &str) -> bool {
    joint.name == name || joint.name == key_of(name)
}

/// That joints have positions and no commands, and what to type: numbers without names are given in the order of the joints.
pub fn without_commands(from: &Path, seen: &[(&str, &Place)], found: &[NamedColumn]) -> FileError {
    let joints = listed(seen.iter().map(|(joint, _)| *joint));
    let place = seen[0].1.topic.as_ref().map_or_else(String::new, |topic| format!(" in `{}`", visible(topic)));
    let message = format!("expected commands of the joints {joints}, found only their positions{place}");
    let unnamed: Vec<&NamedColumn> = found.iter().filter(|column| column.is_unnamed_command()).collect();
    let topic = unnamed.first().and_then(|column| column.topic.as_deref());
    let numbers = unnamed.iter().filter(|column| column.topic.as_deref() == topic);
    let pair = |((joint, state), number): (&(&str, &Place), &&NamedColumn)| {
        format!("{joint}={}:{}:{}", state.column, topic.unwrap_or_default(), number.name)
    };
    let pairs: Vec<String> = seen.iter().zip(numbers).map(pair).collect();
    let hint = if pairs.is_empty() {
        "record what the joints are sent as well, or name it: `--joints JOINT=COLUMN:COMMAND`, COMMAND as `/TOPIC:COLUMN` in a log"
            .to_owned()
    } else {
        format!("if the controller has its joints in this order: `--joints {}`", shell_word(&pairs.join(",")))
    };
    FileError::file(from, message, hint)
}

/// Refuses a recording without a column of numbers as whoever reads it does, and one in which a name stands twice.
///
/// # Errors
/// Where it is such a recording.
pub fn refuse_unnamed(from: &Path, reading: &ReadOptions, named: &[NamedColumn]) -> Result<()> {
    if named.is_empty() {
        read(from, reading)?;
    }
    let twice = named.iter().enumerate().find(|(at, column)| named[..*at].contains(column));
    let Some((_, twice)) = twice else { return Ok(()) };
    let message = format!("expected one column `{}`, found two", visible(&twice.name));
    Err(FileError::file(from, message, "rename one of them, or leave it out").into())
}
