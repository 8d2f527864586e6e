//! Values and bounds of the parameters of a robot to start from.

use crate::arm::{Joint, JointKind};
use crate::robot::StatedMotor;

/// Dry friction is at most this share of the greatest torque of a motor, and braking at 1 rad/s (m/s) at most that share.
const FRICTION_OF_STRENGTH: f64 = 0.5;
const BRAKING_OF_STRENGTH_S_RAD: f64 = 0.2;
/// How far the zero of a log may be from that of the model, rad or m: a quarter turn, since a log that is normalised to the range of its
/// calibration has a zero of its own.
const ZERO_OF_A_LOG: f64 = 1.6;
/// The inertia of a rotor that a model states is within this factor of the true one: two identifications of one servo (STS3215: 0.0278 kg·m²
/// by BAM, 0.0214 with a speed limit, a delay and a friction under load) differ by 1.3.
const STATED_INERTIA: f64 = 3.0;

/// Value, least and greatest value of a parameter to start from.
pub(super) fn value(
    number: &str,
    default: [f64; 3],
    motor: Option<&StatedMotor>,
    (joint, effort): (&Joint, Option<f64>),
) -> [f64; 3] {
    let around = |value: f64, least: f64, greatest: f64| [value, least, (10.0 * value).max(greatest)];
    let stated = |of: fn(&StatedMotor) -> f64| motor.map(of).filter(|value| *value > 0.0);
    let of_joint = |value: f64| Some(value).filter(|value| *value > 0.0);
    // What a strong motor moves may brake it strongly.
    let strength = motor.and_then(|motor| motor.stall_torque).or(effort).unwrap_or(0.0);
    let greatest = match number {
        "coulomb" => default[2].max(FRICTION_OF_STRENGTH * strength),
        "viscous" | "back_emf" => default[2].max(BRAKING_OF_STRENGTH_S_RAD * strength),
        _ => default[2],
    };
    // A model that states a motor and none of a number means 0.
    let absent = motor.map(|_| [0.0, 0.0, greatest]);
    let found = match number {
        "stall_torque" => {
            // Where the model states no limit, the true one may be any below.
            let share = if motor.is_none_or(|motor| motor.limited) { 10.0 } else { 1e3 };
            motor.and_then(|motor| motor.stall_torque).or(effort).map(|value| around(value, value / share, 0.0))
        }
        // It is in the damping of the model.
        "back_emf" => absent,
        "viscous" => stated(|motor| motor.damping)
            .or(of_joint(joint.damping))
            .map(|value| around(value, 0.0, greatest))
            .or(absent),
        "coulomb" => stated(|motor| motor.friction)
            .or(of_joint(joint.friction))
            .map(|value| around(value, 0.0, greatest))
            .or(absent),
        "armature" => stated(|motor| motor.armature)
            .or(of_joint(joint.armature))
            .map(|value| around(value, value / 10.0, greatest))
            .or(absent),
        _ => None,
    };
    found.unwrap_or([default[0], default[1], greatest])
}

/// The zero of a joint's log, and how far from the model's it may be; a slide's no farther than the joint moves.
pub(super) fn zero_of_a_log(joint: &Joint) -> [f64; 3] {
    let travel = joint.limits.upper - joint.limits.lower;
    let slides = joint.kind == JointKind::Prismatic && travel > 0.0;
    let most = if slides { ZERO_OF_A_LOG.min(travel) } else { ZERO_OF_A_LOG };
    [0.0, -most, most]
}

/// Whether the model states the inertia of a rotor.
pub(super) fn states_inertia(motor: Option<&StatedMotor>, joint: &Joint) -> bool {
    motor.is_some_and(|motor| motor.armature > 0.0) || joint.armature > 0.0
}

/// Value, least and greatest value of the inertia of a rotor that the model states, where the gain is tuned: with it, all torques and
/// inertias of a joint are known but for a factor, which this inertia decides.
pub(super) fn near_stated(inertia: f64) -> [f64; 3] {
    [inertia, inertia / STATED_INERTIA, inertia * STATED_INERTIA]
}

#[cfg(test)]
mod tests {
    use super::near_stated;

    #[test]
    fn a_stated_inertia_is_within_a_factor() {
        let [value, least, greatest] = near_stated(0.028);
        assert!(value == 0.028 && least * greatest == value * value && greatest > 2.0 * value);
    }
}
