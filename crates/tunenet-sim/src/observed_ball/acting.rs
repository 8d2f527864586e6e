//! An effect that acts on an observed ball: one of the catalogue, or a formula of the user's.

use tunenet_core::observation::Note;
use tunenet_core::simulator::{Effect, Phase};

use crate::ball::Scene;
use crate::ball::effects::{BallEffect, Body};
use crate::formula_effect::contact::AppliedContact;
use crate::formula_effect::flight::AppliedForce;
use crate::formula_effect::{Acts, FormulaEffect};

/// The effect.
#[derive(Debug, Clone)]
pub(crate) enum Acting {
    BuiltIn(BallEffect),
    Formula(Box<FormulaEffect>),
}

impl Acting {
    pub fn name(&self) -> &str {
        match self {
            Self::BuiltIn(effect) => effect.name,
            Self::Formula(formula) => &formula.effect.name,
        }
    }

    pub fn phase(&self) -> &Phase {
        match self {
            Self::BuiltIn(effect) => effect.phase,
            Self::Formula(formula) => &formula.effect.phase,
        }
    }

    /// How many numbers it has.
    pub fn numbers(&self) -> usize {
        match self {
            Self::BuiltIn(effect) => effect.coefficients.len(),
            Self::Formula(formula) => formula.effect.coefficients.len(),
        }
    }

    /// Its entry for this ball.
    pub fn entry(&self, body: &Body) -> Effect {
        match self {
            Self::BuiltIn(effect) => effect.entry(body),
            Self::Formula(formula) => formula.effect.clone(),
        }
    }

    /// Whether the bounce times of a vertical drop show it.
    pub fn shows_in_bounce_times(&self) -> bool {
        match self {
            Self::BuiltIn(effect) => effect.shows_in_bounce_times,
            Self::Formula(formula) => match &formula.acts {
                Acts::Flight(force) => force.shows_in_a_drop(),
                Acts::Contact(_) => true,
                Acts::Joint(_) => false,
            },
        }
    }

    /// What a user should know of it where it acts.
    pub fn notes(&self) -> Vec<Note> {
        match self {
            Self::BuiltIn(_) => Vec::new(),
            Self::Formula(formula) => formula.notes(),
        }
    }

    /// The force of a formula with these numbers.
    pub fn force(&self, values: &[f64]) -> Option<AppliedForce> {
        match self {
            Self::Formula(formula) => match &formula.acts {
                Acts::Flight(force) => Some(AppliedForce::new(force, values)),
                _ => None,
            },
            Self::BuiltIn(_) => None,
        }
    }

    /// Adds it to a scene.
    pub fn apply(&self, scene: &mut Scene, values: &[f64]) {
        match self {
            Self::BuiltIn(effect) => (effect.apply)(scene, values),
            Self::Formula(formula) => apply_formula(formula, scene, values),
        }
    }
}

/// Adds a formula with its numbers to a scene.
pub(crate) fn apply_formula(formula: &FormulaEffect, scene: &mut Scene, values: &[f64]) {
    match &formula.acts {
        Acts::Flight(force) => scene.formulas.flight.push(AppliedForce::new(force, values)),
        Acts::Contact(contact) => scene.formulas.contact.push(AppliedContact::new(contact, values)),
        Acts::Joint(_) => {}
    }
}
