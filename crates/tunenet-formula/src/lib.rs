//! Formulas that a user writes into a file: parsed with places, checked for names and units, evaluated fast.
//!
//! ```text
//! text → parse → Tree (with places) → check (names, units) → Program (postfix machine) → value
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `parse` | precedence climbing (Pratt 1973) by winnow |
//! | `tree` | the syntax tree, each node with its place in the text |
//! | `function` | the table of operators and functions |
//! | `unit` | units as products of powers of base units |
//! | `check` | dimensional analysis of a tree |
//! | `program` | evaluation by a postfix stack machine |
//! | `switch` | the surfaces at which `sign` jumps |
//! | `undefined` | which part has no finite value |
//! | `pole` | which part has a pole between two instants |
//!
//! No formula reaches a file, a process or the network; its length and its depth are bounded.
//!
//! ```
//! use tunenet_formula::{Formula, Name, Unit};
//! let names = [Name::new("k", Unit::parse("1/s²")), Name::new("x_m", Unit::parse("m"))];
//! let formula = Formula::parse("-k * x_m", &names)?;
//! assert_eq!(formula.unit().map(|unit| unit.to_string()), Some("m/s²".into()));
//! assert_eq!(formula.program().value(&[4.0, 0.5]), -2.0);
//! # Ok::<(), tunenet_formula::FormulaError>(())
//! ```

mod check;
mod function;
mod parse;
mod pole;
mod program;
mod switch;
mod tree;
mod undefined;
mod unit;

use std::ops::Range;

pub use check::Units;
pub use function::Function;
pub use pole::Divisor;
pub use program::Program;
pub use tree::{Node, Tree};
pub use undefined::Undefined;
pub use unit::Unit;

/// Longest text of a formula, in bytes.
pub const LONGEST: usize = 4000;
/// Names that other programs take for constants, and that are refused for that reason.
pub const CONSTANTS: [&str; 8] = ["e", "E", "pi", "PI", "tau", "TAU", "π", "τ"];

/// What is wrong with a formula, and where.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, found {found}")]
pub struct FormulaError {
    /// The place in the text, in bytes.
    pub place: Range<usize>,
    /// What could stand there.
    pub expected: String,
    /// What stands there.
    pub found: String,
}

impl FormulaError {
    pub(crate) fn new(place: Range<usize>, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self { place, expected: expected.into(), found: found.into() }
    }
}

/// A name that a formula may use: a variable, a coefficient or a constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Name {
    /// As it is written.
    pub name: String,
    /// Its unit; `None` where it is not known, so that nothing is checked of it.
    pub unit: Option<Unit>,
}

impl Name {
    /// A name and its unit.
    #[must_use]
    pub fn new(name: impl Into<String>, unit: Option<Unit>) -> Self {
        Self { name: name.into(), unit }
    }
}

/// A formula whose names and units are checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    text: String,
    tree: Tree,
    units: Units,
    program: Program,
}

impl Formula {
    /// Parses `text`, whose names are positions in `names`.
    ///
    /// # Errors
    /// Where the text is no formula, uses a name that is not among `names`, contradicts itself in its units, is longer than
    /// [`LONGEST`] or nested too deeply.
    pub fn parse(text: &str, names: &[Name]) -> Result<Self, FormulaError> {
        let mut tree = parse::parse(text)?;
        tree.resolve(names)?;
        let units = check::units(&tree, names)?;
        let program = Program::compile(&tree)?;
        Ok(Self { text: text.to_owned(), tree, units, program })
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its syntax tree.
    #[must_use]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Its unit, where that follows from the units of its names.
    #[must_use]
    pub fn unit(&self) -> Option<&Unit> {
        self.units.unit.as_ref()
    }

    /// The places of powers whose exponent is no number, so that their base is read as a multiple of its unit.
    #[must_use]
    pub fn powers_of_units(&self) -> &[Range<usize>] {
        &self.units.powers_of_units
    }

    /// What evaluates it.
    #[must_use]
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Refuses a formula whose unit is known and is not `expected`.
    ///
    /// # Errors
    /// Where it is another.
    pub fn require_unit(&self, expected: &Unit) -> Result<(), FormulaError> {
        match self.unit() {
            // A number alone may be one of anything.
            _ if matches!(self.tree.node, Node::Number(_)) => Ok(()),
            Some(unit) if unit != expected => {
                let found = match check::pure_factor(&self.tree) {
                    Some(number) => format!(
                        "{}, where {number} is taken for a number without a unit; if it has one, make it a parameter with a `unit`",
                        check::one_in(unit)
                    ),
                    None => check::one_in(unit),
                };
                Err(FormulaError::new(0..self.text.len(), format!("a formula in {expected}"), found))
            }
            _ => Ok(()),
        }
    }

    /// Whether it uses the name at this position.
    #[must_use]
    pub fn uses(&self, name: usize) -> bool {
        self.tree.any(&|node| matches!(node, Node::Name { index, .. } if *index == name))
    }
}
