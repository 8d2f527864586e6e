//! What a simulator offers to a search for a law: directions in which a term may act, and variables that it may depend on.

use crate::Result;
use crate::simulator::{Effect, Prepared, Simulator};

use super::Term;

/// What a variable is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nature {
    /// A number of either sign, as all but the clock; where the recordings visit positive values only, it is treated as positive. Where it is
    /// 0, nothing jumps, as with a position.
    Number,
    /// A rate of a position: where it is 0, motion may stop, and a term may jump there.
    Rate,
    /// A state of first order, of which a term changes the derivative: it may stop at 0 as a rate does, and be an angle.
    FirstOrder,
    /// The time on the clock of a recording.
    Clock,
}

/// A variable that a term may depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name in formulas.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub nature: Nature,
}

impl Nature {
    /// Whether a term may jump where a variable of this kind is 0.
    pub(super) const fn may_jump(self) -> bool {
        matches!(self, Self::Rate | Self::FirstOrder)
    }
}

/// A direction: one component, or several that share a factor, each with a coefficient of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Direction {
    /// The names of its components, of which each is a direction of the simulator.
    pub components: Vec<String>,
}

/// Directions and variables.
#[derive(Debug, Clone, PartialEq)]
pub struct Space {
    /// The directions, each component with an acceleration of every axis (see [`Visit`]).
    pub directions: Vec<Direction>,
    /// The variables.
    pub variables: Vec<Variable>,
    /// Positions of the directions that are the axes: of one component each, they span every acceleration.
    pub axes: Vec<usize>,
    /// Names besides those of the variables that no number of a law may have: formulas of the simulation use them.
    pub taken: Vec<String>,
}

impl Space {
    /// `wanted`, or a name that begins so and that nothing else has.
    pub(super) fn free_name(&self, wanted: String) -> String {
        let is_taken = |name: &String| self.taken.contains(name) || self.variables.iter().any(|v| v.name == *name);
        let mut name = wanted;
        while is_taken(&name) {
            name.push_str("_law");
        }
        name
    }
}

/// What one instant of a rollout visits.
#[derive(Debug, Clone, PartialEq)]
pub struct Visit {
    /// The values of all variables.
    pub variables: Vec<f64>,
    /// What a unit of each component adds to each axis, shape `[direction][component][axis]`.
    pub components: Vec<Vec<Vec<f64>>>,
}

/// A term with its entry of the catalogue: the name and the bounds of its numbers, in the order of [`Term::constants`].
#[derive(Debug, Clone)]
pub struct Carried {
    /// How it acts.
    pub term: Term,
    /// Its entry.
    pub effect: Effect,
}

/// A simulator that says what its rollouts visit.
pub trait Visiting: Simulator {
    /// What a rollout visits at these instants (s, rising, on the clock of the recording).
    ///
    /// # Errors
    /// Where the simulator refuses these values.
    fn visits(
        &self,
        recording: &Prepared,
        parameters: &[f64],
        nuisances: &[f64],
        instants_s: &[f64],
    ) -> Result<Vec<Visit>>;
}

/// A simulator whose equations of motion take further terms.
pub trait Host: Send + Sync {
    /// Directions and variables.
    fn space(&self) -> &Space;

    /// The simulator with these terms: their numbers follow its parameters, each at its absent value.
    ///
    /// # Errors
    /// Where a term cannot be carried.
    fn carrying(&self, terms: &[Carried]) -> Result<Box<dyn Visiting>>;

    /// The unit of a coefficient along a direction that multiplies powers of variables (variable, exponent).
    fn unit(&self, direction: usize, powers: &[(usize, f64)]) -> String;

    /// The effect of the catalogue that a term is where its one open or rounded exponent has this value, if any.
    fn alias(&self, term: &Term, exponent: Option<f64>) -> Option<&'static str> {
        let _ = (term, exponent);
        None
    }
}
