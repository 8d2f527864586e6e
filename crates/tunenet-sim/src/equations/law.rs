//! Terms of a law that is searched, evaluated natively: what they add to derivatives, and what they may depend on.

use std::sync::Arc;

use tunenet_core::law::{Shape, Term};

/// Most variables of a law.
pub(crate) const MOST_VARIABLES: usize = 24;

/// A variable, as positions in the array of values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Quantity {
    /// A state, or the clock.
    Slot(usize),
    /// The length of a vector of states.
    Length(Vec<usize>),
}

/// Where a component points, as positions among the states.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Pointing {
    /// At one state's derivative.
    Axis(usize),
    /// Along a vector of states, at the derivatives of others: a place or a velocity.
    Along { vector: Vec<usize>, at: Vec<usize> },
    /// Along the same turned by 90°, of two states.
    Turned { vector: [usize; 2], at: [usize; 2] },
}

impl Quantity {
    /// Its value, from states and the clock.
    pub fn value(&self, values: &[f64]) -> f64 {
        match self {
            Self::Slot(slot) => values[*slot],
            Self::Length(states) => length(states, values),
        }
    }
}

fn length(states: &[usize], values: &[f64]) -> f64 {
    states.iter().map(|i| values[*i] * values[*i]).sum::<f64>().sqrt()
}

impl Pointing {
    /// Adds `size` along it to the derivatives.
    fn add(&self, size: f64, values: &[f64], out: &mut [f64]) {
        match self {
            Self::Axis(state) => out[*state] += size,
            Self::Along { vector, at } => {
                let length = length(vector, values);
                if length > 0.0 {
                    vector.iter().zip(at).for_each(|(from, to)| out[*to] += size * values[*from] / length);
                }
            }
            Self::Turned { vector: [a, b], at } => {
                let length = length(&[*a, *b], values);
                if length > 0.0 {
                    out[at[0]] -= size * values[*b] / length;
                    out[at[1]] += size * values[*a] / length;
                }
            }
        }
    }
}

/// What terms of a law may use of a system.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reach {
    pub quantities: Vec<Quantity>,
    /// The components of every direction.
    pub directions: Vec<Vec<Pointing>>,
    pub clock: usize,
}

impl Reach {
    /// The values of all variables and what a unit of every component adds to these derivatives, from states and the clock.
    pub fn visit(&self, values: &[f64], axes: &[usize]) -> (Vec<f64>, Vec<Vec<Vec<f64>>>) {
        let variables = self.quantities.iter().map(|q| q.value(values)).collect();
        let one = |pointing: &Pointing| {
            let mut out = vec![0.0; values.len()];
            pointing.add(1.0, values, &mut out);
            axes.iter().map(|axis| out[*axis]).collect()
        };
        (variables, self.directions.iter().map(|all| all.iter().map(one).collect()).collect())
    }
}

/// A term of a system.
#[derive(Debug, Clone)]
pub(super) struct LawTerm {
    term: Term,
    reach: Arc<Reach>,
    /// Where the side of each factor's variable stands in the array of values, where the term jumps there.
    sides: Vec<Option<usize>>,
}

impl LawTerm {
    /// A term, with the slot of the side of each factor's variable where the term jumps there.
    pub fn new(term: &Term, reach: &Arc<Reach>, sides: Vec<Option<usize>>) -> Self {
        Self { term: term.clone(), reach: Arc::clone(reach), sides }
    }

    /// How many numbers it has.
    pub fn numbers(&self) -> usize {
        self.term.constants()
    }

    /// Whether it bends sharply somewhere.
    pub fn bends(&self, numbers: &[f64]) -> bool {
        self.term.bends(numbers)
    }

    /// From when to when a window of it lasts, s.
    pub fn window(&self, numbers: &[f64]) -> Option<[f64; 2]> {
        let window = self.term.factors.first().is_some_and(|factor| factor.shape == Shape::Window);
        window.then(|| [numbers[self.term.components], numbers[self.term.components + 1]])
    }

    /// Adds it to the derivatives; `window_s` is an instant of the piece between windows.
    pub fn add(&self, numbers: &[f64], values: &[f64], window_s: f64, out: &mut [f64]) {
        let (mut variables, mut sides) = ([0.0; MOST_VARIABLES], [0.0_f64; MOST_VARIABLES]);
        for (factor, side) in self.term.factors.iter().zip(&self.sides) {
            let value = self.reach.quantities[factor.variable].value(values);
            variables[factor.variable] = if factor.shape == Shape::Window { window_s } else { value };
            sides[factor.variable] = side.map_or_else(|| value.signum(), |slot| values[slot]);
        }
        let product = self.term.product(numbers, &variables, &sides);
        for (pointing, coefficient) in self.reach.directions[self.term.direction].iter().zip(numbers) {
            pointing.add(coefficient * product, values, out);
        }
    }
}
