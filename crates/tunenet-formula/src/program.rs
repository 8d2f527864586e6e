//! Evaluation by a postfix stack machine: a flat list of operations and a small stack, no allocation.

use crate::check::number;
use crate::function::sign;
use crate::switch;
use crate::tree::{Node, Tree};
use crate::{FormulaError, Function};

/// Most values on the stack at a time.
const DEEPEST: usize = 64;
/// Most that most formulas need, whose stack is prepared sooner.
const SHALLOW: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Number(f64),
    /// The value of the name at this position.
    Load(usize),
    Unary(Function),
    Binary(Function),
    /// With the value of the name at this position as the second one.
    BinaryWith(Function, usize),
    Clamp,
    /// To the power 2, a constant that the compiler knows.
    Square,
    Cube,
    Whole(i32),
    /// The side of the switching surface at this position: −1 to 1.
    Side(usize),
    /// What the name at this position was, the value on the stack ago, s.
    Delayed(usize),
}

/// A formula as operations on a stack.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    operations: Vec<Operation>,
    /// Most values on the stack at a time.
    deepest: usize,
}

impl Program {
    /// The operations of a tree.
    ///
    /// # Errors
    /// Where the formula is nested too deeply.
    pub fn compile(tree: &Tree) -> Result<Self, FormulaError> {
        Self::made(tree, None)
    }

    /// The operations of a tree in which every `sign` is the side of a switching surface: its argument, which is added to
    /// `surfaces` where it is not among them yet. [`run`](Self::run) takes the sides.
    ///
    /// # Errors
    /// Where the formula is nested too deeply.
    pub fn switched(tree: &Tree, surfaces: &mut Vec<Tree>) -> Result<Self, FormulaError> {
        Self::made(tree, Some(surfaces))
    }

    fn made(tree: &Tree, surfaces: Option<&mut Vec<Tree>>) -> Result<Self, FormulaError> {
        let mut program = Self::default();
        let deepest = program.push(tree, surfaces)?;
        if deepest > DEEPEST {
            let expected = format!("at most {DEEPEST} values at a time");
            return Err(FormulaError::new(tree.place.clone(), expected, deepest.to_string()));
        }
        program.deepest = deepest;
        Ok(program)
    }

    /// Appends what puts the value of `tree` on the stack; how many values are on it at most.
    fn push(&mut self, tree: &Tree, mut surfaces: Option<&mut Vec<Tree>>) -> Result<usize, FormulaError> {
        let (function, arguments) = match &tree.node {
            Node::Number(value) => {
                self.operations.push(Operation::Number(*value));
                return Ok(1);
            }
            Node::Name { index, .. } => {
                self.operations.push(Operation::Load(*index));
                return Ok(1);
            }
            Node::Call { function, arguments } => (*function, arguments),
        };
        if let (Function::Sign, Some(surfaces)) = (function, surfaces.as_deref_mut()) {
            self.operations.push(Operation::Side(switch::position(&arguments[0], surfaces)));
            return Ok(1);
        }
        if function == Function::Delay {
            let Node::Name { index, .. } = &arguments[0].node else {
                let found = "a formula".to_owned();
                return Err(FormulaError::new(arguments[0].place.clone(), "the name of an input", found));
            };
            let deepest = self.push(&arguments[1], surfaces)?;
            self.operations.push(Operation::Delayed(*index));
            return Ok(deepest);
        }
        if function == Function::Power
            && let Some(exponent) = number(&arguments[1])
        {
            let whole = (exponent.fract() == 0.0 && exponent.abs() <= 64.0).then_some(exponent);
            let root = (exponent == 0.5).then_some(Operation::Unary(Function::Sqrt));
            #[expect(clippy::cast_possible_truncation, reason = "whole and at most 64")]
            let operation = root.or_else(|| {
                whole.map(|exponent| match exponent as i32 {
                    2 => Operation::Square,
                    3 => Operation::Cube,
                    other => Operation::Whole(other),
                })
            });
            if let Some(operation) = operation {
                let deepest = self.push(&arguments[0], surfaces)?;
                self.operations.push(operation);
                return Ok(deepest);
            }
        }
        let mut deepest = 0;
        for (i, argument) in arguments.iter().enumerate() {
            deepest = deepest.max(i + self.push(argument, surfaces.as_deref_mut())?);
        }
        let operation = match (arguments.len(), self.operations.last()) {
            (1, _) => Operation::Unary(function),
            (2, Some(&Operation::Load(name))) => {
                self.operations.pop();
                Operation::BinaryWith(function, name)
            }
            (2, _) => Operation::Binary(function),
            _ => Operation::Clamp,
        };
        self.operations.push(operation);
        Ok(deepest)
    }

    /// The value with these values of all names, in their order.
    ///
    /// # Panics
    /// Where there are fewer values than names.
    #[must_use]
    pub fn value(&self, values: &[f64]) -> f64 {
        self.run(values, &[], |name, _| values[name])
    }

