//! What no key alone can say of a simulation file of robot joints.

use toml_edit::{Item, Table, TableLike};
use tunenet_core::observation::Channel;

use super::declared_check::{self, Wrong};
use super::declared_schema::Declares;
use super::schema::{Definition, item_number, lookup, number, texts};
use crate::robot::numbers::Number;
use crate::scene::RobotScene;

/// Between the name of a joint and that of its number.
pub(crate) const BETWEEN: &str = "__";

/// The parameters of the joint that `tunenet init robot` writes.
pub(super) const SAMPLES: &[Definition] = &[
    sample("hinge__stall_torque", "N·m", [3.0, 0.1, 30.0], "Torque of the motor at full duty and rest"),
    sample("hinge__back_emf", "N·m·s/rad", [0.5, 0.0, 10.0], "Braking by the motor for each rad/s while it is on"),
    sample("hinge__viscous", "N·m·s/rad", [0.02, 0.0, 2.0], "Braking by the bearings for each rad/s"),
    sample("hinge__coulomb", "N·m", [0.1, 0.0, 2.0], "Dry friction"),
    sample("hinge__armature", "kg·m²", [0.02, 0.001, 0.5], "Inertia of the rotor behind the gear"),
    sample("hinge__zero", "rad", [0.0, -0.3, 0.3], "True less measured position"),
];

const fn sample(name: &'static str, unit: &'static str, default: [f64; 3], meaning: &'static str) -> Definition {
    let bounds = (f64::NEG_INFINITY, f64::INFINITY);
    Definition { name, unit, default, tune: true, bounds, within: "any size", meaning }
}

/// The joint and the number that a parameter of this name is.
pub(crate) fn role(name: &str) -> Option<(&str, Number)> {
    let (joint, number) = name.rsplit_once(BETWEEN)?;
    Number::ALL.into_iter().find(|(known, _)| *known == number).map(|(_, number)| (joint, number))
}

/// The same scene, the inputs that switch motors without a unit.
pub(super) fn with_units(mut scene: RobotScene) -> RobotScene {
    let switches: Vec<String> = scene.joints.values().filter_map(|joint| joint.enable.clone()).collect();
    for (name, input) in &mut scene.inputs {
        if switches.contains(name) && input.unit.is_none() && Channel::from_header(name).is_none() {
            input.unit = Some("1".into());
        }
    }
    scene
}

/// The first thing that no key alone shows to be wrong: its path, its place, what is expected and what is found.
pub(super) fn contradiction(root: &Table) -> Option<Wrong> {
    declared_check::contradiction(root, Declares::Robot).or_else(|| joints(root)).or_else(|| parameters(root))
}

fn tables<'a>(root: &'a Table, head: &str) -> Vec<(&'a str, &'a Item, &'a dyn TableLike)> {
    let all = lookup(root, head).and_then(Item::as_table_like);
    let each = all.into_iter().flat_map(|all| all.iter());
    each.filter_map(|(name, item)| Some((name, item, item.as_table_like()?))).collect()
}

fn wrong(path: String, item: Option<&Item>, expected: impl Into<String>, found: impl Into<String>) -> Wrong {
    (path, item.and_then(Item::span).unwrap_or(0..0), expected.into(), found.into())
}

