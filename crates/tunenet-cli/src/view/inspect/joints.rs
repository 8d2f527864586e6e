//! What a log of joints shows of its units, without knowing the arm.

use serde_json::{Value, json};
use tunenet_core::observation::{Check, State};
use tunenet_core::observation::{Kind, Observation};
use tunenet_sim::replayed_arm::suspect_units;

use crate::view::answer::Printout;
use crate::view::json::warning;

/// The check of units, added to what is shown; nothing where `seen` is no log of joints.
pub fn units(seen: &Observation, shown: &mut Printout) -> Option<Check> {
    if seen.kind() != Kind::Joints {
        return None;
    }
    let check = suspect_units(seen);
    if check.state == State::Passed {
        shown.row("checked", &check.text);
    }
    shown.warn_all(&check.note());
    Some(check)
}

/// Adds the check to the object of a table.
pub fn add_to(check: &Check, object: &mut Value) {
    object["preflight"] = json!([check]);
    if let (Some(note), Some(warnings)) = (check.note(), object["warnings"].as_array_mut()) {
        warnings.push(warning(&note));
    }
}
