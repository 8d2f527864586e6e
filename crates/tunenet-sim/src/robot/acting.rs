//! An effect that acts on robot joints: one of the catalogue, or a formula of the user's.

use tunenet_core::simulator::Effect;

use super::effects::RobotEffect;
use super::imperfect::Imperfect;
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
#[inline]
pub(super) fn asked(formulas: &[AppliedTorque], j: usize, t: f64, q: f64, dq: f64) -> (f64, f64) {
    formulas.iter().fold((0.0, 0.0), |(torque, rubbing), one| {
        let (forward, backward) = one.sides(j, t, q, dq);
        (torque + 0.5 * (forward + backward), rubbing + 0.5 * (forward - backward))
    })
}