/// What is wrong with the joints.
fn joints(root: &Table) -> Option<Wrong> {
    let joints = tables(root, "joints");
    if joints.is_empty() {
        return Some(wrong("joints".into(), None, "at least one [joints.NAME], by the names of the model", "none"));
    }
    let inputs: Vec<&str> = tables(root, "inputs").iter().map(|(name, ..)| *name).collect();
    let mut seen: Vec<&str> = Vec::new();
    for (name, item, table) in joints {
        let path = format!("joints.{name}");
        let text = |key: &str| table.get(key).and_then(Item::as_str);
        for key in ["command", "enable"] {
            let Some(input) = text(key).filter(|input| !inputs.contains(input)) else { continue };
            let expected = format!("an input of the file ({})", listed(&inputs));
            return Some(wrong(format!("{path}.{key}"), table.get(key), expected, format!("`{input}`")));
        }
        let (drive, gain) = (text("drive").unwrap_or_default(), table.get("gain_1_rad"));
        if let Some((key, found)) = needless(drive, table) {
            let expected = format!("no `{key}` for a {drive} drive");
            return Some(wrong(format!("{path}.{key}"), Some(found), expected, "one"));
        }
        if let Some(wrong) = commands(&path, table) {
            return Some(wrong);
        }
        if matches!(drive, "position" | "velocity") && gain.is_none() {
            let expected = format!("`gain_1_rad` for a {drive} drive: duty for each unit of kp and of error");
            return Some(wrong(path, Some(item), expected, "none"));
        }
        if drive == "voltage" && table.get("n_v").is_some() == table.get("nm_v").is_some() {
            let expected = "`n_v` of a prismatic joint or `nm_v` of another for a voltage drive";
            return Some(wrong(path, Some(item), expected, "neither, or both"));
        }
        for header in table.get("observe").map(texts).unwrap_or_default() {
            let unit = Channel::from_header(header).map(|channel| channel.unit);
            let known = ["rad", "rad/s", "N·m", "A", "m", "m/s", "N"];
            let place = table.get("observe");
            if !unit.as_deref().is_some_and(|unit| known.contains(&unit)) {
                let expected = "names that end in rad, rad_s, nm or a; of a prismatic joint in m, m_s, n or a";
                return Some(wrong(format!("{path}.observe"), place, expected, format!("`{header}`")));
            }
            if unit.as_deref() == Some("A") && table.get("nm_a").is_none() {
                let expected = "`nm_a`, the torque for each ampere, since a current is observed";
                return Some(wrong(path, Some(item), expected, "none"));
            }
            if seen.contains(&header) {
                let found = format!("`{header}` twice");
                return Some(wrong(format!("{path}.observe"), place, "each channel once", found));
            }
            seen.push(header);
        }
    }
    None
}

/// What is wrong with the scale and the range of a joint's commands.
fn commands(path: &str, table: &dyn TableLike) -> Option<Wrong> {
    let (scale, range) = (table.get("command_scale"), table.get("command_range"));
    if scale.and_then(item_number) == Some(0.0) {
        return Some(wrong(format!("{path}.command_scale"), scale, "a number other than 0", "0"));
    }
    let ends: Vec<f64> = range.and_then(Item::as_array)?.iter().filter_map(number).collect();
    let [least, greatest] = ends[..] else { return None };
    let found = || format!("[{least}, {greatest}]");
    (least >= greatest).then(|| wrong(format!("{path}.command_range"), range, "the smaller number first", found()))
}

/// A key that the drive of a joint does not use.
fn needless<'a>(drive: &str, table: &'a dyn TableLike) -> Option<(&'static str, &'a Item)> {
    let unused: &[&'static str] = match drive {
        "torque" => &["gain_1_rad", "n_v", "nm_v", "kd"],
        "voltage" => &["gain_1_rad", "kp", "kd"],
        _ => &["n_v", "nm_v"],
    };
    unused.iter().find_map(|key| Some((*key, table.get(key)?)))
}

/// What is wrong with the names of parameters.
fn parameters(root: &Table) -> Option<Wrong> {
    let joints: Vec<&str> = tables(root, "joints").iter().map(|(name, ..)| *name).collect();
    let known = Number::ALL.map(|(name, _)| name);
    let drive = |joint: &str| lookup(root, &format!("joints.{joint}.drive")).and_then(Item::as_str);
    for (name, item, _) in tables(root, "parameters") {
        let path = format!("parameters.{name}");
        match role(name) {
            Some((joint, _)) if joints.contains(&joint) => {}
            _ => {
                let expected =
                    format!("JOINT{BETWEEN}NAME, of a joint ({}) and of {}", listed(&joints), listed(&known));
                return Some(wrong(path, Some(item), expected, format!("`{name}`")));
            }
        }
    }
    let has_duty = |joint: &&str| matches!(drive(joint), Some("position" | "velocity"));
    let named = |joint: &str| lookup(root, &format!("parameters.{joint}{BETWEEN}stall_torque")).is_some();
    let lacking = joints.into_iter().filter(has_duty).find(|joint| !named(joint))?;
    let expected =
        format!("[parameters.{lacking}{BETWEEN}stall_torque], the torque of its motor at full duty and rest");
    Some(wrong(format!("joints.{lacking}"), lookup(root, &format!("joints.{lacking}")), expected, "none"))
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}
