//! Intervals as ranges for domain randomisation.

use serde_json::{Map, Value, json};

use crate::{Change, Quantity};

/// A JSON object with `joints`: for each joint and quantity that has an interval `low`, `high`, `nominal`, `unit`, and `mjcf`
/// (element and attribute) where MJCF has one. `without_interval` lists the others.
///
/// The ranges are 95 % intervals, each for itself: numbers that are only known together (a gain and the torque limit that
/// scales it) are to be drawn together. What cannot be below 0 starts at 0.
#[must_use]
pub fn ranges(model: &str, changes: &[Change]) -> Value {
    let (mut joints, mut without) = (Map::new(), Vec::new());
    for change in changes {
        let (joint, quantity) = (&change.joint, change.quantity);
        let Some([low, high]) = change.interval else {
            without.push(json!({ "joint": joint, "quantity": quantity.name() }));
            continue;
        };
        let low = if quantity.signed() { low } else { low.max(0.0) };
        let mut one = json!({ "low": low, "high": high, "nominal": change.value, "unit": quantity.unit() });
        if let Some((element, attribute)) = mjcf(quantity) {
            one["mjcf"] = json!({ "element": element, "attribute": attribute });
        }
        let entry = joints.entry(joint.clone()).or_insert_with(|| Value::Object(Map::new()));
        if let Some(entry) = entry.as_object_mut() {
            entry.insert(quantity.name().to_owned(), one);
        }
    }
    json!({ "model": model, "interval": 0.95, "distribution": "uniform", "joints": joints, "without_interval": without })
}

/// The attribute of MJCF that holds it.
fn mjcf(quantity: Quantity) -> Option<(&'static str, &'static str)> {
    Some(match quantity {
        Quantity::ViscousFriction => ("joint", "damping"),
        Quantity::CoulombFriction => ("joint", "frictionloss"),
        Quantity::Armature => ("joint", "armature"),
        Quantity::Stiffness => ("joint", "stiffness"),
        Quantity::SpringReference => ("joint", "springref"),
        Quantity::PositionGain => ("position", "kp"),
        Quantity::VelocityGain => ("position", "kv"),
        Quantity::TorqueLimit => ("position", "forcerange"),
        Quantity::Gear => ("position", "gear"),
        Quantity::CommandDelay => ("position", "delay"),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_become_ranges_and_others_are_listed() {
        let change = |quantity, interval| Change { joint: "elbow".into(), quantity, value: 0.1, interval };
        let all = [
            change(Quantity::CoulombFriction, Some([-0.1, 0.3])),
            change(Quantity::TorqueBias, Some([-0.1, 0.3])),
            change(Quantity::Armature, None),
        ];
        let ranges = ranges("arm.xml", &all);
        let of = |quantity: &str| &ranges["joints"]["elbow"][quantity];
        assert_eq!(
            of("coulomb_friction"),
            &json!({ "low": 0.0, "high": 0.3, "nominal": 0.1, "unit": "N·m",
            "mjcf": { "element": "joint", "attribute": "frictionloss" } })
        );
        assert_eq!(of("torque_bias")["low"], json!(-0.1));
        assert_eq!(ranges["without_interval"], json!([{ "joint": "elbow", "quantity": "armature" }]));
    }
}
