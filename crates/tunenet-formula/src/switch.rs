//! Switching surfaces: where the argument of a `sign` crosses zero, the right-hand side jumps (Filippov 1988).

use crate::tree::{Node, Tree};

/// The position of a surface among `surfaces`, to which it is added where it is not there yet.
pub(crate) fn position(surface: &Tree, surfaces: &mut Vec<Tree>) -> usize {
    let known = surfaces.iter().position(|other| same(surface, other));
    known.unwrap_or_else(|| {
        surfaces.push(surface.clone());
        surfaces.len() - 1
    })
}

/// Whether two trees are the same wherever they stand.
fn same(a: &Tree, b: &Tree) -> bool {
    match (&a.node, &b.node) {
        (Node::Call { function, arguments }, Node::Call { function: other, arguments: others }) => {
            function == other && arguments.iter().zip(others).all(|(a, b)| same(a, b))
        }
        (a, b) => a == b,
    }
}

#[cfg(test)]
mod tests {
    use crate::{Formula, Name, Program};

    #[test]
    fn equal_arguments_are_one_surface() {
        let names = ["v", "c", "d"].map(|name| Name::new(name, None));
        let mut surfaces = Vec::new();
        let compiled = |text: &str, surfaces: &mut Vec<_>| {
            Program::switched(Formula::parse(text, &names).unwrap().tree(), surfaces).unwrap()
        };
        let first = compiled("-c*sign(v) - d*sign( v - 1 )", &mut surfaces);
        let second = compiled("sign(v)", &mut surfaces);
        assert_eq!(surfaces.len(), 2);
        let side = |program: &Program, sides: &[f64]| program.run(&[5.0, 2.0, 3.0], sides, |_, _| 0.0);
        assert_eq!(side(&first, &[1.0, -1.0]), -2.0 + 3.0);
        assert_eq!(side(&second, &[-0.25, 0.0]), -0.25, "between both sides while it sticks");
    }
}
