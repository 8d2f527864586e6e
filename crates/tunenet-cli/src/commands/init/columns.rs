//! Which column of a recording is which joint of a model.

use anyhow::Result;
use tunenet_core::observation::{Note, plain};
use tunenet_core::text::visible;
use tunenet_core::{Error, Origin};
use tunenet_formats::Episodes;
use tunenet_sim::arm::model_file::key_of;
use tunenet_sim::arm::{Joint, Model};
use tunenet_sim::findings;
use tunenet_sim::simulation_file::JointColumns;

use crate::args::Init;

/// What stands before the name of a joint where a column has its command.
pub const ACTION: &str = "action.";
/// Most names that a message lists.
const MOST_LISTED: usize = 12;

/// The columns of every joint that the recording has, in the order of the model.
///
/// # Errors
/// [`Error::Setting`] where no joint of the model is in the recording, or `--joints` names what is not there.
pub fn columns(options: &Init, model: &Model, found: &Episodes) -> Result<Vec<JointColumns>> {
    let joints = model.joints();
    let refuse = |expected: String, found: String| {
        Err(Error::Setting { origin: Origin::Flag, name: "--joints", expected, found }.into())
    };
    let there = |name: &str| found.columns.iter().any(|column| column.name == name);
    for (joint, column) in &options.joints {
        if !joints.iter().any(|known| is_called(known, joint)) {
            let names = listed(joints.iter().map(|joint| joint.name.as_str()));
            return refuse(format!("a joint of the model ({names})"), format!("`{}`", visible(joint)));
        }
        let (state, command) = column.split_once(':').unwrap_or((column, column));
        if !there(state) || !there(command) {
            let names = listed(found.columns.iter().map(|column| column.name.as_str()));
            return refuse(
                format!("a column of the recording ({names})"),
                format!("`{}`", visible(if there(state) { command } else { state })),
            );
        }
    }
    let mut given: Vec<&str> =
        options.joints.iter().map(|(_, column)| column.split(':').next().unwrap_or(column)).collect();
    given.sort_unstable();
    if let Some(two) = given.windows(2).find(|two| two[0] == two[1]) {
        return refuse("each column for one joint".into(), format!("`{}` for several", visible(two[0])));
    }
    let one = |joint: &&Joint| {
        let mapped = options.joints.iter().find(|(name, _)| is_called(joint, name)).map(|(_, column)| column.clone());
        let same = |name: &str| plain(position(name)) == plain(&joint.name);
        let state = mapped.or_else(|| found.columns.iter().map(|c| c.name.clone()).find(|name| same(name)))?;
        let (state, command) = match state.split_once(':') {
            Some((state, command)) => (state.to_owned(), command.to_owned()),
            None => (state.clone(), format!("{ACTION}{state}")),
        };
        there(&command).then(|| JointColumns { joint: joint.name.clone(), state, command })
    };
    let all: Vec<JointColumns> = joints.iter().filter_map(one).collect();
    if all.is_empty() {
        let names = listed(joints.iter().map(|joint| joint.name.as_str()));
        let columns = listed(found.columns.iter().map(|column| column.name.as_str()));
        return refuse(
            format!(
                "which column is which joint of the model ({names}), each with its command `{ACTION}COLUMN` or as JOINT=COLUMN:COMMAND"
            ),
            format!("no names in common with the columns {columns}"),
        );
    }
    Ok(all)
}

/// The joint whose position a column is: `elbow` of `elbow.pos`, where the recording has `elbow.vel` as well.
fn position(column: &str) -> &str {
    [".pos", ".position"].iter().find_map(|ending| column.strip_suffix(ending)).unwrap_or(column)
}

/// Whether a name is that of the joint, or what the model calls it.
fn is_called(joint: &Joint, name: &str) -> bool {
    joint.name == name || joint.name == key_of(name)
}

/// That joints of the model are not in the recording.
pub fn held(model: &Model, columns: &[JointColumns]) -> Option<Note> {
    let joints = model.joints();
    let lost = joints.iter().filter(|joint| columns.iter().all(|columns| columns.joint != joint.name));
    let lost: Vec<&str> = lost.map(|joint| joint.name.as_str()).collect();
    (!lost.is_empty()).then(|| {
        let text = format!("joints without a column of positions and one of commands are held at 0: {}", listed(lost));
        Note::new(findings::URDF_HELD, text, "name their columns with `--joints JOINT=COLUMN`")
    })
}

/// Names in a message.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{}`", visible(name))).collect();
    match names.len().saturating_sub(MOST_LISTED) {
        0 if names.is_empty() => "none".into(),
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..MOST_LISTED].join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::position;

    #[test]
    fn a_column_of_positions_is_its_joint() {
        let of = ["elbow.pos", "left.elbow.position", "elbow", "elbow.vel"].map(position);
        assert_eq!(of, ["elbow", "left.elbow", "elbow", "elbow.vel"]);
    }
}
