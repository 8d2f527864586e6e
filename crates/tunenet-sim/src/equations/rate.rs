//! Forward-mode differentiation (Wengert, "A simple automatic derivative evaluation program", CACM 7, 1964): a formula and how fast
//! it changes along a motion.

use tunenet_formula::{Function, Node, Tree};

/// The value of a formula and its derivative by time, from those of all names. `sign` and `delay` are no functions here: sides and
/// delayed inputs are names.
pub(super) fn rate(tree: &Tree, values: &[f64], rates: &[f64]) -> (f64, f64) {
    let (function, arguments) = match &tree.node {
        Node::Number(value) => return (*value, 0.0),
        Node::Name { index, .. } => return (values[*index], rates[*index]),
        Node::Call { function, arguments } => (*function, arguments),
    };
    let of = |i: usize| rate(&arguments[i], values, rates);
    let (a, da) = of(0);
    if arguments.len() == 1 {
        let value = function.apply(&[a]);
        return (value, if da == 0.0 { 0.0 } else { slope(function, a, value, da) });
    }
    let (b, db) = of(1);
    if arguments.len() == 3 {
        let (c, dc) = of(2);
        let low = if a >= b { (a, da) } else { (b, db) };
        return if low.0 <= c { low } else { (c, dc) };
    }
    let value = function.apply(&[a, b]);
    let change = match function {
        Function::Add => da + db,
        Function::Subtract => da - db,
        Function::Multiply => da * b + a * db,
        Function::Divide => (da - value * db) / b,
        Function::Power => power((a, da), (b, db), value),
        Function::Min => {
            if a < b || (a == b && da < db) {
                da
            } else {
                db
            }
        }
        Function::Max => {
            if a > b || (a == b && da > db) {
                da
            } else {
                db
            }
        }
        Function::Atan2 => (da * b - a * db) / (a * a + b * b),
        _ => 0.0,
    };
    (value, change)
}

/// The derivative of a function of one value that changes.
fn slope(function: Function, a: f64, value: f64, da: f64) -> f64 {
    match function {
        Function::Negate => -da,
        // Along the motion: at zero the magnitude grows.
        Function::Abs => {
            if a == 0.0 {
                da.abs()
            } else {
                a.signum() * da
            }
        }
        Function::Sqrt => 0.5 * da / value,
        Function::Cbrt => da / (3.0 * value * value),
        Function::Exp => value * da,
        Function::Ln => da / a,
        Function::Sin => a.cos() * da,
        Function::Cos => -a.sin() * da,
        Function::Tan => da * (1.0 + value * value),
        Function::Tanh => da * (1.0 - value * value),
        _ => 0.0,
    }
}

fn power((a, da): (f64, f64), (b, db): (f64, f64), value: f64) -> f64 {
    let of_base = if da == 0.0 { 0.0 } else { b * a.powf(b - 1.0) * da };
    let of_exponent = if db == 0.0 { 0.0 } else { value * a.ln() * db };
    of_base + of_exponent
}

#[cfg(test)]
mod tests {
    use tunenet_formula::{Formula, Name};

    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        let names = ["x", "y", "z"].map(|name| Name::new(name, None));
        let (at, moving) = ([0.7, 1.3, -0.4], [0.5, -1.1, 0.9]);
        for text in [
            "x*y - z/x + 3",
            "x^y + y^3 + y^-0.5",
            "sin(x)*cos(y) + tan(z) + tanh(x)",
            "sqrt(y) + cbrt(x) + exp(z) - ln(y)",
            "atan2(x, z) - abs(z)",
            "min(x, y) + max(x, z)",
            "clamp(x, 0.2, 2) + clamp(y, 0, 1) - clamp(z, -0.1, 1)",
        ] {
            let tree = Formula::parse(text, &names).unwrap().tree().clone();
            let shifted = |h: f64| -> f64 {
                let values: Vec<f64> = at.iter().zip(&moving).map(|(v, r)| v + h * r).collect();
                rate(&tree, &values, &[0.0; 3]).0
            };
            let difference = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
            let (_, change) = rate(&tree, &at, &moving);
            assert!((change - difference).abs() < 1e-7, "{text}: {change} {difference}");
        }
    }
}
