//! Parameters for BAM, the servo models of Rhoban.
//!
//! Source: Duclusaud, Passault, Padois, Ly, Extended friction models for the physics simulation of servo actuators, 2025; names of the keys
//! as `bam/model.py` and `bam/actuators` read them.

use serde_json::{Map, Value, json};

use crate::edit::Left;
use crate::{Change, Quantity};

/// What BAM needs to know of a servo besides the tuned numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct BamServo {
    /// Its name in BAM, such as `sts3215`.
    pub actuator: String,
    /// Supply, V.
    pub supply_v: f64,
    /// Gain that was set in the firmware; `None` where it is not known.
    pub firmware_gain: Option<f64>,
    /// Duty per error and firmware gain, 1/rad; `None` where it is not known.
    pub error_gain: Option<f64>,
}

/// Parameters of one servo.
#[derive(Debug, Clone, PartialEq)]
pub struct Bam {
    /// The object that BAM's `load_model` reads.
    pub json: Value,
    /// What BAM's models do not have.
    pub left: Vec<Left>,
}

/// The numbers of one joint as BAM's parameters.
///
/// The model is M1; with Stribeck friction M2, with load-dependent friction M3, with both M4. `kt` and `R` follow from the
/// stall torque `A = kt·U/R` and the braking `B = kt²/R` at the supply `U`.
#[must_use]
pub fn bam(joint: &str, changes: &[Change], servo: &BamServo) -> Bam {
    let own: Vec<&Change> = changes.iter().filter(|change| change.joint == joint).collect();
    let of = |quantity: Quantity| own.iter().find(|change| change.quantity == quantity).map(|change| change.value);
    let (stribeck, load) = (of(Quantity::StribeckFriction), of(Quantity::LoadFriction));
    let model = match (stribeck.is_some(), load.is_some()) {
        (false, false) => "m1",
        (true, false) => "m2",
        (false, true) => "m3",
        (true, true) => "m4",
    };
    let mut all = Map::new();
    all.insert("actuator".into(), json!(servo.actuator));
    all.insert("model".into(), json!(model));
    let mut set = |key: &str, number: Option<f64>| {
        if let Some(number) = number {
            all.insert(key.into(), json!(number));
        }
    };
    set("vin", Some(servo.supply_v));
    set("kp", servo.firmware_gain);
    set("error_gain", servo.error_gain);
    let motor = of(Quantity::StallTorque).zip(of(Quantity::BackEmf)).map(|(stall, braking)| {
        let per_torque = servo.supply_v / stall;
        [braking * per_torque, braking * per_torque.powi(2)]
    });
    let motor = motor.filter(|numbers| numbers.iter().all(|number| number.is_finite() && *number > 0.0));
    if let Some([torque_per_ampere, resistance_ohm]) = motor {
        set("kt", Some(torque_per_ampere));
        set("R", Some(resistance_ohm));
    }
    set("armature", of(Quantity::Armature));
    set("q_offset", of(Quantity::ZeroOffset));
    set("command_delay", of(Quantity::CommandDelay));
    set("friction_base", of(Quantity::CoulombFriction));
    set("friction_viscous", of(Quantity::ViscousFriction));
    set("load_friction_base", load);
    set("friction_stribeck", stribeck);
    if stribeck.is_some() {
        set("dtheta_stribeck", of(Quantity::StribeckSpeed));
        // The exponent of the Stribeck effect of this tool.
        set("alpha", Some(2.0));
    }
    if stribeck.is_some() && load.is_some() {
        set("load_friction_stribeck", Some(0.0));
    }
    let left = own.iter().filter_map(|change| {
        let why = left_out(change.quantity, motor.is_some())?;
        Some(Left { change: (*change).clone(), why: why.into() })
    });
    let left = left.collect();
    Bam { json: Value::Object(all), left }
}

/// Why BAM does not have it; `None` where it has.
fn left_out(quantity: Quantity, motor: bool) -> Option<&'static str> {
    use Quantity::{
        Armature, BackEmf, CommandDelay, CoulombFriction, LoadFriction, StallTorque, StribeckFriction, StribeckSpeed,
        ViscousFriction, ZeroOffset,
    };
    match quantity {
        Armature | CommandDelay | CoulombFriction | LoadFriction | StribeckFriction | StribeckSpeed
        | ViscousFriction | ZeroOffset => None,
        StallTorque | BackEmf => {
            (!motor).then_some("BAM's kt and R follow from stall_torque and back_emf together, both above 0")
        }
        _ => Some("BAM's models have no such number"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;

    fn change(quantity: Quantity, value: f64) -> Change {
        Change { joint: "elbow".into(), motion: Motion::Revolute, quantity, value, interval: None }
    }

    /// kt and R of a motor give back its stall torque and its braking.
    #[test]
    fn the_motor_is_the_same() {
        let changes = [
            change(Quantity::StallTorque, 7.5),
            change(Quantity::BackEmf, 1.26),
            change(Quantity::CoulombFriction, 0.118),
            change(Quantity::LoadFriction, 0.18),
            change(Quantity::Backlash, 0.02),
            Change { joint: "wrist".into(), ..change(Quantity::StribeckFriction, 1.0) },
        ];
        let servo =
            BamServo { actuator: "sts3215".into(), supply_v: 12.0, firmware_gain: Some(16.0), error_gain: Some(0.166) };
        let Bam { json, left } = bam("elbow", &changes, &servo);
        let number = |key: &str| json[key].as_f64().unwrap();
        let (kt, r) = (number("kt"), number("R"));
        assert!((kt * 12.0 / r - 7.5).abs() < 1e-12 && (kt * kt / r - 1.26).abs() < 1e-12, "{json}");
        assert_eq!((json["model"].as_str(), number("load_friction_base")), (Some("m3"), 0.18));
        assert_eq!(left.len(), 1);
        assert_eq!(left[0].change.quantity, Quantity::Backlash);
    }

    #[test]
    fn a_motor_without_torque_has_no_constants() {
        let servo = BamServo { actuator: "mx64".into(), supply_v: 12.0, firmware_gain: None, error_gain: None };
        for stall in [0.0, 1e-300] {
            let changes = [change(Quantity::StallTorque, stall), change(Quantity::BackEmf, 1.0)];
            let Bam { json, left } = bam("elbow", &changes, &servo);
            assert_eq!((json.get("kt"), json.get("R"), left.len()), (None, None, 2), "{json}");
        }
    }
}
