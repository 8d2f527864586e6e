//! A small arm (SO-101) that follows commands, from a data set of four episodes, each of them held out in turn, with its published model.

use std::path::Path;

use anyhow::{Context, Result, bail};
use serde_json::Value;
use toml_edit::DocumentMut;

use super::lagged::LaggedJoint;
use super::{Row, asked};
use crate::goals::ARM_TIMES;

/// It meets objects, which no simulation here has.
const GRIPPER: &str = "gripper";

/// The rows of the arm with this model and data set; what the tool is given and says stays in `folder`.
pub fn rows(model: &Path, data: &Path, folder: &Path) -> Result<Vec<Row>> {
    let (from, to) = (data.display().to_string(), folder.join("arm.toml"));
    let written = to.display().to_string();
    asked(
        &["init", "robot", "--json", "--model", &model.display().to_string(), "--from", &from, "--out", &written],
        folder,
    )?;
    std::fs::write(&to, without_gripper(&std::fs::read_to_string(&to)?)?)?;
    let contents = asked(&["inspect", "--json", &from], folder)?;
    let units = units(&contents)?;
    let episodes = contents["episodes"].as_array().context("expected `episodes`")?;
    let all = || 0..episodes.len();
    all().map(|held| one(&contents, held, &units, (data, &written), folder)).collect()
}

/// The row of one held-out episode.
fn one(contents: &Value, held: usize, units: &str, (data, file): (&Path, &str), folder: &Path) -> Result<Row> {
    let episodes = contents["episodes"].as_array().context("expected `episodes`")?;
    let others: Vec<String> = (0..episodes.len()).filter(|i| *i != held).map(|i| i.to_string()).collect();
    let others = others.join(",");
    let name = episodes[held]["name"].as_str().context("expected the name of an episode")?;
    let frames = episodes[held]["frames"].as_u64().context("expected `frames`")?;
    let (from, episode) = (data.display().to_string(), data.join(name).display().to_string());
    let words = ["diagnose", "--json", "--quiet", "--sim", file, "--units", units, "--episodes", &others, &from];
    let answer = asked(&[&words[..], &["--held-out", &episode]].concat(), folder)?;
    let gaps = answer["gaps"].as_array().context("expected `gaps`")?;
    let (mut ours, mut theirs, mut met) = (Vec::new(), Vec::new(), true);
    for gap in gaps {
        // The one of all channels has none.
        let Some(joint) = gap["channel"].as_str() else { continue };
        let left = gap["held_out"]["after"].as_f64().context("expected `held_out`")?;
        let lagged = LaggedJoint { name: joint, data, units }.held_out_rad(&others, name, frames, folder)?;
        met &= left <= ARM_TIMES * lagged;
        ours.push(format!("{:.1}", 1e3 * left));
        theirs.push(format!("{:.1}", 1e3 * lagged));
    }
    if ours.is_empty() {
        bail!("expected `gaps` of joints");
    }
    let rollouts = answer["rollouts"].as_f64().context("expected `rollouts`")?;
    Ok(Row {
        what: format!("arm, {name} held out: root mean square of joints 1 to {}, mrad", ours.len()),
        aim: format!("each at most {ARM_TIMES} times the other"),
        measured: format!("{} ({rollouts} rollouts)", ours.join(" ")),
        others: format!("{} by delay, lag, gain, offset and speed limit of each joint", theirs.join(" ")),
        met: Some(met),
    })
}

/// What the numbers of the joints suggest as `--units`.
fn units(contents: &Value) -> Result<String> {
    let columns = contents["columns"].as_array().context("expected `columns`")?;
    let joint = |column: &Value| {
        let name = column["name"].as_str().filter(|name| !name.starts_with("action.") && *name != GRIPPER)?;
        Some(format!("{name}={}", column["proposed"].as_str()?))
    };
    Ok(columns.iter().filter_map(joint).collect::<Vec<_>>().join(","))
}

/// The simulation file without the tables of the gripper.
fn without_gripper(text: &str) -> Result<String> {
    let mut file: DocumentMut = text.parse().context("the simulation file of the arm")?;
    for (_, item) in file.iter_mut() {
        let Some(table) = item.as_table_like_mut() else { continue };
        let of_it: Vec<String> =
            table.iter().map(|(key, _)| key.to_owned()).filter(|key| key.starts_with(GRIPPER)).collect();
        for key in of_it {
            table.remove(&key);
        }
    }
    Ok(file.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gripper_leaves_no_table() {
        let text = "[joints.a]\nx = 1\n[joints.gripper]\nx = 2\n[parameters.gripper__zero]\nvalue = 0.0\n[parameters.a__zero]\nvalue = 0.0\n";
        let left = without_gripper(text).unwrap();
        assert!(!left.contains("gripper") && left.contains("[joints.a]") && left.contains("[parameters.a__zero]"));
    }

    #[test]
    fn units_are_those_of_positions() {
        let column = |name: &str, unit: &str| serde_json::json!({ "name": name, "proposed": unit });
        let contents = serde_json::json!({ "columns": [column("action.a", "3deg"), column("a", "2deg"), column("gripper", "1deg")] });
        assert_eq!(units(&contents).unwrap(), "a=2deg");
    }
}
