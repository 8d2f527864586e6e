//! Poles that a motion passes between two instants: by a divisor's change of sign, bracketed by bisection (Press et al. 1992, section 9.1).

use std::ops::Range;

use crate::{Formula, FormulaError, Function, Node, Program, Tree};

/// How near to the zero of a divisor its quotient is evaluated, as a share of the way between both instants.
const NEAR: f64 = 1e-7;
/// A quotient that is larger there than at both instants by this factor has a pole: one that grows as 1/x does by 1/[`NEAR`].
const GROWTH: f64 = 1e4;
const BISECTIONS: usize = 60;

/// A divisor that may vanish, and the quotient that it divides.
#[derive(Debug, Clone, PartialEq)]
pub struct Divisor {
    place: Range<usize>,
    of: Program,
    quotient: Program,
}

impl Formula {
    /// The divisors that use names for which `moves` holds, and bases of powers with a negative or unknown exponent.
    ///
    /// # Errors
    /// Where a part of the formula cannot be evaluated alone.
    pub fn divisors(&self, moves: &dyn Fn(usize) -> bool) -> Result<Vec<Divisor>, FormulaError> {
        let mut all = Vec::new();
        let quotients = self.tree().collect(&mut |tree| Some(tree).filter(|tree| divides(tree)));
        for quotient in quotients {
            let Node::Call { function, arguments } = &quotient.node else { continue };
            let mut factors = Vec::new();
            match function {
                Function::Divide => gather(&arguments[1], &mut factors),
                // tan(x) is sin(x)/cos(x).
                Function::Tan => {
                    let node = Node::Call { function: Function::Cos, arguments: arguments.clone() };
                    factors.push(Tree { node, place: quotient.place.clone() });
                }
                _ => gather(&arguments[0], &mut factors),
            }
            let is_moving = |tree: &Tree| tree.any(&|node| matches!(node, Node::Name { index, .. } if moves(*index)));
            for factor in factors.into_iter().filter(|factor| is_moving(factor)) {
                let (of, whole) = (Program::compile(&factor)?, Program::compile(quotient)?);
                all.push(Divisor { place: quotient.place.clone(), of, quotient: whole });
            }
        }
        Ok(all)
    }

    /// The first quotient with a pole between two instants with these values of all names, as it is written.
    #[must_use]
    pub fn pole_between<'a>(&'a self, divisors: &[Divisor], from: &[f64], to: &[f64]) -> Option<&'a str> {
        let found = divisors.iter().find(|divisor| divisor.has_pole_between(from, to))?;
        self.text().get(found.place.clone())
    }
}

impl Divisor {
    fn has_pole_between(&self, from: &[f64], to: &[f64]) -> bool {
        let at = |share: f64| -> Vec<f64> { from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect() };
        let (first, last) = (self.of.value(from), self.of.value(to));
        // What is 0/0 at the zero is finite next to it.
        let size = |share: f64| self.quotient.value(&at(share)).abs();
        if last == 0.0 && first != 0.0 {
            return size(1.0 - NEAR) > GROWTH * size(0.0);
        }
        if first * last >= 0.0 || !(first * last).is_finite() {
            return false;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.of.value(&at(middle)) * first > 0.0 { low = middle } else { high = middle }
        }
        let near = size(low - NEAR).min(size(high + NEAR));
        near > GROWTH * size(0.0).max(size(1.0))
    }
}

/// Whether a node divides by what may vanish.
fn divides(tree: &Tree) -> bool {
    match &tree.node {
        Node::Call { function: Function::Divide | Function::Tan, .. } => true,
        Node::Call { function: Function::Power, arguments } => {
            crate::check::number(&arguments[1]).is_none_or(|exponent| exponent < 0.0)
        }
        _ => false,
    }
}

/// The factors of a divisor whose zero is one of it.
fn gather(tree: &Tree, into: &mut Vec<Tree>) {
    match &tree.node {
        Node::Call { function: Function::Multiply, arguments } => arguments.iter().for_each(|one| gather(one, into)),
        Node::Call { function: Function::Power | Function::Negate | Function::Abs | Function::Sqrt, arguments } => {
            gather(&arguments[0], into);
        }
        _ => into.push(tree.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Name;

    fn passes(text: &str, from: f64, to: f64) -> Option<String> {
        let names = ["x", "k"].map(|name| Name::new(name, None));
        let formula = Formula::parse(text, &names).unwrap();
        let divisors = formula.divisors(&|index| index == 0).unwrap();
        formula.pole_between(&divisors, &[from, 3.0], &[to, 3.0]).map(str::to_owned)
    }

    #[test]
    fn a_pole_is_found_where_a_divisor_changes_its_sign() {
        assert_eq!(passes("1 + k/(x - 0.5)", 0.4999, 0.5003).unwrap(), "k/(x - 0.5)");
        assert_eq!(passes("k/(x - 0.5)^2", 0.4, 0.6).unwrap(), "k/(x - 0.5)^2");
        assert_eq!(passes("(x - 0.5)^(-2)", 0.4, 0.6).unwrap(), "(x - 0.5)^(-2)");
        assert_eq!(passes("k/abs(k*x)", -0.1, 0.2).unwrap(), "k/abs(k*x)");
        assert_eq!(passes("k/(x - 0.5)", 0.6, 0.8), None);
        assert_eq!(passes("2 + tan(k*x)", 0.5, 0.55).unwrap(), "tan(k*x)");
        assert_eq!(passes("tan(k*x)", 0.6, 0.7), None);
        // A pole that lies on the later instant.
        assert_eq!(passes("k/(x - 0.5)", 0.4, 0.5).unwrap(), "k/(x - 0.5)");
        assert_eq!(passes("k/(x - 0.5)", 0.5, 0.6), None);
    }

    /// sin(x)/x is 1 at 0, and 1/√|x| can be integrated over it.
    #[test]
    fn what_stays_finite_or_can_be_integrated_is_no_pole() {
        assert_eq!(passes("sin(x)/x", -0.3, 0.2), None);
        assert_eq!(passes("k/sqrt(abs(x))", -0.3, 0.2), None);
        assert_eq!(passes("x/k", -0.3, 0.2), None);
        assert_eq!(passes("1/(x - x)", -0.3, 0.2), None);
    }
}
