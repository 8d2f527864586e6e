//! From a formula as it was written to one whose `sign` and `delay` are names as well: sides of switching surfaces and delayed
//! inputs.

use tunenet_formula::{Formula, FormulaError, Function, Node, Program, Tree};

use super::Misfit;
use super::parts::{Compiled, Delayed, Slots, Surface, is_name_within};

/// What `delay` is refused with.
const NO_INPUT: &str = "what is no input: of inputs alone earlier values are known";

/// What has been found in formulas so far.
pub(super) struct Lowering<'a> {
    slots: &'a Slots,
    pub surfaces: Vec<Surface>,
    pub delayed: Vec<Delayed>,
    /// The trees of the delays.
    delays: Vec<Tree>,
    /// Parts of formulas that do not change during a rollout, with their positions.
    pub fixed: Vec<(usize, Compiled)>,
    /// How many values there are.
    pub count: usize,
}

impl<'a> Lowering<'a> {
    pub fn new(slots: &'a Slots) -> Self {
        Self {
            slots,
            surfaces: Vec::new(),
            delayed: Vec::new(),
            delays: Vec::new(),
            fixed: Vec::new(),
            count: slots.count,
        }
    }

    /// A formula over the array of values. Names from the first number of `own` on stand from its second number on. `owner` is the
    /// candidate that it belongs to.
    pub fn lower(
        &mut self,
        path: &str,
        formula: &Formula,
        own: Option<(usize, usize)>,
        owner: Option<usize>,
    ) -> Result<Compiled, Misfit> {
        self.lowered(formula.tree(), own, owner).map_err(|error| Misfit::within(path, error))
    }

    /// The formula of an event, whose `abs` bend at a switching surface: a step that ends there passes over nothing that they do.
    pub fn lower_event(&mut self, path: &str, formula: &Formula) -> Result<Compiled, Misfit> {
        self.lowered(&without_abs(formula.tree()), None, None).map_err(|error| Misfit::within(path, error))
    }

    fn lowered(
        &mut self,
        tree: &Tree,
        own: Option<(usize, usize)>,
        owner: Option<usize>,
    ) -> Result<Compiled, FormulaError> {
        let tree = self.tree(tree, own, owner)?;
        self.without_fixed(tree).and_then(compiled)
    }

    /// The tree with a name for every part that only parameters, constants and coefficients determine.
    fn without_fixed(&mut self, tree: Tree) -> Result<Tree, FormulaError> {
        let own = self.slots.inputs.end..self.slots.count;
        let moves = |node: &Node| matches!(node, Node::Name { .. }) && !is_name_within(node, &own);
        if !matches!(tree.node, Node::Call { .. }) {
            return Ok(tree);
        }
        if tree.any(&moves) {
            let Tree { node: Node::Call { function, arguments }, .. } = tree else { return Ok(tree) };
            let arguments = arguments.into_iter().map(|one| self.without_fixed(one)).collect::<Result<_, _>>()?;
            return Ok(bare(Node::Call { function, arguments }));
        }
        // A number as an exponent is recognised by the compiler.
        if !tree.any(&|node| matches!(node, Node::Name { .. })) {
            return Ok(tree);
        }
        if let Some((slot, _)) = self.fixed.iter().find(|(_, known)| known.tree == tree) {
            return Ok(name(*slot));
        }
        let slot = self.slot();
        self.fixed.push((slot, compiled(tree)?));
        Ok(name(slot))
    }

    fn tree(&mut self, tree: &Tree, own: Option<(usize, usize)>, owner: Option<usize>) -> Result<Tree, FormulaError> {
        Ok(match &tree.node {
            Node::Number(_) => bare(tree.node.clone()),
            Node::Name { index, .. } => name(match own {
                Some((first, to)) if *index >= first => index - first + to,
                _ => *index,
            }),
            Node::Call { function: Function::Sign, arguments } => {
                let argument = self.tree(&arguments[0], own, owner)?;
                name(self.side(argument, owner)?)
            }
            Node::Call { function: Function::Delay, arguments } => {
                let input = match &arguments[0].node {
                    node if is_name_within(node, &self.slots.inputs) => self.tree(&arguments[0], own, owner)?,
                    _ => return Err(refused(&arguments[0], "the name of an input", NO_INPUT)),
                };
                let by = self.tree(&arguments[1], own, owner)?;
                let moves = |node: &Node| {
                    is_name_within(node, &(0..self.slots.inputs.end))
                        || is_name_within(node, &(self.slots.count..usize::MAX))
                };
                if by.any(&moves) {
                    let expected = "a delay of parameters, coefficients and constants";
                    return Err(refused(&arguments[1], expected, "one that changes during the motion"));
                }
                name(self.delay(&input, by)?)
            }
            Node::Call { function, arguments } => {
                let arguments = arguments.iter().map(|one| self.tree(one, own, owner)).collect::<Result<_, _>>()?;
                bare(Node::Call { function: *function, arguments })
            }
        })
    }

    /// The position of the side of a surface.
    fn side(&mut self, argument: Tree, owner: Option<usize>) -> Result<usize, FormulaError> {
        if let Some(known) = self.surfaces.iter_mut().find(|known| known.of.tree == argument) {
            if !known.owners.contains(&owner) {
                known.owners.push(owner);
            }
            return Ok(known.side);
        }
        let side = self.slot();
        let argument_of = compiled(argument)?;
        self.surfaces.push(Surface { of: argument_of, side, owners: vec![owner] });
        Ok(side)
    }

    fn delay(&mut self, input: &Tree, by: Tree) -> Result<usize, FormulaError> {
        let Node::Name { index, .. } = input.node else { return Ok(0) };
        let number = index - self.slots.inputs.start;
        let known = self.delayed.iter().zip(&self.delays).find(|(known, tree)| known.input == number && **tree == by);
        if let Some((known, _)) = known {
            return Ok(known.slot);
        }
        let slot = self.slot();
        self.delayed.push(Delayed { input: number, by: compiled(by.clone())?.program, slot });
        self.delays.push(by);
        Ok(slot)
    }

    fn slot(&mut self) -> usize {
        self.count += 1;
        self.count - 1
    }
}

/// The same with `x*sign(x)` for `abs(x)`.
fn without_abs(tree: &Tree) -> Tree {
    let Node::Call { function, arguments } = &tree.node else { return tree.clone() };
    let arguments: Vec<Tree> = arguments.iter().map(without_abs).collect();
    let call = |function, arguments| Tree { node: Node::Call { function, arguments }, place: tree.place.clone() };
    if *function != Function::Abs {
        return call(*function, arguments);
    }
    let side = call(Function::Sign, arguments.clone());
    call(Function::Multiply, arguments.into_iter().chain([side]).collect())
}

fn compiled(tree: Tree) -> Result<Compiled, FormulaError> {
    let program = Program::switched(&tree, &mut Vec::new())?;
    Ok(Compiled { tree, program })
}

fn refused(at: &Tree, expected: &str, found: &str) -> FormulaError {
    FormulaError { place: at.place.clone(), expected: expected.into(), found: found.into() }
}

/// A node without a place, so that equal formulas are equal trees.
fn bare(node: Node) -> Tree {
    Tree { node, place: 0..0 }
}

fn name(index: usize) -> Tree {
    bare(Node::Name { text: String::new(), index })
}
