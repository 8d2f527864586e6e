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
//! The code divides all of this by Δ, and goes from the middle of one step to that of the next, q' + Δ w'/2 = q + Δ w/2 + Δ w', so that a
//! step waits for as few operations of the last one as possible.
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
pub(super) struct WeightAndSprings {
    /// Their torque at position 0 without the weight's part that depends on the angle.
    constant: f64,
    spring: f64,
    /// From the measured position to the angle of the weight.
    phase: f64,
    swinging: Option<NearSine>,
}

impl WeightAndSprings {
    /// Those of a joint that begins at position `q`.
    pub fn new(joint: &JointNumbers, load: &Load, q: f64) -> Self {
        let phase = joint.zero + load.phase;
        let swings = load.amplitude != 0.0;
        Self {
            constant: load.constant + joint.preload - joint.spring * joint.zero,
            spring: joint.spring,
            phase,
            swinging: swings.then(|| NearSine::new(load.amplitude, q + phase)),
        }
    }

    /// Their torque at position `q`, which lies `moved` after the last one.
    #[inline]
    pub fn torque(&mut self, q: f64, moved: f64) -> f64 {
        let swinging = self.swinging.as_mut().map_or(0.0, |sine| sine.at(q + self.phase, moved));
        self.constant - self.spring * q - swinging
    }
}

/// The reciprocal of a number that seldom changes: dividing takes far longer than comparing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reciprocal {
    of: f64,
    value: f64,
}

impl Reciprocal {
    pub const fn new() -> Self {
        Self { of: 1.0, value: 1.0 }
    }

    #[inline]
    fn of(&mut self, number: f64) -> f64 {
        if self.of != number {
            *self = Self { of: number, value: number.recip() };
        }
        self.value
    }
}

/// The speed at the end of a step where the motor's torque is `motor`.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_field_names, reason = "the unit of time and the struct share a word")]
pub(super) struct Step<'a> {
    pub joint: &'a JointNumbers,
    /// Inertia that the friction acts on, divided by the step.
    pub mass_by_step: f64,
    /// Momentum besides that of the motor, the friction and damping, divided by the step.
    pub momentum_by_step: f64,
    /// Torque of weight, springs and formulas, for friction by load.
    pub outside: f64,
    /// Friction of formulas.
    pub rubbing: f64,
    pub speed: f64,
}

impl Step<'_> {
    #[expect(clippy::inline_always, reason = "every step calls it, which slows rollouts down")]
    #[inline(always)]
    fn with(&self, motor: Motor, reciprocal: &mut Reciprocal) -> f64 {
        let joint = self.joint;
        let impulse = self.momentum_by_step + (motor.torque - 0.5 * motor.braking * self.speed);
        let carried = if joint.load_friction == 0.0 {
            0.0
        } else {
            self.outside - (motor.torque - (motor.braking - motor.passive) * self.speed)
        };
        let per_mass = reciprocal.of(self.mass_by_step + 0.5 * motor.braking);
        speed_after(impulse, per_mass, joint.friction(self.speed, carried, self.rubbing))
    }

    /// The speed after the step, and the motor that led there.
    #[expect(clippy::inline_always, reason = "every step calls it, which slows rollouts down")]
    #[inline(always)]
    pub fn driven(&self, command: Command, demand: f64, reciprocal: &mut Reciprocal) -> (f64, Motor) {
        let joint = self.joint;
        let by_speed = joint.duty_by_speed();
        if !joint.drive.has_duty() || (by_speed == 0.0 && demand.abs() <= joint.duty_max) {
            let motor = joint.unlimited(command, demand, self.speed);
            return (self.with(motor, reciprocal), motor);
        }
        if by_speed == 0.0 {
            let motor = joint.limited(command, demand.signum(), self.speed);
            return (self.with(motor, reciprocal), motor);
        }
        let motor = joint.unlimited(command, demand, self.speed);
        let after = self.with(motor, reciprocal);
        let duty = demand - by_speed * 0.5 * (self.speed + after);
        if duty.abs() <= joint.duty_max {
            return (after, motor);
        }
        let motor = joint.limited(command, duty.signum(), self.speed);
        (self.with(motor, reciprocal), motor)
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
    state: (f64, f64),
    out: &mut Trajectory,
) -> Result<(), &'static str> {
    // The compiler leaves out of the loop what is known to be absent.
    if formulas.is_empty() && *joint == joint.plain() {
        steps::<true>((joint, load, &[]), wire, state, out)
    } else {
        steps::<false>((joint, load, formulas), wire, state, out)
    }
}

/// As [`roll`]; `PLAIN` says that the joint is [plain](JointNumbers::plain) and that there are no formulas.
fn steps<const PLAIN: bool>(
    (joint, load, formulas): (&JointNumbers, &Load, &[AppliedTorque]),
    wire: &mut Wire,
    (q, w): (f64, f64),
    out: &mut Trajectory,
) -> Result<(), &'static str> {
    let joint = &if PLAIN { joint.plain() } else { *joint };
    let passes = if formulas.is_empty() { 1 } else { PASSES };
    let dt = out.step_s();
    let inertia_by_step = (load.inertia + joint.armature) / dt;
    let (mut middle, mut moved, mut w) = (q + 0.5 * dt * w, 0.0, w);
    let mut around = WeightAndSprings::new(joint, load, middle);
    let mut reciprocal = Reciprocal::new();
    for k in 0..out.steps() {
        let command = wire.command();
        let weight = around.torque(middle, moved);
        let demand = joint.demand(command.goal, middle);
        let t = out.time(k) + 0.5 * dt;
        let instant = |speed: f64| JointInstant { t, q: middle, dq: speed, command: command.goal };
        let mut advance = |speed: f64| -> Result<_, &'static str> {
            let (torque, rubbing) = asked(formulas, 0, instant(speed))?;
            let outside = weight - torque;
            let momentum_by_step = inertia_by_step * w + outside;
            let step = Step { joint, mass_by_step: inertia_by_step, momentum_by_step, outside, rubbing, speed: w };
            Ok(step.driven(command, demand, &mut reciprocal))
        };
        let (mut after, mut motor) = (w, Motor { torque: 0.0, braking: 0.0, passive: 0.0 });
        for _ in 0..passes {
            (after, motor) = advance(0.5 * (w + after))?;
        }
        if out.holds_torques() {
            out.torque(k, 0, motor.torque - (motor.braking - motor.passive) * 0.5 * (w + after));
        }
        out.state(k + 1, 0, middle + 0.5 * dt * after, after);
        // The middle of the next step lies half of this step and half of that one later, both at the speed between them.
        (w, moved) = (after, dt * after);
        middle += moved;
    }
    Ok(())
}
