//! One driven joint: the implicit midpoint rule with exact sticking (Hairer, Lubich and Wanner 2006, section II.1, with the friction
//! of each step as a complementarity problem).
//!
//! With a step Δ, position q and speed w, inertia I, damping D and torque T taken at the middle of the step, and friction F:
//!
//! ```text
//! h  = (I − Δ D/2) w + Δ T(q + Δ w/2)
//! w' = 0 where −Δ F ≤ h ≤ Δ F, else (h ∓ Δ F) / (I + Δ D/2)
//! q' = q + Δ (w + w')/2
//! ```
//!
//! Damping by the duty of the firmware is part of D while the duty is not limited, so that the answer is continuous where a limit
//! begins to act.

use super::acting::asked;
use super::friction_cone::speed_after;
use super::near_sine::NearSine;
use super::numbers::{Command, JointNumbers, Motor};
use super::trajectory::Trajectory;
use super::wiring::Wire;
use crate::formula_effect::joint::{AppliedTorque, JointInstant};

/// A rigid load behind one joint: its inertia is constant and its weight a sine of the angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Load {
    /// About the joint, kg·m²; kg of a prismatic joint.
    pub inertia: f64,
    /// Torque that does not depend on the angle.
    pub constant: f64,
    /// Greatest torque of the weight: it is −amplitude · sin(q + phase).
    pub amplitude: f64,
    /// rad.
    pub phase: f64,
}

/// What the weight and springs do to a joint.
#[derive(Debug)]
pub(super) struct WeightAndSprings<'a> {
    joint: &'a JointNumbers,
    load: &'a Load,
    sine: NearSine,
}

impl<'a> WeightAndSprings<'a> {
    pub fn new(joint: &'a JointNumbers, load: &'a Load) -> Self {
        Self { joint, load, sine: NearSine::new(0.0) }
    }

    /// Their torque at a position.
    #[inline]
    pub fn torque(&mut self, q: f64) -> f64 {
        let (joint, load) = (self.joint, self.load);
        let true_q = q + joint.zero;
        let swinging = if load.amplitude == 0.0 { 0.0 } else { load.amplitude * self.sine.sin(true_q + load.phase) };
        load.constant - swinging + joint.preload - joint.spring * true_q
    }
}

/// The speed at the end of a step where the motor's torque is `motor`.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_field_names, reason = "the unit of time and the struct share a word")]
pub(super) struct Step<'a> {
    pub joint: &'a JointNumbers,
    /// Inertia that the friction acts on.
    pub mass: f64,
    /// Momentum besides that of the motor, the friction and damping.
    pub momentum: f64,
    /// Torque of weight, springs and formulas, for friction by load.
    pub outside: f64,
    /// Friction of formulas.
    pub rubbing: f64,
    pub speed: f64,
    pub step_s: f64,
}

impl Step<'_> {
    #[inline]
    fn with(&self, motor: Motor) -> f64 {
        let (joint, dt) = (self.joint, self.step_s);
        let impulse = self.momentum + dt * motor.torque - 0.5 * dt * motor.braking * self.speed;
        let carried = if joint.load_friction == 0.0 {
            0.0
        } else {
            self.outside - (motor.torque - (motor.braking - motor.passive) * self.speed)
        };
        let (forward, backward) = joint.friction(self.speed, carried, self.rubbing);
        speed_after(impulse, self.mass + 0.5 * dt * motor.braking, (dt * forward, dt * backward))
    }

    /// The speed after the step, and the motor that led there.
    #[inline]
    pub fn driven(&self, command: Command, demand: f64) -> (f64, Motor) {
        let joint = self.joint;
        let by_speed = joint.duty_by_speed();
        if !joint.drive.has_duty() || (by_speed == 0.0 && demand.abs() <= joint.duty_max) {
            let motor = joint.unlimited(command, demand, self.speed);
            return (self.with(motor), motor);
        }
        if by_speed == 0.0 {
            let motor = joint.limited(command, demand.signum(), self.speed);
            return (self.with(motor), motor);
        }
        let motor = joint.unlimited(command, demand, self.speed);
        let after = self.with(motor);
        let duty = demand - by_speed * 0.5 * (self.speed + after);
        if duty.abs() <= joint.duty_max {
            return (after, motor);
        }
        let motor = joint.limited(command, duty.signum(), self.speed);
        (self.with(motor), motor)
    }
}

/// The speed at the middle of a step that formulas depend on is not known at first: they are taken so often, and once without any.
pub(super) const PASSES: usize = 2;

/// Rolls the joint out from position `q` and speed `w` over the grid of `out`.
///
/// # Errors
/// Where a formula has no finite value.
pub(super) fn roll(
    (joint, load, formulas): (&JointNumbers, &Load, &[AppliedTorque]),
    wire: &mut Wire,
    (q, w): (f64, f64),
    out: &mut Trajectory,
) -> Result<(), &'static str> {
    let passes = if formulas.is_empty() { 1 } else { PASSES };
    let dt = out.step_s;
    let inertia = load.inertia + joint.armature;
    let mut around = WeightAndSprings::new(joint, load);
    let (mut q, mut w) = (q, w);
    for k in 0..out.steps() {
        let command = wire.step(out.time(k), out.time(k + 1));
        let middle = q + 0.5 * dt * w;
        let weight = around.torque(middle);
        let demand = joint.demand(command.goal, middle);
        let t = out.time(k) + 0.5 * dt;
        let instant = |speed: f64| JointInstant { t, q: middle, dq: speed, command: command.goal };
        let advance = |speed: f64| -> Result<_, &'static str> {
            let (torque, rubbing) = asked(formulas, 0, instant(speed))?;
            let outside = weight - torque;
            let momentum = inertia * w + dt * outside;
            let step = Step { joint, mass: inertia, momentum, outside, rubbing, speed: w, step_s: dt };
            Ok(step.driven(command, demand))
        };
        let (mut after, mut motor) = (w, Motor { torque: 0.0, braking: 0.0, passive: 0.0 });
        for _ in 0..passes {
            (after, motor) = advance(0.5 * (w + after))?;
        }
        q += 0.5 * dt * (w + after);
        if out.holds_torques() {
            out.torque(k, 0, motor.torque - (motor.braking - motor.passive) * 0.5 * (w + after));
        }
        w = after;
        out.state(k + 1, 0, q, w);
    }
    Ok(())
}
