//! Which part of a formula has no finite value: for the message of a rollout that cannot go on.

use crate::{Formula, Function, Node, Tree};

/// Magnitudes beyond this are as good as a division by 0: steps that approach it end before they meet it.
const HUGE: f64 = 1e8;

/// A part of a formula without a finite value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undefined<'a> {
    /// As it is written.
    pub text: &'a str,
    /// What is wrong with it, as the verb of a sentence.
    pub what: &'static str,
}

impl Formula {
    /// The innermost part that is not finite or huge although none of its arguments is; nothing where all are finite.
    #[must_use]
    pub fn undefined(&self, values: &[f64]) -> Option<Undefined<'_>> {
        let (found, of) = value(self.tree(), values).err()?;
        let what = if of.is_nan() { "has no real value" } else { "grows beyond all bounds" };
        Some(Undefined { text: self.text().get(found.place.clone())?, what })
    }
}

/// The value of a tree, or the part of it that has none and what it gives.
fn value<'a>(tree: &'a Tree, values: &[f64]) -> Result<f64, (&'a Tree, f64)> {
    let (found, most) = match &tree.node {
        Node::Number(number) => return Ok(*number),
        // Coefficients of candidates, which stand in no array of the equations, do not occur in the equations themselves.
        Node::Name { index, .. } => return Ok(values.get(*index).copied().unwrap_or(0.0)),
        Node::Call { function, arguments } => {
            let arguments = arguments.iter().map(|one| value(one, values)).collect::<Result<Vec<_>, _>>()?;
            // Sums and products are as large as their arguments make them.
            let most = match function {
                Function::Add | Function::Subtract | Function::Multiply | Function::Negate => f64::INFINITY,
                _ => HUGE * arguments.iter().fold(1.0, |most: f64, one| most.max(one.abs())),
            };
            (function.apply(&arguments), most)
        }
    };
    if found.abs() < most { Ok(found) } else { Err((tree, found)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Name;

    #[test]
    fn the_innermost_part_without_a_value_is_found() {
        let names = ["q", "k"].map(|name| Name::new(name, None));
        let formula = |text: &str| Formula::parse(text, &names).unwrap();
        let undefined = |formula: &Formula, values: &[f64]| {
            formula.undefined(values).map(|one| format!("{} {}", one.text, one.what))
        };
        let one = formula("2 * (1 + k / q) - sqrt(k)");
        assert_eq!(undefined(&one, &[0.0, 3.0]).unwrap(), "k / q grows beyond all bounds");
        assert_eq!(undefined(&one, &[2.0, -3.0]).unwrap(), "sqrt(k) has no real value");
        assert_eq!(undefined(&one, &[2.0, 3.0]), None);
        assert_eq!(undefined(&formula("ln(q)"), &[0.0, 0.0]).unwrap(), "ln(q) grows beyond all bounds");
        assert_eq!(undefined(&formula("ln(q)"), &[-1.0, 0.0]).unwrap(), "ln(q) has no real value");
        // A product of large numbers is what it looks like; a quotient near a pole is not.
        assert_eq!(undefined(&formula("q * k"), &[1e5, 1e7]), None);
        assert_eq!(undefined(&formula("k / q"), &[1e-12, 3.0]).unwrap(), "k / q grows beyond all bounds");
    }
}
