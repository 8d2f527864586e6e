//! What equations are made of once their names are positions in one array of values.

use std::ops::Range;

use tunenet_formula::{Node, Program, Tree};

/// A formula whose names are positions in the array of values.
#[derive(Debug, Clone)]
pub(super) struct Compiled {
    pub tree: Tree,
    pub program: Program,
}

/// Where the argument of a `sign` is zero.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    pub of: Compiled,
    /// The position of its side in the array.
    pub side: usize,
    /// The candidates that use it; `None` stands for the equations themselves.
    pub owners: Vec<Option<usize>>,
}

/// An input at an earlier instant.
#[derive(Debug, Clone)]
pub(super) struct Delayed {
    pub input: usize,
    /// How much earlier, s: it does not change during a rollout.
    pub by: Program,
    pub slot: usize,
}

/// Where things stand in the array of values: states, clock, inputs, parameters, constants, coefficients, delayed inputs and sides.
#[derive(Debug, Clone, Default)]
pub(super) struct Slots {
    pub clock: usize,
    pub inputs: Range<usize>,
    pub parameters: Range<usize>,
    pub constants: Range<usize>,
    pub coefficients: Range<usize>,
    pub count: usize,
}

impl Slots {
    /// The positions of what stays as it is during a rollout.
    pub fn still(&self) -> Range<usize> {
        self.parameters.start..self.coefficients.end
    }
}

/// Whether a node is a name at one of these positions.
pub(super) fn is_name_within(node: &Node, positions: &Range<usize>) -> bool {
    matches!(node, Node::Name { index, .. } if positions.contains(index))
}
