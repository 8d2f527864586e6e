//! Intervals as ranges for domain randomisation.

use serde_json::{Value, json};

use crate::Change;

/// A JSON object with the `ranges` of joints, with the keys of a tuning's ranges (`name`, `unit`, `value`, `low`, `high`), and with
/// `joint` and `quantity`. `without_interval` lists the others.
///
/// The ranges are 95 % intervals, each for itself: numbers that are only known together (a gain and the torque limit that
/// scales it) are to be drawn together. What cannot be below 0 starts at 0.
#[must_use]
pub fn ranges(model: &str, changes: &[Change]) -> Value {
    let (mut ranges, mut without) = (Vec::new(), Vec::new());
    for change in changes {
        let (joint, quantity) = (&change.joint, change.quantity);
        let name = format!("{joint}.{}", quantity.name());
        let Some([low, high]) = change.interval else {
            without.push(name);
            continue;
        };
        let low = if quantity.signed() { low } else { low.max(0.0) };
        let (unit, value) = (change.unit(), change.value);
        ranges.push(json!({ "name": name, "unit": unit, "value": value, "low": low, "high": high,
            "joint": joint, "quantity": quantity.name() }));
    }
    json!({ "schema": "tunenet.joint_ranges/1", "model": model, "level": 0.95, "ranges": ranges, "without_interval": without })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Motion, Quantity};

    #[test]
    fn intervals_become_ranges_and_others_are_listed() {
        let change = |quantity, interval| Change {
            joint: "elbow".into(),
            motion: Motion::Revolute,
            quantity,
            value: 0.1,
            interval,
        };
        let all = [
            change(Quantity::CoulombFriction, Some([-0.1, 0.3])),
            change(Quantity::TorqueBias, Some([-0.1, 0.3])),
            change(Quantity::Armature, None),
        ];
        let found = ranges("arm.xml", &all);
        let first = json!({ "name": "elbow.coulomb_friction", "unit": "N·m", "value": 0.1, "low": 0.0, "high": 0.3,
            "joint": "elbow", "quantity": "coulomb_friction" });
        assert_eq!(found["ranges"][0], first);
        assert_eq!(found["ranges"][1]["low"], json!(-0.1));
        assert_eq!(found["without_interval"], json!(["elbow.armature"]));
    }
}