    /// As [`value`](Self::value), with the side of every switching surface and with what a name was a while (s) ago.
    ///
    /// # Panics
    /// Where there are fewer values than names, or fewer sides than surfaces.
    #[must_use]
    pub fn run(&self, values: &[f64], sides: &[f64], delayed: impl Fn(usize, f64) -> f64) -> f64 {
        if let [Operation::Load(name)] = self.operations[..] {
            return values[name];
        }
        if self.deepest <= SHALLOW {
            self.on_stack::<SHALLOW>(values, sides, delayed)
        } else {
            self.on_stack::<DEEPEST>(values, sides, delayed)
        }
    }

    #[inline]
    fn on_stack<const SIZE: usize>(&self, values: &[f64], sides: &[f64], delayed: impl Fn(usize, f64) -> f64) -> f64 {
        let mut stack = [0.0; SIZE];
        let mut top = 0;
        for operation in &self.operations {
            match *operation {
                Operation::Number(value) => {
                    stack[top] = value;
                    top += 1;
                }
                Operation::Load(name) => {
                    stack[top] = values[name];
                    top += 1;
                }
                Operation::Side(surface) => {
                    stack[top] = sides[surface];
                    top += 1;
                }
                Operation::Unary(function) => {
                    let x = &mut stack[top - 1];
                    *x = unary(function, *x);
                }
                Operation::Binary(function) => {
                    top -= 1;
                    stack[top - 1] = binary(function, stack[top - 1], stack[top]);
                }
                Operation::BinaryWith(function, name) => {
                    let x = &mut stack[top - 1];
                    *x = binary(function, *x, values[name]);
                }
                Operation::Clamp => {
                    top -= 2;
                    stack[top - 1] = stack[top - 1].max(stack[top]).min(stack[top + 1]);
                }
                Operation::Square => stack[top - 1] = stack[top - 1].powi(2),
                Operation::Cube => stack[top - 1] = stack[top - 1].powi(3),
                Operation::Whole(exponent) => stack[top - 1] = stack[top - 1].powi(exponent),
                Operation::Delayed(name) => stack[top - 1] = delayed(name, stack[top - 1]),
            }
        }
        stack[0]
    }

    /// Whether it asks what a name was before.
    #[must_use]
    pub fn looks_back(&self) -> bool {
        self.operations.iter().any(|operation| matches!(operation, Operation::Delayed(_)))
    }
}

#[inline]
fn unary(function: Function, x: f64) -> f64 {
    match function {
        Function::Negate => -x,
        Function::Abs => x.abs(),
        Function::Sign => sign(x),
        Function::Sqrt => x.sqrt(),
        Function::Exp => x.exp(),
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
        other => other.apply(&[x]),
    }
}

#[inline]
fn binary(function: Function, x: f64, y: f64) -> f64 {
    match function {
        Function::Add => x + y,
        Function::Subtract => x - y,
        Function::Multiply => x * y,
        Function::Divide => x / y,
        Function::Power => x.powf(y),
        other => other.apply(&[x, y]),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Formula, Name};

    fn formula(text: &str) -> Formula {
        let names = ["x", "y", "z"].map(|name| Name::new(name, None));
        Formula::parse(text, &names).unwrap()
    }

    /// Every node by the table of functions, without a stack.
    fn walked(tree: &Tree, values: &[f64]) -> f64 {
        match &tree.node {
            Node::Number(value) => *value,
            Node::Name { index, .. } => values[*index],
            Node::Call { function, arguments } => {
                let each: Vec<f64> = arguments.iter().map(|argument| walked(argument, values)).collect();
                function.apply(&each)
            }
        }
    }

    proptest! {
        #[test]
        fn the_machine_agrees_with_the_tree(x in -3.0..3.0_f64, y in 0.1..3.0_f64, z in -1.0..1.0_f64) {
            for text in [
                "-x*exp(-((y-z)/0.3)^2)", "x^3-y^2+z^4*y^0.5", "clamp(x,-y,y)/y^-2", "atan2(x,y)*tanh(z)-cbrt(x)",
                "min(x,max(y,z))*sign(x)+abs(z)", "ln(y)*sin(x)-cos(z)*tan(z/2)", "y^z", "-(x-(y-(z-1)))", "sqrt(y)^2-x^2*x",
            ] {
                let (formula, values) = (formula(text), [x, y, z]);
                let (fast, slow) = (formula.program().value(&values), walked(formula.tree(), &values));
                prop_assert!((fast - slow).abs() <= 1e-12 * (1.0 + slow.abs()), "{text}: {fast} {slow}");
            }
        }
    }

    #[test]
    fn a_delay_asks_what_a_name_was() {
        let program = formula("x - delay(y, 2*z)").program().clone();
        assert!(program.looks_back());
        let value = program.run(&[10.0, 5.0, 0.5], &[], |name, ago| 100.0 * name as f64 + ago);
        assert_eq!(value, 10.0 - 101.0);
        let names = ["x"].map(|name| Name::new(name, None));
        let refused = Formula::parse("delay(x + 1, 2.5)", &names).unwrap_err();
        assert_eq!(refused.to_string(), "expected the name of an input, found a formula");
    }

    #[test]
    fn what_needs_too_large_a_stack_is_refused() {
        let names = ["x"].map(|name| Name::new(name, None));
        let deep = vec!["x"; 100].join("^");
        assert!(Formula::parse(&deep, &names).unwrap_err().to_string().contains("at most 64 values at a time"));
    }
}
