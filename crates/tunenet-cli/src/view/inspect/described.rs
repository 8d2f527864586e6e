//! What `inspect` says of columns that have names of their own.

use std::path::Path;

use serde_json::{Value, json};
use tunenet_formats::{Column, Described, JointQuantity, OfJoint, Table, of_some_joint, shell_word};

use crate::view::answer::Printout;

/// Its columns, where names alone do not say what they are.
pub fn of(found: &Table) -> Option<&Described> {
    found.described.as_ref().filter(|described| !described.of_known_names)
}

/// A line for each column: what it looks like, its unit, the one that is proposed, and why.
pub fn rows(found: &Table, described: &Described) -> Vec<Vec<String>> {
    let head = ["column", "looks like", "unit", "proposed", "why"].map(String::from).to_vec();
    let row = |column: &Column| {
        let Shown { looks_like, unit, proposed, why } = shown(column, described);
        let dash = |text: Option<String>| text.unwrap_or_else(|| "-".into());
        vec![column.name.clone(), dash(looks_like.map(str::to_owned)), dash(unit), dash(proposed), why]
    };
    std::iter::once(head).chain(found.columns.iter().map(row)).collect()
}

/// A column as an object.
pub fn object(column: &Column, described: &Described) -> Value {
    let Shown { looks_like, unit, proposed, why } = shown(column, described);
    json!({ "name": column.name, "read_as": column.read_as, "looks_like": looks_like, "unit": unit, "proposed": proposed, "why": why })
}

/// What to type next: for joints with their commands, and for channels of a simulation of one's own.
pub fn next(described: &Described, path: &Path, shown: &mut Printout) {
    let of = |command: bool| {
        let is = move |of: OfJoint| {
            of.command == command && of.quantity.is_none_or(|quantity| quantity == JointQuantity::Position)
        };
        described.columns.iter().map(|column| column.name.as_str()).find(|name| of_some_joint(name).is_some_and(is))
    };
    if let (Some(state), Some(command)) = (of(false), of(true)) {
        let (from, pair) = (shell_word(&path.to_string_lossy()), shell_word(&format!("JOINT={state}:{command}")));
        shown.line(&format!(
            "  try: `tunenet init robot --model ROBOT.urdf --from {from}` writes a simulation file of its joints"
        ));
        shown.line(&format!("  try: `--joints {pair}` with it for a joint that has another name in the model"));
    }
    if let Some(option) = &described.arm {
        shown.line(&format!("  try: `{option}` makes it the log of an arm with a payload"));
    }
    let clock = described
        .mapping()
        .map_or_else(String::new, |(ours, theirs)| format!(" --columns {}", shell_word(&format!("{ours}={theirs}"))));
    shown.line(&format!("  try: check its columns against a simulation file: `--sim FILE.toml{clock}`"));
}

/// What is said of a column.
struct Shown {
    looks_like: Option<&'static str>,
    unit: Option<String>,
    proposed: Option<String>,
    why: String,
}

fn shown(column: &Column, described: &Described) -> Shown {
    if column.name == described.clock {
        let unit = described.clock_as.as_deref().and_then(|name| name.strip_prefix("t_")).map(str::to_owned);
        let why = if unit.is_some() { "its rows come as often as those of a robot" } else { "its name" };
        return Shown { looks_like: Some("clock"), unit: None, proposed: unit, why: why.into() };
    }
    match described.columns.iter().find(|known| known.name == column.name) {
        Some(known) => Shown {
            looks_like: of_some_joint(&column.name).map(looks_like),
            unit: known.unit.clone(),
            proposed: known.proposed.clone(),
            why: known.why.clone(),
        },
        None => Shown { looks_like: None, unit: None, proposed: None, why: "no numbers".into() },
    }
}

fn looks_like(of: OfJoint) -> &'static str {
    match of {
        OfJoint { command: true, .. } => "command",
        OfJoint { quantity: Some(JointQuantity::Position), .. } => "position",
        OfJoint { quantity: Some(JointQuantity::Velocity), .. } => "velocity",
        OfJoint { quantity: Some(JointQuantity::Effort), .. } => "torque",
        OfJoint { quantity: None, .. } => "state",
    }
}

#[cfg(test)]
mod tests {
    use tunenet_formats::{Contents, contents};

    use super::*;

    #[test]
    fn columns_of_joints_are_listed_with_the_next_step() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let row = |i: u32| format!("{},{},0.1,a\n", f64::from(i) * 0.02, f64::from(i % 7));
        let text: String = std::iter::once("time,qpos.0,action.0,note\n".to_owned()).chain((0..50).map(row)).collect();
        std::fs::write(&path, text).unwrap();
        let Contents::Table(table) = contents(&path).unwrap() else { panic!("a table") };
        let described = of(&table).unwrap();
        let listed: Vec<String> = rows(&table, described).iter().map(|row| row[..4].join(" ")).collect();
        assert_eq!(
            listed,
            [
                "column looks like unit proposed",
                "time clock - s",
                "qpos.0 position - -",
                "action.0 command - -",
                "note - - -"
            ]
        );
        let mut shown = Printout::default();
        next(described, Path::new("a.csv"), &mut shown);
        for wanted in
            ["init robot --model ROBOT.urdf --from a.csv`", "`--joints JOINT=qpos.0:action.0`", "--columns t_s=time`"]
        {
            assert!(shown.text().contains(wanted), "{}", shown.text());
        }
        assert_eq!(object(&table.columns[2], described)["looks_like"], "command");
    }
}
