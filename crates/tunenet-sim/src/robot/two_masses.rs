//! One joint whose motor and link are joined by a gap or a compliant gear: two masses with dry friction on the motor's side (Nordin and
//! Gutman 2002, section 3) and a spring between them, by the implicit midpoint rule where the step resolves its oscillation. A stiffer
//! spring, as the contacts of a gap in a stiff gear, goes over to the implicit Euler rule, which damps what oscillates faster than the
//! step: undamped, it would shake the motor loose from its dry friction.

use super::acting::asked;
use super::numbers::{JointNumbers, Motor};
use super::one_joint::{Load, PASSES, Reciprocal, Step, WeightAndSprings};
use super::trajectory::Trajectory;
use super::wiring::Wire;
use crate::formula_effect::joint::{AppliedTorque, JointInstant};

/// Stiffness of a gear whose compliance is not stated, N·m/rad: far above what encoders resolve, and stable at steps of 1 ms.
const STIFF: f64 = 3000.0;

/// The share of a step's change of the twist that acts in the step: half by the midpoint rule, all of it by the Euler rule.
const MIDPOINT: f64 = 0.5;
const EULER: f64 = 1.0;

/// Squares of the spring's angular frequency times the step: up to the first the midpoint rule holds, from the second on the Euler rule.
const RESOLVED: f64 = 1.0;
const UNRESOLVED: f64 = 4.0;

/// The share of the twist's change for a spring between these inertias.
fn acting(stiffness: f64, (motor, link): (f64, f64), step_s: f64) -> f64 {
    let square = stiffness * step_s * step_s * (motor.recip() + link.recip());
    let beyond = ((square - RESOLVED) / (UNRESOLVED - RESOLVED)).clamp(0.0, 1.0);
    MIDPOINT + (EULER - MIDPOINT) * beyond
}

/// Rolls out from position `q` and speed `w` of the link over the grid of `out`; the encoder is on the link. Formulas act on the link, their
/// friction on the motor.
///
/// # Errors
/// Where motor or link has no inertia.
pub(super) fn roll(
    (joint, load, formulas): (&JointNumbers, &Load, &[AppliedTorque]),
    wire: &mut Wire,
    (q, w): (f64, f64),
    out: &mut Trajectory,
) -> Result<(), &'static str> {
    if joint.armature <= 0.0 || load.inertia <= 0.0 {
        return Err("backlash and elasticity need an armature and a link with inertia");
    }
    let dt = out.step_s();
    let passes = if formulas.is_empty() { 1 } else { PASSES };
    let (stiffness, acting) = if joint.compliance > 0.0 {
        let stiffness = joint.compliance.recip();
        (stiffness, acting(stiffness, (joint.armature, load.inertia), dt))
    } else {
        (STIFF, EULER)
    };
    // The motor stands on the side that carries the weight at rest.
    let mut around = WeightAndSprings::new(joint, load, q);
    let weight = around.torque(q, 0.0);
    let mut twist = if weight == 0.0 { 0.0 } else { -weight.signum() * 0.5 * joint.gap - weight / stiffness };
    let (mut q, mut w, mut motor_speed) = (q, w, w);
    let mut at = q;
    let mut reciprocal = Reciprocal::new();
    for k in 0..out.steps() {
        let command = wire.command();
        let middle = q + 0.5 * dt * w;
        let weight = around.torque(middle, middle - at);
        at = middle;
        let ahead = twist + dt * (motor_speed - w);
        let touching = ahead.abs() > 0.5 * joint.gap;
        // Impulse of the spring: pressed + coupled · (motor speed − link speed) after the step.
        let coupled = if touching { 0.5 * acting * stiffness * dt * dt } else { 0.0 };
        let pressed = if touching {
            dt * stiffness * (twist + 0.5 * acting * dt * (motor_speed - w) - ahead.signum() * 0.5 * joint.gap)
        } else {
            0.0
        };
        let shared = coupled / (load.inertia + coupled);
        let demand = joint.demand(command.goal, middle);
        let t = out.time(k) + 0.5 * dt;
        let instant = |speed: f64| JointInstant { t, q: middle, dq: speed, command: command.goal };
        let mut advance = |speed: f64| -> Result<_, &'static str> {
            let (torque, rubbing) = asked(formulas, 0, instant(speed))?;
            let outside = weight - torque;
            let link = load.inertia * w + dt * outside;
            let step = Step {
                joint,
                mass_by_step: (joint.armature + coupled - coupled * shared) / dt,
                momentum_by_step: (joint.armature * motor_speed - pressed + shared * (link + pressed)) / dt,
                outside,
                rubbing,
                speed: motor_speed,
            };
            let (motor_after, motor) = step.driven(command, demand, &mut reciprocal);
            Ok(((link + pressed + coupled * motor_after) / (load.inertia + coupled), motor_after, motor))
        };
        let (mut after, mut motor_after, mut motor) = (w, 0.0, Motor { torque: 0.0, braking: 0.0, passive: 0.0 });
        for _ in 0..passes {
            (after, motor_after, motor) = advance(0.5 * (w + after))?;
        }
        q += 0.5 * dt * (w + after);
        twist += 0.5 * dt * (motor_speed + motor_after - w - after);
        if out.holds_torques() {
            out.torque(k, 0, motor.torque - (motor.braking - motor.passive) * 0.5 * (motor_speed + motor_after));
        }
        (w, motor_speed) = (after, motor_after);
        out.state(k + 1, 0, q, w);
    }
    Ok(())
}
