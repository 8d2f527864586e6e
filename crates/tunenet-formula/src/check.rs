//! Dimensional analysis (Bridgman 1922): the unit of every node follows from those below, where they are known.
//!
//! A number may carry a unit that nobody wrote (9.81), so nothing is known of what it multiplies; the factors 0.5, 1, 2, 3 and 4
//! are taken as pure. A power whose exponent is no number is read as that of its base over its unit, and has no unit.

use std::ops::Range;

use crate::tree::{Node, Tree};
use crate::unit::Unit;
use crate::{FormulaError, Function, Name};

/// What follows of a formula's unit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Units {
    /// That of the whole formula, where it is known.
    pub unit: Option<Unit>,
    /// The places of powers of a base with a unit whose exponent is no number.
    pub powers_of_units: Vec<Range<usize>>,
}

/// Pure numbers.
const PURE: [f64; 6] = [0.5, 1.0, 2.0, 3.0, 4.0, 0.25];

/// The units of a tree whose names are resolved.
pub(crate) fn units(tree: &Tree, names: &[Name]) -> Result<Units, FormulaError> {
    let mut powers_of_units = Vec::new();
    let unit = of(tree, names, &mut powers_of_units)?;
    Ok(Units { unit, powers_of_units })
}

fn of(tree: &Tree, names: &[Name], powers: &mut Vec<Range<usize>>) -> Result<Option<Unit>, FormulaError> {
    let (function, arguments) = match &tree.node {
        Node::Number(value) => return Ok(PURE.contains(value).then(Unit::one)),
        Node::Name { index, .. } => return Ok(names[*index].unit.clone()),
        Node::Call { function, arguments } => (*function, arguments),
    };
    let each: Vec<Option<Unit>> = arguments.iter().map(|a| of(a, names, powers)).collect::<Result<_, _>>()?;
    let first = || each[0].clone();
    let power = |p: f64| each[0].as_ref().map(|unit| unit.power(p));
    Ok(match function {
        Function::Negate | Function::Abs => first(),
        Function::Sign => Some(Unit::one()),
        Function::Clamp => {
            if let (Some(low), Some(high)) = (number(&arguments[1]), number(&arguments[2]))
                && low > high
            {
                let place = arguments[1].place.start..arguments[2].place.end;
                return Err(FormulaError::new(
                    place,
                    "the lower bound before the upper one",
                    format!("{low} and {high}"),
                ));
            }
            equal(arguments, &each)?
        }
        Function::Add | Function::Subtract | Function::Min | Function::Max => equal(arguments, &each)?,
        Function::Atan2 => {
            equal(arguments, &each)?;
            Some(Unit::one())
        }
        Function::Multiply => each[0].as_ref().zip(each[1].as_ref()).map(|(a, b)| a.product(1.0, b, 1.0)),
        Function::Divide => each[0].as_ref().zip(each[1].as_ref()).map(|(a, b)| a.per(b)),
        Function::Power => {
            pure(&arguments[1], each[1].as_ref(), "an exponent")?;
            if let Some(exponent) = number(&arguments[1]) {
                power(exponent)
            } else {
                if each[0].as_ref().is_some_and(|unit| !unit.is_one()) {
                    powers.push(tree.place.clone());
                }
                Some(Unit::one())
            }
        }
        Function::Sqrt => power(0.5),
        Function::Cbrt => power(1.0 / 3.0),
        Function::Exp | Function::Ln | Function::Sin | Function::Cos | Function::Tan | Function::Tanh => {
            pure(&arguments[0], each[0].as_ref(), "a value")?;
            Some(Unit::one())
        }
        Function::Delay => {
            if let Some(unit) = each[1].as_ref().filter(|unit| Unit::parse("s").as_ref() != Some(*unit)) {
                let (place, found) = (arguments[1].place.clone(), one_in(unit));
                return Err(FormulaError::new(place, "a delay in s", found));
            }
            if let Some(delay) = number(&arguments[1]).filter(|delay| *delay < 0.0) {
                let (place, found) = (arguments[1].place.clone(), format!("{delay} s, which lies ahead"));
                return Err(FormulaError::new(place, "a delay of 0 s or more", found));
            }
            first()
        }
    })
}

/// The common unit of what is added or compared.
fn equal(arguments: &[Tree], each: &[Option<Unit>]) -> Result<Option<Unit>, FormulaError> {
    let mut common: Option<&Unit> = None;
    for (argument, unit) in arguments.iter().zip(each) {
        // Zero has any unit, and so has another number of which nothing is known.
        let Some(unit) = unit.as_ref().filter(|_| number(argument).is_none()) else { continue };
        match common {
            Some(before) if before != unit => {
                let (place, found) = (argument.place.clone(), one_in(unit));
                return Err(FormulaError::new(place, format!("a value in {before}, as before it"), found));
            }
            _ => common = Some(unit),
        }
    }
    Ok(common.cloned())
}

