//! Where right-hand sides bend sharply: a Runge–Kutta step across a kink is as exact as its error control makes it, and how exact that is
//! jumps from rollout to rollout (Hairer, Nørsett & Wanner, "Solving ODEs I", II.6). Differences of such rollouts need a smaller tolerance.

use std::ops::Range;

use tunenet_formula::{Function, Node, Tree};

use super::runge_kutta::TOLERANCE;

/// The tolerance of rollouts whose right-hand side bends sharply somewhere.
pub(super) const SHARP_TOLERANCE: f64 = 1e-10;

/// The tolerance of a rollout.
pub(super) const fn tolerance(bends: bool) -> f64 {
    if bends { SHARP_TOLERANCE } else { TOLERANCE }
}

/// Whether the first derivative of a formula jumps, or is infinite, where what is at one of the `still` positions stays: at the zero of an
/// `abs`, a `cbrt`, a `min`, a `max` or a `clamp`. `abs(x)*x` and powers above 1 of `abs(x)` are smooth enough.
pub(super) fn bends(tree: &Tree, still: &Range<usize>) -> bool {
    let Node::Call { function, arguments } = &tree.node else { return false };
    let below = |all: &[Tree]| all.iter().any(|argument| bends(argument, still));
    match function {
        Function::Multiply => {
            let mut factors = Vec::new();
            multiplied(tree, &mut factors);
            let times_itself = |factor: &Tree| match magnitude(factor) {
                Some(of) => factors.iter().any(|other| same(other, of)),
                None => false,
            };
            factors.iter().any(|factor| !times_itself(factor) && bends(factor, still))
        }
        Function::Power => match (magnitude(&arguments[0]), &arguments[1].node) {
            (Some(of), Node::Number(exponent)) if *exponent > 1.0 => bends(of, still),
            _ => below(arguments),
        },
        Function::Abs | Function::Cbrt | Function::Min | Function::Max | Function::Clamp => {
            let moves = |node: &Node| matches!(node, Node::Name { index, .. } if !still.contains(index));
            tree.any(&moves)
        }
        _ => below(arguments),
    }
}

/// What an `abs` is applied to.
fn magnitude(tree: &Tree) -> Option<&Tree> {
    match &tree.node {
        Node::Call { function: Function::Abs, arguments } => arguments.first(),
        _ => None,
    }
}

/// The factors of a product of products.
fn multiplied<'a>(tree: &'a Tree, factors: &mut Vec<&'a Tree>) {
    match &tree.node {
        Node::Call { function: Function::Multiply, arguments } => {
            for argument in arguments {
                multiplied(argument, factors);
            }
        }
        _ => factors.push(tree),
    }
}

/// Whether two formulas are the same but for where they stand.
fn same(one: &Tree, other: &Tree) -> bool {
    match (&one.node, &other.node) {
        (Node::Number(a), Node::Number(b)) => a == b,
        (Node::Name { index: a, .. }, Node::Name { index: b, .. }) => a == b,
        (Node::Call { function: f, arguments: a }, Node::Call { function: g, arguments: b }) => {
            f == g && a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use tunenet_formula::{Formula, Name};

    use super::*;

    /// Of a state `x` and a parameter `c`.
    #[test]
    fn kinks_of_what_moves_are_sharp_and_squares_with_a_sign_are_not() {
        let names = ["x", "c"].map(|name| Name::new(name, None));
        let sharp = |text: &str| bends(Formula::parse(text, &names).unwrap().tree(), &(1..2));
        for text in [
            "abs(x)",
            "-c*abs(x)",
            "abs(x)^c*c",
            "sqrt(abs(x))",
            "max(x, c)",
            "cbrt(x)",
            "clamp(x, 0, 1)*x",
            "abs(x)^0.5",
        ] {
            assert!(sharp(text), "{text}");
        }
        for text in [
            "x^3",
            "-c*abs(x)*x",
            "x*(c*abs(x))",
            "abs(x)^1.5",
            "abs(c)*x",
            "max(c, 0)*x",
            "tanh(x/c)",
            "sqrt(x^2 + c)",
        ] {
            assert!(!sharp(text), "{text}");
        }
    }
}
