//! What the model of a robot describes, as `init robot` reads it.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_core::text::visible;
use tunenet_formats::{read_text, shell_word};
use tunenet_models::Format;
use tunenet_sim::arm::{Joint, JointKind};
use tunenet_sim::robot::Drive;

use crate::commands::load::{Stated, stated};
use crate::view::answer::Printout;
use crate::view::json::warning;

/// Whether the file is a model: by its ending, and by its first element.
pub fn format(path: &Path, ending: &str) -> Option<Format> {
    if !matches!(ending, "urdf" | "xml" | "mjcf") {
        return None;
    }
    // Its first element shows in any encoding; reading it says which one is expected.
    let begin = || {
        let mut bytes = Vec::new();
        // A pipe would be waited for.
        let file = path.is_file().then(|| File::open(path).ok())??;
        file.take(LOOKED_AT).read_to_end(&mut bytes).ok()?;
        Some(String::from_utf8_lossy(&bytes).into_owned())
    };
    Format::of(&read_text(path).ok().or_else(begin)?)
}

/// Bytes at the beginning of a file in which its first element is looked for.
const LOOKED_AT: u64 = 1 << 16;

/// Looks into it.
///
/// # Errors
/// Where no robot can be what it describes.
pub fn look(path: &Path, format: Format, shown: &mut Printout) -> Result<Value> {
    let Stated { model, start, notes } = stated(path)?;
    let joints = model.joints();
    let format = if format == Format::Mjcf { "MJCF" } else { "URDF" };
    let own = |joint: &Joint| (!start.lacks_actuator(&joint.name)).then(|| drive(start.drive(&joint.name)));
    let row =
        |joint: &Joint| vec![visible(&joint.name), kind(joint).into(), range(joint), own(joint).unwrap_or("-").into()];
    let rows: Vec<Vec<String>> = joints.iter().map(|joint| row(joint)).collect();
    let count = if joints.len() == 1 { "1 joint".into() } else { format!("{} joints", joints.len()) };
    shown.row("model", &format!("{format} of a robot with {count}"));
    shown.table(&rows);
    let next = format!("tunenet init robot --model {}", shell_word(&path.to_string_lossy()));
    shown.row("usable", &format!("tune its joints: `{next}` writes a simulation file"));
    shown.warn_all(&notes);
    let of = |joint: &&Joint| {
        let [lower, upper] = [joint.limits.lower, joint.limits.upper].map(|end| end.is_finite().then_some(end));
        json!({ "name": joint.name, "kind": kind(joint), "min": lower, "max": upper, "drive": own(joint) })
    };
    Ok(json!({ "kind": "robot model", "for": "start a simulation file", "format": format,
        "joints": joints.iter().map(of).collect::<Vec<_>>(),
        "warnings": notes.iter().map(warning).collect::<Vec<_>>() }))
}

fn kind(joint: &Joint) -> &'static str {
    match joint.kind {
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
        JointKind::Prismatic => "prismatic",
    }
}

fn range(joint: &Joint) -> String {
    let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
    joint.shown_range().map_or_else(|| "no limits".into(), |[lower, upper]| format!("{lower} to {upper} {unit}"))
}

fn drive(drive: Drive) -> &'static str {
    match drive {
        Drive::Position => "position",
        Drive::Velocity => "velocity",
        Drive::Torque => "torque",
        Drive::Voltage => "voltage",
    }
}
