//! The syntax tree of a formula.

use std::ops::Range;

use crate::{CONSTANTS, FormulaError, Function, Name};

/// A node and its place in the text, in bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// What it is.
    pub node: Node,
    /// Where it stands.
    pub place: Range<usize>,
}

/// What a node is.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// A number as it is written.
    Number(f64),
    /// A name, and its position among the names that the formula may use.
    Name {
        /// As it is written.
        text: String,
        /// Its position.
        index: usize,
    },
    /// An operator or a function, and what it is applied to.
    Call {
        /// What is applied.
        function: Function,
        /// To what.
        arguments: Vec<Tree>,
    },
}

impl Tree {
    /// Finds the position of every name.
    pub(crate) fn resolve(&mut self, names: &[Name]) -> Result<(), FormulaError> {
        match &mut self.node {
            Node::Number(_) => Ok(()),
            Node::Call { arguments, .. } => arguments.iter_mut().try_for_each(|argument| argument.resolve(names)),
            Node::Name { text, index } => {
                let Some(at) = names.iter().position(|known| known.name == *text) else {
                    return Err(unknown(text, self.place.clone(), names));
                };
                *index = at;
                Ok(())
            }
        }
    }

    /// Whether any node passes a test.
    #[must_use]
    pub fn any(&self, test: &dyn Fn(&Node) -> bool) -> bool {
        let below = match &self.node {
            Node::Call { arguments, .. } => arguments.iter().any(|argument| argument.any(test)),
            _ => false,
        };
        below || test(&self.node)
    }

    /// The nodes at which `find` yields something, in the order of the text.
    pub fn collect<'a, T>(&'a self, find: &mut impl FnMut(&'a Tree) -> Option<T>) -> Vec<T> {
        let mut found: Vec<T> = match &self.node {
            Node::Call { arguments, .. } => arguments.iter().flat_map(|argument| argument.collect(find)).collect(),
            _ => Vec::new(),
        };
        found.extend(find(self));
        found
    }
}

fn unknown(text: &str, place: Range<usize>, names: &[Name]) -> FormulaError {
    let known = names.iter().map(|known| known.name.as_str()).collect::<Vec<_>>().join(", ");
    let found = if CONSTANTS.contains(&text) {
        format!("`{text}`, which is no constant here: write the number")
    } else if Function::named(text).is_some() {
        format!("the function `{text}` without brackets")
    } else {
        format!("`{text}`")
    };
    FormulaError::new(place, format!("one of {known}"), found)
}
