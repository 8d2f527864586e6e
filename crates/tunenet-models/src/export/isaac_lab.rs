//! An actuator configuration for Isaac Lab, as a Python file.
//!
//! Source: `isaaclab.actuators`, `ActuatorBaseCfg` and `DelayedPDActuatorCfg`.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::Whole;
use crate::{Change, Quantity};

/// A Python module with `ACTUATORS`, for the `actuators` of an `ArticulationCfg`. Joints with a command delay get a
/// `DelayedPDActuatorCfg` of their own delay, counted in steps of `physics_step_s`; the others share an
/// `ImplicitActuatorCfg`. What Isaac Lab does not have stands in comments.
#[must_use]
pub fn isaac_lab(changes: &[Change], whole: &[Whole], physics_step_s: f64) -> String {
    let mut joints: BTreeMap<&str, BTreeMap<Quantity, &Change>> = BTreeMap::new();
    for change in changes {
        joints.entry(&change.joint).or_default().insert(change.quantity, change);
    }
    // Joints by their least and greatest delay in steps.
    let mut groups: BTreeMap<[u32; 2], Vec<&str>> = BTreeMap::new();
    for (joint, numbers) in &joints {
        let delay = numbers.get(&Quantity::CommandDelay).map_or([0, 0], |change| steps(change, physics_step_s));
        groups.entry(delay).or_default().push(joint);
    }
    let mut text = format!(
        "# Actuators for isaaclab.assets.ArticulationCfg. Delays are counted in steps of {physics_step_s} s.\n\
         # dynamic_friction and viscous_friction need Isaac Sim 5 or later.\n\
         from isaaclab.actuators import DelayedPDActuatorCfg, ImplicitActuatorCfg\n\nACTUATORS = {{\n"
    );
    for ([least, greatest], names) in &groups {
        let delayed = *greatest > 0;
        let (class, label) = if delayed {
            ("DelayedPDActuatorCfg", format!("delay_{least}_{greatest}"))
        } else {
            ("ImplicitActuatorCfg", "tuned".to_owned())
        };
        let list: Vec<_> = names.iter().map(|name| python(&regex(name))).collect();
        let _ = writeln!(text, "    \"{label}\": {class}(\n        joint_names_expr=[{}],", list.join(", "));
        let limit = if delayed { "effort_limit" } else { "effort_limit_sim" };
        for (key, quantity) in [
            ("stiffness", Quantity::PositionGain),
            ("damping", Quantity::VelocityGain),
            (limit, Quantity::TorqueLimit),
            ("armature", Quantity::Armature),
            ("friction", Quantity::CoulombFriction),
            ("dynamic_friction", Quantity::CoulombFriction),
            ("viscous_friction", Quantity::ViscousFriction),
        ] {
            let of = |name: &&str| {
                // Isaac Lab's torque limit holds for gains alone: the motor's own braking is outside it, with the friction.
                let braking = joints[name].get(&Quantity::BackEmf).filter(|_| quantity == Quantity::ViscousFriction);
                let value = joints[name].get(&quantity)?.value + braking.map_or(0.0, |braking| braking.value);
                Some(format!("{}: {value:?}", python(&regex(name))))
            };
            // Isaac Lab requires both gains, and `None` would keep those of the asset: a joint driven by torque has neither.
            let gain = matches!(key, "stiffness" | "damping");
            let zero = |name: &&str| gain.then(|| format!("{}: 0.0", python(&regex(name))));
            let entries: Vec<String> = names.iter().filter_map(|name| of(name).or_else(|| zero(name))).collect();
            if !entries.is_empty() {
                let _ = writeln!(text, "        {key}={{{}}},", entries.join(", "));
            }
        }
        if delayed {
            let _ = writeln!(text, "        min_delay={least},\n        max_delay={greatest},");
        }
        text += "    ),\n";
    }
    text += "}\n";
    let viscous =
        |joint: &str| joints.get(joint).is_some_and(|numbers| numbers.contains_key(&Quantity::ViscousFriction));
    let within = |change: &Change| change.quantity == Quantity::BackEmf && viscous(&change.joint);
    for change in changes.iter().filter(|change| !expressed(change.quantity) && !within(change)) {
        let (name, unit) = (change.quantity.name(), change.unit());
        let _ = writeln!(text, "# not in Isaac Lab: {name} of {} = {:?} {unit}", python(&change.joint), change.value);
    }
    for effect in whole {
        let numbers: Vec<String> = effect.numbers.iter().map(|one| format!("{} = {:?}", one.key, one.value)).collect();
        let _ = writeln!(text, "# not in Isaac Lab: {} of the robot, {}", effect.effect, numbers.join(", "));
    }
    text
}

fn expressed(quantity: Quantity) -> bool {
    use Quantity::{Armature, CommandDelay, CoulombFriction, PositionGain, TorqueLimit, VelocityGain, ViscousFriction};
    matches!(
        quantity,
        Armature | CommandDelay | CoulombFriction | PositionGain | TorqueLimit | VelocityGain | ViscousFriction
    )
}

/// The interval of a delay in whole steps, or the nearest step.
fn steps(delay: &Change, step_s: f64) -> [u32; 2] {
    let [least, greatest] = delay.interval.unwrap_or([delay.value; 2]);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float becomes the nearest whole number"
    )]
    let whole = |seconds: f64| (seconds.max(0.0) / step_s).round().min(1e6) as u32;
    [whole(least), whole(greatest)]
}

/// A pattern that only this name fits.
fn regex(name: &str) -> String {
    let special = |c: char| "\\.+*?()|[]{}^$#&-~".contains(c);
    name.chars()
        .fold(String::new(), |text, c| if special(c) { text + "\\" + &c.to_string() } else { text + &c.to_string() })
}

/// A Python string.
fn python(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(quoted, "\\U{:08x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}