/// What was found, by its unit.
pub(crate) fn one_in(unit: &Unit) -> String {
    if unit.is_one() { "one without a unit".into() } else { format!("one in {unit}") }
}

/// Refuses a value with a unit where only a number makes sense.
fn pure(argument: &Tree, unit: Option<&Unit>, what: &str) -> Result<(), FormulaError> {
    match unit.filter(|unit| !unit.is_one()) {
        Some(unit) => Err(FormulaError::new(argument.place.clone(), format!("{what} without a unit"), one_in(unit))),
        None => Ok(()),
    }
}

/// The first number that is taken for one without a unit and multiplies or divides; exponents aside.
pub(crate) fn pure_factor(tree: &Tree) -> Option<f64> {
    match &tree.node {
        Node::Number(value) => PURE.contains(value).then_some(*value).filter(|value| *value != 1.0),
        Node::Call { function: Function::Power, arguments } => pure_factor(&arguments[0]),
        Node::Call { function: Function::Negate | Function::Multiply | Function::Divide, arguments } => {
            arguments.iter().find_map(pure_factor)
        }
        _ => None,
    }
}

/// The value of a node that is a number, with its sign.
pub(crate) fn number(tree: &Tree) -> Option<f64> {
    match &tree.node {
        Node::Number(value) => Some(*value),
        Node::Call { function: Function::Negate, arguments } => number(&arguments[0]).map(|value| -value),
        Node::Call { function: Function::Divide, arguments } => Some(number(&arguments[0])? / number(&arguments[1])?),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use crate::{Formula, Name, Unit};

    fn names() -> Vec<Name> {
        [("x", "m"), ("v", "m/s"), ("c", "1/m"), ("w", "m"), ("q", "rad"), ("p", "1"), ("tau", "s")]
            .map(|(name, unit)| Name::new(if name == "tau" { "late" } else { name }, Unit::parse(unit)))
            .into_iter()
            .chain([Name::new("free", None)])
            .collect()
    }

    #[test]
    fn units_follow_from_names() {
        for (text, wanted) in [
            ("-c*v^2", Some("m/s²")),
            ("-c*abs(v)*v", Some("m/s²")),
            ("exp(-(x/w)^2)", Some("1")),
            ("0.5*v^2", Some("m²/s²")),
            ("9.81*x", None),
            ("x + 1.7", Some("m")),
            ("sqrt(x/9.81)", None),
            ("free*x", None),
            ("x + free", Some("m")),
            ("sign(v)*x", Some("m")),
            ("v^(1/2)", Some("m^0.5/s^0.5")),
            ("v^p", Some("1")),
            ("max(x, 0)", Some("m")),
            ("sin(q)", Some("1")),
        ] {
            let formula = Formula::parse(text, &names()).unwrap();
            assert_eq!(formula.unit().map(ToString::to_string).as_deref(), wanted, "{text}");
        }
        assert_eq!(Formula::parse("1 + v^p", &names()).unwrap().powers_of_units(), std::slice::from_ref(&(4..7)));
        assert!(Formula::parse("(v/1)^2*p", &names()).unwrap().powers_of_units().is_empty());
    }

    #[test]
    fn what_contradicts_is_refused_at_its_place() {
        for (text, at, wanted) in [
            ("x + v", 4, "expected a value in m, as before it, found one in m/s"),
            ("sin(x)", 4, "expected a value without a unit, found one in m"),
            ("2^x", 2, "expected an exponent without a unit, found one in m"),
            ("x * exp(v)", 8, "expected a value without a unit, found one in m/s"),
            ("delay(v, x)", 9, "expected a delay in s, found one in m"),
            ("x + y_m", 4, "expected one of x, v, c, w, q, p, late, free, found `y_m`"),
            ("e*x", 0, "which is no constant here: write the number"),
            ("sin", 0, "found the function `sin` without brackets"),
        ] {
            let refused = Formula::parse(text, &names()).unwrap_err();
            assert!(refused.to_string().contains(wanted), "{text}: {refused}");
            assert_eq!(refused.place.start, at, "{text}");
        }
        let speed = Unit::parse("m/s").unwrap();
        let refused = Formula::parse("c*x", &names()).unwrap().require_unit(&speed).unwrap_err();
        assert_eq!(refused.to_string(), "expected a formula in m/s, found one without a unit");
        assert!(Formula::parse("2.5*x", &names()).unwrap().require_unit(&speed).is_ok());
        for text in ["2*x", "-x*2", "x/(w/4)*w^2/w*2"] {
            let refused = Formula::parse(text, &names()).unwrap().require_unit(&speed).unwrap_err();
            assert!(refused.to_string().contains("is taken for a number without a unit"), "{text}: {refused}");
        }
    }
}
