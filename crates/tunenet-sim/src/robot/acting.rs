//! An effect that acts on robot joints: one of the catalogue, or a formula of the user's.

use tunenet_core::simulator::Effect;

use super::effects::RobotEffect;
use super::imperfect::Imperfect;
use super::trajectory::Trajectory;
use super::wiring::Wire;
use crate::formula_effect::joint::{AppliedTorque, JointInstant};
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

/// What the formulas ask of joint `j`: the torque that the motion needs more in either direction, and half of what jumps when it turns, which
/// holds the joint as dry friction does.
///
/// # Errors
/// Where that is not finite.
#[inline]
pub(super) fn asked(formulas: &[AppliedTorque], j: usize, at: JointInstant) -> Result<(f64, f64), &'static str> {
    if formulas.is_empty() { Ok((0.0, 0.0)) } else { summed(formulas, j, at) }
}

fn summed(formulas: &[AppliedTorque], j: usize, at: JointInstant) -> Result<(f64, f64), &'static str> {
    let (torque, rubbing) = formulas.iter().fold((0.0, 0.0), |(torque, rubbing), one| {
        let (forward, backward) = one.sides(j, at);
        (torque + 0.5 * (forward + backward), rubbing + 0.5 * (forward - backward))
    });
    // Friction would hold a joint that a torque without a value acts on.
    if f64::is_finite(torque + rubbing) { Ok((torque, rubbing)) } else { Err("a formula has no finite value") }
}

/// The commands of every step of a trajectory, shape `[step][joint]`, by wires that nothing was read from.
fn commands(mut wires: Vec<Wire>, out: &Trajectory) -> Vec<Vec<f64>> {
    (0..out.steps()).map(|_| wires.iter_mut().map(|wire| wire.command().goal).collect()).collect()
}

/// Which formula has no finite value on a trajectory, and when; its commands come by these wires, from which nothing was read.
pub(super) fn undefined(formulas: &[AppliedTorque], wires: Vec<Wire>, out: &Trajectory) -> Option<String> {
    let commands = commands(wires, out);
    let at = |k: usize, j: usize| {
        let (q, w) = out.state_at(k, j);
        let half = 0.5 * out.step_s();
        let middle = JointInstant { t: out.time(k) + half, q: q + half * w, dq: w, command: commands[k][j] };
        let part = formulas.iter().find_map(|one| one.undefined(j, middle))?;
        Some(format!("{part} at {:.6} s", out.time(k)))
    };
    (0..out.steps()).find_map(|k| (0..out.joints()).find_map(|j| at(k, j)))
}

/// Which formula has a pole on a trajectory, and when; its commands come by `wires`, from which nothing was read.
pub(super) fn pole<'a>(
    formulas: &[AppliedTorque],
    wires: impl FnOnce() -> Vec<Wire<'a>>,
    out: &Trajectory,
) -> Option<String> {
    let dividing: Vec<&AppliedTorque> = formulas.iter().filter(|one| one.divides()).collect();
    if dividing.is_empty() {
        return None;
    }
    let commands = commands(wires(), out);
    let last = commands.len() - 1;
    let at = |k: usize, j: usize| {
        let (q, dq) = out.state_at(k, j);
        JointInstant { t: out.time(k), q, dq, command: commands[k.min(last)][j] }
    };
    let passed = |k: usize, j: usize| {
        let part = dividing.iter().find_map(|one| one.pole(j, at(k, j), at(k + 1, j)))?;
        Some(format!("{part} at {:.6} s", out.time(k)))
    };
    (0..out.steps()).find_map(|k| (0..out.joints()).find_map(|j| passed(k, j)))
}
