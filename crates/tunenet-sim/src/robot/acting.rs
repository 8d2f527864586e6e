//! An effect that acts on robot joints: one of the catalogue, or a formula of the user's.

use tunenet_core::simulator::Effect;

use super::effects::RobotEffect;
use super::imperfect::Imperfect;
use super::trajectory::Trajectory;
use crate::formula_effect::joint::AppliedTorque;
use crate::formula_effect::{Acts, FormulaEffect};

/// The effect.
#[derive(Debug, Clone)]
pub(crate) enum Acting {
    BuiltIn(RobotEffect),
    Formula(Box<FormulaEffect>),
}

impl Acting {
    /// How many numbers it has on a robot of so many joints.
    pub fn numbers(&self, joints: usize) -> usize {
        match self {
            Self::BuiltIn(effect) => effect.numbers(joints) * effect.coefficients.len(),
            Self::Formula(formula) => formula.effect.coefficients.len(),
        }
    }

    /// Adds it to what the robot has.
    pub fn apply(&self, robot: &mut Imperfect, values: &[f64]) {
        match self {
            Self::BuiltIn(effect) => effect.apply(robot, values),
            Self::Formula(formula) => {
                if let Acts::Joint(torque) = &formula.acts
                    && is_there(&formula.effect, values)
                {
                    robot.arm.formulas.push(AppliedTorque::new(torque, values));
                }
            }
        }
    }
}

/// Whether a number that switches the effect off has another value than that.
fn is_there(effect: &Effect, values: &[f64]) -> bool {
    let mut switches = effect.coefficients.iter().zip(values).filter(|(c, _)| !c.shape).peekable();
    switches.peek().is_none() || switches.any(|(c, value)| *value != c.absent)
}

/// What the formulas ask of joint `j` at this instant, position and speed: the torque that the motion needs more in either direction, and
/// half of what jumps when it turns, which holds the joint as dry friction does.
///
/// # Errors
/// Where that is not finite.
#[inline]
pub(super) fn asked(formulas: &[AppliedTorque], j: usize, t: f64, q: f64, dq: f64) -> Result<(f64, f64), &'static str> {
    if formulas.is_empty() {
        return Ok((0.0, 0.0));
    }
    let (torque, rubbing) = formulas.iter().fold((0.0, 0.0), |(torque, rubbing), one| {
        let (forward, backward) = one.sides(j, t, q, dq);
        (torque + 0.5 * (forward + backward), rubbing + 0.5 * (forward - backward))
    });
    // Friction would hold a joint that a torque without a value acts on.
    if f64::is_finite(torque + rubbing) { Ok((torque, rubbing)) } else { Err("a formula has no finite value") }
}

/// Which formula has no finite value on a trajectory, and when.
pub(super) fn undefined(formulas: &[AppliedTorque], out: &Trajectory) -> Option<String> {
    let at = |k: usize, j: usize| {
        let (q, w) = out.state_at(k, j);
        let middle = (out.time(k) + 0.5 * out.step_s, q + 0.5 * out.step_s * w, w);
        let part = formulas.iter().find_map(|one| one.undefined(j, middle))?;
        Some(format!("{part} at {:.6} s", out.time(k)))
    };
    (0..out.steps()).find_map(|k| (0..out.joints()).find_map(|j| at(k, j)))
}

/// Which formula has a pole on a trajectory, and when.
pub(super) fn pole(formulas: &[AppliedTorque], out: &Trajectory) -> Option<String> {
    let dividing: Vec<&AppliedTorque> = formulas.iter().filter(|one| one.divides()).collect();
    let at = |k: usize, j: usize| {
        let (q, w) = out.state_at(k, j);
        (out.time(k), q, w)
    };
    let passed = |k: usize, j: usize| {
        let part = dividing.iter().find_map(|one| one.pole(j, at(k, j), at(k + 1, j)))?;
        Some(format!("{part} at {:.6} s", out.time(k)))
    };
    let steps = if dividing.is_empty() { 0 } else { out.steps() };
    (0..steps).find_map(|k| (0..out.joints()).find_map(|j| passed(k, j)))
}
