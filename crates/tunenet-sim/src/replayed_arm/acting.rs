//! An effect that acts on a replayed arm: one of the catalogue, or a formula of the user's.

use tunenet_core::observation::Note;
use tunenet_core::simulator::Effect;

use crate::arm::effects::{ArmEffect, Imperfections};
use crate::formula_effect::joint::AppliedTorque;
use crate::formula_effect::{Acts, FormulaEffect};

/// The effect.
#[derive(Debug, Clone)]
pub(super) enum Acting {
    BuiltIn(ArmEffect),
    Formula(Box<FormulaEffect>),
}

impl Acting {
    pub fn name(&self) -> &str {
        match self {
            Self::BuiltIn(effect) => effect.name,
            Self::Formula(formula) => &formula.effect.name,
        }
    }

    /// How many numbers it has on an arm of so many joints.
    pub fn numbers(&self, joints: usize) -> usize {
        match self {
            Self::BuiltIn(effect) => effect.numbers(joints) * effect.coefficients.len(),
            Self::Formula(formula) => formula.effect.coefficients.len(),
        }
    }

    /// Its entry for an arm of so many joints.
    pub fn entry(&self, joints: usize) -> Effect {
        match self {
            Self::BuiltIn(effect) => effect.entry(joints),
            Self::Formula(formula) => formula.effect.clone(),
        }
    }

    /// What a user should know of it where it acts.
    pub fn notes(&self) -> Vec<Note> {
        match self {
            Self::BuiltIn(_) => Vec::new(),
            Self::Formula(formula) => formula.notes(),
        }
    }

    /// Adds it to what the arm has.
    pub fn apply(&self, arm: &mut Imperfections, values: &[f64]) {
        match self {
            Self::BuiltIn(effect) => (effect.apply)(arm, values),
            Self::Formula(formula) => {
                if let Acts::Joint(torque) = &formula.acts {
                    arm.formulas.push(AppliedTorque::new(torque, values));
                }
            }
        }
    }
}
